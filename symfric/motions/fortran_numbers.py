"""Parse numbers in Fortran format: no leading zeros, adjacent fields without blanks, asterisks for overflow."""

import re

import numpy as np

from symfric.errors import SceneError

_REAL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?")
_PLAIN = re.compile(r"[-+.\deE\s]*")
_NOT_FINITE = re.compile(r"[+-]?\b(?:nan|inf(?:inity)?)\b", re.IGNORECASE)


def parse_numbers(name: str, rows: list[str], skip: int, first: int = 1) -> tuple[np.ndarray, int]:
    """Return every number of the lines after the first `skip`, and the number of the last line that has one.

    Parameters
    ----------
    name : str
        For messages.
    rows : list of str
    skip : int
    first : int
        Number of the first of `rows` in its file.

    Raises
    ------
    SceneError
        If anything is no number, is not finite, or touches its neighbour so that they cannot be told apart.
    """
    body = rows[skip:]
    last = next((k for k in range(len(body) - 1, -1, -1) if body[k].strip()), 0) + skip + first
    text = "\n".join(body)
    if _PLAIN.fullmatch(text):
        try:
            values = np.array(text.split(), dtype=float)
        except ValueError:
            pass
        else:
            if np.all(np.isfinite(values)):
                return values, last
    decimals = _decimals(body)
    fields = [v for k, row in enumerate(body) for v in _line(row, decimals, f"{name}, line {k + skip + first}")]
    return np.array(fields, dtype=float), last


def _decimals(rows: list[str]) -> int | None:
    """Return the number of decimals that all fields standing alone have, or None if they differ."""
    alone = {len(m[1]) for row in rows for m in re.finditer(r"(?<!\S)[+-]?\d*\.(\d+)(?:[EeDd][+-]?\d+)?(?!\S)", row)}
    return alone.pop() if len(alone) == 1 else None


def _line(row: str, decimals: int | None, where: str) -> list[float]:
    """Return the numbers of one line."""
    fields, end = [], 0
    for number in _REAL.finditer(row):
        _check_between(row, end, number.start(), where)
        if number.start() == end > 0 and number[0][0] not in "+-":
            fields = _of_equal_decimals(row, decimals, where)
            break
        fields.append(number[0])
        end = number.end()
    else:
        _check_between(row, end, len(row), where)
    values = [float(re.sub("[dD]", "e", f)) for f in fields]
    if not np.all(np.isfinite(values)):
        raise SceneError(f"{where}: holds a number too large; get the file anew")
    return values


def _of_equal_decimals(row: str, decimals: int | None, where: str) -> list[str]:
    """Split touching fields by their number of decimals, as a format such as 8F10.5 fixes it."""
    if decimals is not None:
        field = re.compile(rf"\s*([+-]?\d*\.\d{{{decimals}}}(?:[EeDd][+-]?\d\d)?)")
        fields, end = [], 0
        while field_match := field.match(row, end):
            fields.append(field_match[1])
            end = field_match.end()
        if not row[end:].strip():
            return fields
    raise SceneError(f"{where}: numbers touch and cannot be told apart; put blanks between them")


def _check_between(row: str, begin: int, end: int, where: str) -> None:
    """Raise unless only blanks or a comma separate two numbers; other text is not quoted in the message.

    A scene file from another source may name any file of its user as a record.
    """
    text = row[begin:end]
    if not text.strip() or text.strip() == ",":
        return
    odd = _NOT_FINITE.search(text)
    if odd:
        raise SceneError(f"{where}: holds {odd[0]!r}, not a finite number; mend the record, no sample is made up here")
    if "*" in text:
        raise SceneError(f"{where}: holds asterisks, for a number that did not fit its field; get the file anew")
    column = begin + len(text) - len(text.lstrip()) + 1
    raise SceneError(f"{where}, column {column}: is no row of numbers; remove the line or mend it")
