"""Files of strong-motion records: the PEER format AT2 in its variants, and plain columns of numbers."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from symfric.errors import SceneError
from symfric.files import read_regular
from symfric.model.symbols import finite, nearest, shortened
from symfric.motions.fortran_numbers import parse_numbers
from symfric.motions.motion import Motion
from symfric.motions.units import KNOWN, factor_of, is_acceleration
from symfric.spelling import spelt

MAX_BYTES = 50_000_000
HEADER_LINES = 40  # number of first lines that must contain NPTS and DT
_REAL = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?"
_NAMED = re.compile(rf"NPTS\s*=\s*(\d+)\s*[,;]?\s*DT\s*=\s*({_REAL}|[-+]?(?:nan|inf)(?:inity)?\b)", re.IGNORECASE)
_NUMBERS_FIRST = re.compile(rf"^\s*(\d+)\s+({_REAL})\s*,?\s*NPTS\s*,?\s*DT\b", re.IGNORECASE)
_UNIT = re.compile(r"\bunits?\s*(?:of|are|is|:|=)?\s*\(?\s*([a-z][\w/*^²().-]*)", re.IGNORECASE)
_BESIDE = re.compile(r"\baccel[a-z]*\.?\s*(?:,|:|in|\(|\[)\s*\(?\s*([a-z][\w/*^²().-]*)", re.IGNORECASE)
_FIELDS = re.compile(r"[\s,;]+")
_QUANTITY = re.compile(r"\b(velocity|displacement)\b", re.IGNORECASE)
_IN_BRACKETS = re.compile(r"[(\[]\s*(c?m|mm|in)\s*/\s*s(?:ec)?\s*[)\]]", re.IGNORECASE)


class Lines(NamedTuple):
    """The lines of a text file and its name for messages."""

    name: str
    rows: list[str]


def read_lines(path: str | Path) -> Lines:
    """Return the lines of a text file whose lines end with LF, CR LF or CR CR LF.

    Raises
    ------
    SceneError
        If it is missing, a folder, empty, too large, or not text.
    """
    if not isinstance(path, str | Path):
        raise SceneError(f"path is {shortened(path)}; give the path of a file")
    path = Path(path)
    name = str(path)
    try:
        if path.is_dir():
            raise SceneError(f"{name} is a folder; name a record in it")
        if not path.exists():
            beside = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
            hint = nearest(path.name, beside) if beside else ""
            raise SceneError(f"{name}: no such file" + (hint if "did you" in hint else "; check the path"))
        if not path.is_file():
            raise SceneError(f"{name} is not a regular file; name a record")
        data = read_regular(path, MAX_BYTES)
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"{name} cannot be read ({reason}); check the path and its permissions") from None
    if len(data) > MAX_BYTES:
        raise SceneError(f"{name} is larger than {MAX_BYTES // 1_000_000} MB; a record is a column of numbers")
    if not data.strip():
        raise SceneError(f"{name} is empty; get the file anew")
    strange = re.search(rb"[\x00-\x08\x0e-\x19\x1b-\x1f\x7f]", data)
    if strange:
        line = data.count(b"\n", 0, strange.start()) + 1
        raise SceneError(f"{name}, line {line}: is binary; export the record as text")
    text = data.rstrip(b"\x1a").decode("utf-8-sig" if data.startswith(b"\xef\xbb\xbf") else "latin-1", "replace")
    return Lines(name, re.split(r"\r*\n|\r", text))


@spelt
def read_at2(path: str | Path, *, dt: float | None = None, unit: str | None = None) -> Motion:
    r"""Read a record in the PEER format AT2.

    Parameters
    ----------
    path : str or Path
    dt : float, optional
        The step in full digits where the file has it rounded: 1/409.6 for .00244.
    unit : str, optional
        Unit of the samples, for files whose header says none.

    Returns
    -------
    Motion
        In m/s^2, with the file's name, and the event of its second line as `note`.

    Raises
    ------
    SceneError
        If the line with NPTS and DT is missing, the numbers do not add up to NPTS, one of them is none or not finite,
        or they are no accelerations; it names the file, the line and the cure.

    Notes
    -----
    ``NPTS= 4000, DT= .01 SEC`` or ``4096 0.01 NPTS, DT`` ends the header, wherever it stands in the first forty lines.
    The numbers after it may touch, as in the format 8F10.5, and line ends may be CR CR LF.

    Examples
    --------
    >>> import symfric as sf
    >>> from pathlib import Path
    >>> head = ["PEER STRONG MOTION RECORD", "A quake", "ACCELERATION IN UNITS OF G", "NPTS=    4, DT=   .0100 SEC"]
    >>> _ = Path("record.AT2").write_text("\n".join([*head, " 0.000E+00 1.000E-01 -2.000E-01 0.000E+00", ""]))
    >>> round(sf.motions.read_at2("record.AT2").pga_g, 6)
    0.2
    """
    name, rows = read_lines(path)
    number, stated = _header_line(name, rows)
    count, printed = int(stated[1]), stated[2]
    step = _step(printed, dt, f"{name}, line {number}")
    if count < 2:
        raise SceneError(f"{name}, line {number}: NPTS is {count}; a record has at least two samples")
    unit = _at2_unit(name, rows[:number], unit)
    samples, last = parse_numbers(name, _without_end_mark(rows), number)
    if samples.size != count:
        fault, cure = (
            ("it is truncated", "get the file anew")
            if samples.size < count
            else ("they do not add up", "correct NPTS, or remove what does not belong to the record")
        )
        raise SceneError(
            f"{name}, line {last}: ends after {samples.size} numbers, and line {number} says NPTS = {count}; "
            f"{fault}: {cure}"
        )
    return Motion(samples, step, unit, Path(path).stem, rows[1].strip() if number > 2 else "")


def _without_end_mark(rows: list[str]) -> list[str]:
    """Return the lines without a last one such as ``*** End Data ***``."""
    end = max((k for k, row in enumerate(rows) if row.strip()), default=0)
    return rows[:end] if re.fullmatch(r"\s*\*+\s*end\b[\w\s]*\**\s*", rows[end], re.IGNORECASE) else rows


def _header_line(name: str, rows: list[str]) -> tuple[int, re.Match[str]]:
    """Return the number, from 1, of the line with NPTS and DT."""
    for number, row in enumerate(rows[:HEADER_LINES], 1):
        stated = _NAMED.search(row) or _NUMBERS_FIRST.match(row)
        if stated:
            return number, stated
        if re.search("NPTS", row, re.IGNORECASE):
            raise SceneError(
                f"{name}, line {number}: NPTS and DT cannot be read; write the line as NPTS= 4000, DT= .01000 SEC"
            )
    raise SceneError(
        f"{name}: no line with NPTS and DT in its first {min(len(rows), HEADER_LINES)}; it is no AT2 file or has lost "
        "its header: add the line, or read it with read_text(path, dt=..., unit=...)"
    )


def _step(printed: str, given: float | None, where: str) -> float:
    """Return the step of a header, or the given one if it rounds to that."""
    try:
        step = float(re.sub("[dD]", "e", printed)) if printed[-1].isdigit() or printed[-1] == "." else float("nan")
    except ValueError:
        step = float("nan")
    if not 0 < step < np.inf:
        raise SceneError(f"{where}: DT is {printed}; it must be a positive number of seconds")
    if given is None:
        return step
    given = finite(given, "dt")
    digits, _, power = printed.lower().replace("d", "e").partition("e")
    unit_in_last_place = 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))
    if abs(given - step) > 0.51 * unit_in_last_place:
        raise SceneError(f"{where}: DT is {printed} and dt is given as {given:g}, which does not round to it; drop one")
    return given


def _stated_beside(row: str) -> re.Match[str] | None:
    """Return the unit in a header such as ``Acceleration in g`` or ``Acceleration (cm/s^2)``, as its group 1."""
    return next((m for m in _BESIDE.finditer(row) if is_acceleration(m[1].rstrip(".,;)]"))), None)


def _at2_unit(name: str, header: list[str], given: str | None) -> str:
    """Return the unit of the samples from the header, or the given one where the header has none."""
    for number, row in enumerate(header, 1):
        other = _QUANTITY.search(row)
        if other and re.search(r"time|history|series|units|record", row, re.IGNORECASE):
            raise SceneError(
                f"{name}, line {number}: a {other[1].lower()}; take the record of the acceleration, which ends with "
                ".AT2 at PEER"
            )
        stated = _UNIT.search(row) or _stated_beside(row)
        if stated:
            unit = stated[1].rstrip(".,;)]").lstrip("(")
            factor = factor_of(unit, f"{name}, line {number}: the unit", quoted=False)
            if given is not None and factor_of(given, "unit") != factor:
                raise SceneError(f"{name}, line {number}: the unit is {unit}, and unit={given!r} is given; drop one")
            return unit
    if given is None:
        raise SceneError(f"{name}: its header names no unit; find out, and give unit={KNOWN}")
    return given


@spelt
def read_text(
    path: str | Path, *, dt: float | None = None, unit: str | None = None, column: int | str | None = None
) -> Motion:
    r"""Read a record of one column (acceleration) or two (time and acceleration), or one column of several.

    Parameters
    ----------
    path : str or Path
        Columns apart by blanks, tabs, commas or semicolons. Lines that begin with #, % or ! are comments, and so is a
        first line of words.
    dt : float, optional
        Step in s, needed with one column; with two it must agree with the times.
    unit : str
        Unit of the acceleration: 'g', 'm/s^2', 'cm/s^2', 'gal' or 'mm/s^2'.
    column : int or str, optional
        Which column is the acceleration, counted from 1, or its name in the first line, for a file with more than two,
        such as one with the components of a motion. The first column has the times then, unless `dt` is given.

    Returns
    -------
    Motion
        In m/s^2, with the file's name. Times are counted from its first sample.

    Raises
    ------
    SceneError
        If a line cannot be read, the times are not equally far apart, `dt` or `unit` is missing, or the file speaks of
        velocities or displacements; it names the file, the line and the cure.

    Examples
    --------
    >>> import symfric as sf
    >>> from pathlib import Path
    >>> _ = Path("record.txt").write_text("0.0\n0.1\n-0.2\n0.0\n")
    >>> round(sf.motions.read_text("record.txt", dt=0.01, unit="g").pga_g, 6)
    0.2

    Two components in one file, as a spreadsheet saves it:

    >>> _ = Path("two.csv").write_text("t,east,north\n0,0,0\n0.01,0.1,0.3\n0.02,-0.2,0\n")
    >>> [round(sf.motions.read_text("two.csv", unit="g", column=c).pga_g, 6) for c in ("east", "north")]
    [0.2, 0.3]
    """
    name, rows = read_lines(path)
    if unit is None:
        raise SceneError(f"{name}: no unit; a column of numbers does not tell: give unit={KNOWN}")
    factor_of(unit, f"{name}: unit")
    table, numbers = _columns(name, rows, column is not None)
    if column is not None:
        table = table[:, [*([] if dt is not None else [0]), _column_of(name, rows, column, table.shape[1], dt)]]
    if table.shape[0] < 2:
        raise SceneError(f"{name}: has {table.shape[0]} rows of numbers; a record has at least two samples")
    if table.shape[1] == 1:
        if dt is None:
            raise SceneError(f"{name}: one column of numbers and no dt; give dt=, the step in seconds")
        return Motion(table[:, 0], dt, unit, Path(path).stem)
    step = _step_of_times(name, table[:, 0], numbers)
    if dt is not None:
        given = finite(dt, "dt")
        if abs(given - step) > 0.01 * step:
            raise SceneError(f"{name}: its times are {step:.6g} s apart, and dt={given:g} is given; drop dt")
        step = given
    return Motion(table[:, 1], step, unit, Path(path).stem)


def _column_of(name: str, rows: list[str], column: int | str, count: int, dt: float | None) -> int:
    """Return the place of the acceleration among the columns, from 0."""
    heads = [[f for f in _FIELDS.split(row.strip(" \t#%!")) if f] for row in rows[:HEADER_LINES]]
    names = next((head for head in heads if len(head) == count and _is_head(head)), [])
    if isinstance(column, str):
        if column not in names:
            known = f"known: {', '.join(names)}" if names else "its first line has no names: count from 1, column=2"
            raise SceneError(f"{name}: no column {shortened(column)}; {known}")
        place = names.index(column)
    else:
        place = int(finite(column, "column")) - 1
        if place != column - 1 or not 0 <= place < count:
            raise SceneError(f"{name}: column is {column}; it has {count}, counted from 1")
    if place == 0 and dt is None:
        raise SceneError(f"{name}: column {column} is the first, which has the times; give another, or dt=, the step")
    return place


def _columns(name: str, rows: list[str], several: bool) -> tuple[np.ndarray, list[int]]:
    """Return the table of numbers, shape (n, 1 or 2) or of several columns, and the line of each of its rows."""
    numbers: list[int] = []
    table: list[np.ndarray] = []
    words_allowed = True
    for number, row in enumerate(rows, 1):
        text = row.strip()
        if not text:
            continue
        fields = [f for f in _FIELDS.split(text) if f]
        remark = text[0] in "#%!"
        if remark or (words_allowed and _is_head(fields)):
            _refuse_other_quantity(name, number, text)
            words_allowed = words_allowed and remark
            continue
        words_allowed = False
        values, _ = parse_numbers(name, [" ".join(fields)], 0, first=number)
        if len(values) > 2 and not several:
            raise SceneError(
                f"{name}, line {number}: {len(values)} columns; say which is the acceleration: column=2, counted "
                "from 1, or its name in the first line"
            )
        if table and len(values) != len(table[0]):
            raise SceneError(
                f"{name}, line {number}: {len(values)} columns, and {len(table[0])} before; mend the line"
                + ("; the file may be truncated" if number >= len(rows) - 1 else "")
            )
        table.append(values)
        numbers.append(number)
    return np.array(table).reshape(len(table), -1 if table else 1), numbers


def _is_head(fields: list[str]) -> bool:
    """Whether a line is a heading of columns."""
    return not re.match(rf"{_REAL}|[+-]?(nan|inf)|\*", fields[0], re.IGNORECASE) if fields else False


def _refuse_other_quantity(name: str, number: int, text: str) -> None:
    quantity = _QUANTITY.search(text) or _IN_BRACKETS.search(text)
    if quantity and not re.search("acc", text, re.IGNORECASE):
        raise SceneError(f"{name}, line {number}: says {quantity[0]!r}, no acceleration; take the acceleration instead")


def _step_of_times(name: str, times: np.ndarray, numbers: list[int]) -> float:
    """Return the constant step of a column of times, which may be rounded to a twentieth of it."""
    step = float(times[-1] - times[0]) / (times.size - 1)
    steps = np.diff(times)
    if np.any(steps <= 0):
        line = numbers[int(np.flatnonzero(steps <= 0)[0]) + 1]
        raise SceneError(f"{name}, line {line}: the time does not increase; two columns are time and acceleration")
    off = np.abs(times - (times[0] + step * np.arange(times.size)))
    if np.max(off) > 0.05 * step:
        line = numbers[int(np.argmax(np.abs(steps - np.median(steps)))) + 1]
        raise SceneError(
            f"{name}, line {line}: the time steps from {steps.min():g} to {steps.max():g} s; resample it at one step"
        )
    return step
