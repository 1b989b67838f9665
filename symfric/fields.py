"""Types of the keys of TOML tables; error messages are worded to follow the place of the key."""

from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from symfric.model.symbols import shorten

LARGEST = 1e300
MAX_TABLES = 200  # most entries of one table or list
MAX_UNIT = 40  # most letters of a unit, which figures can show
MAX_AXIS = 100_000  # most values of one axis of a sweep


def number(value: object) -> float:
    """Return a TOML number as a float; anything else is an error, also a number in quotes."""
    if isinstance(value, str):
        raise ValueError(f"is the string {shorten(value, 30)!r}, not a number; write the number without quotes or unit")
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"is {kind_of(value)}, not a number; write a plain number")
    if not abs(value) <= LARGEST:
        raise ValueError(f"is {shorten(value, 20)}; it must be finite")
    return float(value)


def _term(value: object) -> float | str:
    """Return a number or the text of an expression."""
    return value if isinstance(value, str) else number(value)


def _slip(value: object) -> float | str | list[float | str]:
    """Return a slip: one expression, or the two of a contact in the plane."""
    if not isinstance(value, list):
        return _term(value)
    if len(value) != 2:
        raise ValueError(f"has {len(value)} entries; write one expression, or two for a contact in the plane")
    return [_term(v) for v in value]


def _factors(value: object) -> list[float | str]:
    """Return the factors of friction along both slips of a contact in the plane."""
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"is {shorten(repr(value), 30)}; write two factors, along the first and the second slip")
    return [_term(v) for v in value]


def _coefficient(value: object) -> float | str | list[float | str]:
    """Return a coefficient of a friction law: a number, an expression, or a list of them."""
    return [_term(v) for v in value] if isinstance(value, list) else _term(value)


def _option(value: object) -> float | str | bool | list[float | str]:
    """Return a checked option of a ready scene."""
    return value if isinstance(value, bool) else _coefficient(value)


def _mass(value: object) -> list[list[float | str]]:
    """Return the rows of the mass matrix, given as one entry, the diagonal, or all rows."""
    entries = as_list(value)
    if any(isinstance(row, list) for row in entries):
        if not all(isinstance(row, list) for row in entries):
            raise ValueError("mixes rows and entries; write all rows, or the diagonal alone")
        return [[_term(e) for e in row] for row in entries]
    return [[_term(e) if i == j else 0.0 for j in range(len(entries))] for i, e in enumerate(entries)]


def _axis(value: object) -> list[float]:
    """Return the values of one axis of a grid: a list, or a table of start, stop and count."""
    if isinstance(value, list):
        if not 1 <= len(value) <= MAX_AXIS:
            raise ValueError(f"has {len(value)} values; give 1 to {MAX_AXIS}")
        return [number(v) for v in value]
    if not isinstance(value, dict) or set(value) != {"start", "stop", "count"}:
        raise ValueError("is not an axis; write a list of values, or {start = 0.0, stop = 1.0, count = 11}")
    start, stop, count = number(value["start"]), number(value["stop"]), value["count"]
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MAX_AXIS:
        raise ValueError(f"has the count {shorten(count, 20)}; write a whole number from 1 to {MAX_AXIS}")
    step = (stop - start) / max(count - 1, 1)
    return [start, *(start + step * k for k in range(1, count - 1)), *([stop] if count > 1 else [])]


def _pair(value: object) -> list[Any]:
    """Return a list of two values."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError(f"is {shorten(repr(value), 30)}; write [smallest, largest]")
    return list(value)


def text(value: object) -> str:
    """Return a text; anything else is an error."""
    if not isinstance(value, str):
        raise ValueError(f"is {kind_of(value)}, not text; put it in quotes")
    return value


def as_list(value: object) -> list[Any]:
    """Return a single entry as a list of one."""
    return value if isinstance(value, list) else [value]


def kind_of(value: object) -> str:
    """Return what a value of TOML is, in words."""
    names = {bool: "true or false", int: "a number", float: "a number", list: "a list", dict: "a table"}
    return names.get(type(value), f"a {type(value).__name__}")


Number = Annotated[float, BeforeValidator(number)]
Positive = Annotated[float, BeforeValidator(number), Field(gt=0)]
Term = Annotated[float | str, BeforeValidator(_term)]
Slip = Annotated[Any, BeforeValidator(_slip)]
Factors = Annotated[Any, BeforeValidator(_factors)]
Coefficient = Annotated[Any, BeforeValidator(_coefficient)]
Option = Annotated[Any, BeforeValidator(_option)]
Text = Annotated[str, Field(max_length=10_000), BeforeValidator(text)]
Unit = Annotated[str, Field(max_length=MAX_UNIT), BeforeValidator(text)]
Names = Annotated[list[Text], BeforeValidator(as_list), Field(max_length=MAX_TABLES)]
Terms = Annotated[list[Term], BeforeValidator(as_list), Field(max_length=MAX_TABLES)]
Axis = Annotated[Any, BeforeValidator(_axis)]
Mass = Annotated[Any, BeforeValidator(_mass)]
Range = Annotated[tuple[Number, Number], BeforeValidator(_pair)]


class Section(BaseModel):
    """Base of all sections: a table with fixed keys."""

    model_config = ConfigDict(extra="forbid", frozen=True)
