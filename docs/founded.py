"""Numbers in prose: each must be printed by a cell of its page, or stand in the code of one."""

import re
from collections.abc import Iterable

NUMBER = re.compile(r"(?<![\w.^])[-−]?\d+(?:[ ,]\d{3})*(?:\.\d+)?(?:[eE][+-]?\d+)?(?![\w.]*\d)")
_ANY = re.compile(r"\d+\.\d+(?:e[+-]?\d+)?|\d+e[+-]?\d+|\d+")
_SCALES = (1.0, 1e3, 1e-3, 1e2, 1e-2)  # other units: thousands, thousandths, percent
_SMALL = 10  # whole numbers below are counts and words


def values(text: str) -> list[float]:
    """Return the absolute values of all numbers of a text.

    Parameters
    ----------
    text : str
    """
    whole = (re.sub(r"[ ,−-]", "", n) for n in NUMBER.findall(re.sub(r"e-", "E", text)))
    return [float(n) for n in _ANY.findall(text)] + [float(n) for n in whole if "E" not in n]


def unfounded(prose: Iterable[str], known: Iterable[float]) -> list[str]:
    """Return the numbers of a prose that no known number rounds to, as it is or in other units.

    Parameters
    ----------
    prose : iterable of str
    known : iterable of float
        Absolute values.
    """
    known = list(known)
    return [n for line in prose for n in NUMBER.findall(line) if not _founded(n, known)]


def _founded(said: str, known: list[float]) -> bool:
    plain = re.sub(r"[ ,]", "", said.lstrip("-−")).lower()
    value = float(plain)
    if plain.isdigit() and value < _SMALL:
        return True
    mantissa, _, exponent = plain.partition("e")
    step = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return any(abs(k * scale - value) <= 0.5 * step * (1 + 1e-9) for k in known for scale in _SCALES)
