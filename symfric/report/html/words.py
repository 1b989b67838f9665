"""Numbers and symbols in sentences and tables: digits, units, powers of ten, names set as mathematics."""

import math
import re
from collections.abc import Iterable

import sympy as sp
from markupsafe import Markup, escape
from sympy.core.alphabets import greeks

from symfric.model.symbols import superscript
from symfric.report.html.mathml import inline
from symfric.scenefile import SceneFile

_EXPONENT = re.compile(r"(?<=\d)e([+-]\d+)\b")
_MINUS = re.compile(r"(?<=[ (])-(?=\d)")  # of a number
LISTED = 6  # names in a sentence


def measure(value: float, name: str, file: SceneFile) -> str:
    """Return a number with the unit of a state or value."""
    return measured(value, file.units.get(name, ""))


def measured(value: float, unit: str = "") -> str:
    """Return a number of five digits with its unit."""
    return f"{powers_of_ten(f'{value:.5g}').replace('-', '−')}{' ' + unit if unit else ''}"


def powers_of_ten(text: str) -> str:
    """Return a number in text with a power of ten in the place of an e."""
    return _EXPONENT.sub(lambda m: "·10" + superscript(int(m.group(1))), text)


def angular_frequency(value: float, file: SceneFile) -> str:
    """Return an angular frequency with its unit, and in Hz where time has one."""
    hertz = file.units.hertz
    return measured(value, file.units.angular) + (f" ({value * hertz:.4g} Hz)" if math.isfinite(hertz) else "")


def percent(value: float) -> str:
    """Return a relative difference as a percentage."""
    if not math.isfinite(value):
        return "–"
    if abs(value) < 1e-12:
        return "< 10⁻¹²"
    size = 100 * value
    text = f"{size:+.2f} %" if abs(size) >= 0.01 else f"{size:+.2g} %"
    return powers_of_ten(text).replace("-", "−")


def listed(names: list[str]) -> str:
    """Return names in a sentence, the first few of many."""
    more = len(names) - LISTED
    return ", ".join(names[:LISTED]) + (f" and {more} more" if more > 0 else "")


def number(value: float, digits: int = 6) -> str:
    """Return a number for a table."""
    if not math.isfinite(value):
        return "–"
    mantissa, _, exponent = f"{value:.{digits}g}".replace("-", "−").partition("e")
    power = str(int(exponent.replace("−", "-"))).replace("-", "−") if exponent else ""
    return Markup("{}·10<sup>{}</sup>").format(mantissa, power) if power else mantissa


def with_unit(value: str, unit: str) -> str:
    """Return a number for a table with its unit."""
    return Markup("{} {}").format(value, unit) if unit else value


def inline_name(name: str) -> Markup:
    """Return a name as inline mathematics."""
    return inline(sp.Symbol(name))


def typeset(text: str, names: Iterable[str], expressions: Iterable[sp.Expr] = ()) -> Markup:
    """Return a sentence with the names of symbols set as mathematics, and powers of ten.

    A name of one or two plain letters may be a word; it counts where a number follows, as in "a = 2". Of `expressions`,
    each counts where a sentence on contacts has it.
    """
    formulas = {str(e): e for e in expressions if not e.is_number}
    known = sorted({n for n in names if n.isidentifier()}, key=len, reverse=True)
    odd = [n for n in known if "_" in n or n[-1].isdigit() or n.lower() in (*greeks, "lambda")]
    forms = [
        rf"(?<={place} ){re.escape(n)}(?=[ ,.;]|$)"
        for n in sorted(formulas, key=len, reverse=True)
        for place in ("slipping at", "load", "profile", "gap", "restitution")
    ]
    forms += [rf"{re.escape(n)}(?= = )" for n in known] + [rf"{re.escape(n)}(?![\w(])" for n in odd]
    forms += [rf"(?<={place} ){re.escape(n)}(?!\w)" for n in known for place in ("half range of", "mean of", "against")]
    forms += [rf"(?<=Velocity ){re.escape(n)}(?!\w)" for n in known]
    forms += [rf"\b{re.escape(n)}(?= (?:at rest|comes to rest|lies between)\b)" for n in known]
    text = _MINUS.sub("−", powers_of_ten(text)).replace("M^-1 B", "M⁻¹B")
    if not forms:
        return escape(text)
    parts = re.split(r"(?<![\w.])(" + "|".join(forms) + ")", text)
    set_in_letters = (
        (inline(formulas[p]) if p in formulas else inline_name(p)) if k % 2 else escape(p) for k, p in enumerate(parts)
    )
    return Markup("").join(set_in_letters)
