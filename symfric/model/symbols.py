"""Reserved symbols, and checks of names and numbers."""

import math
import numbers
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.spelling import nearest as nearest

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
#: Time ``t``, reserved for it in forces, normal loads and outputs: ``force=[-x + sp.cos(3 * sf.TIME)]``. The symbol of
#: SymPy's own ``dynamicsymbols._t``, so that time derivatives of SymPy's mechanics are with respect to it.
TIME = sp.Symbol("t")
#: Sliding speed ``v`` = ``|slip|`` > 0, reserved for laws: ``sf.laws.custom(0.3 + 0.1 * sp.exp(-sf.SPEED), 0.4)``.
#: Outside a law it is an error; a symbol of your own that is called ``v`` and positive is this one: name it otherwise.
SPEED = sp.Symbol("v", positive=True)

Key: TypeAlias = sp.Symbol | str


def name_of(key: Key) -> str:
    """Return the name a symbol or string stands for."""
    if isinstance(key, str):
        return key
    if isinstance(key, sp.Symbol):
        return str(key.name)
    raise SceneError(f"{shortened(key)} is no name; use a symbol or its name as a string")


def legible(name: str, what: str) -> str:
    """Return a name that can stand in a line of text and in XML; raise on control characters and the like."""
    if not isinstance(name, str):
        raise SceneError(f"the name of {what} is {shortened(name)}; give a text")
    odd = next((c for c in name if not c.isprintable()), None)
    if odd is not None or not name.strip():
        fault = "is empty" if odd is None else f"holds the character U+{ord(odd):04X}, which cannot be shown"
        raise SceneError(f"the name {shorten(name, 40)!r} of {what} {fault}; use letters, digits and signs")
    return name


def finite(value: Any, what: str, name: str = "") -> float:
    """Return `value` as a finite float; the error message begins with `what` and `name`."""
    if isinstance(value, float) and math.isfinite(value):
        return float(value)
    what += name
    if isinstance(value, bool | str):
        raise SceneError(f"{what} is {shortened(value)}, not a number; give a plain number")
    if isinstance(value, sp.Expr):
        if not value.is_number:
            raise SceneError(f"{what} is the expression {value}, not a number")
        if value.is_extended_real is False:
            raise SceneError(f"{what} is {value}; it must be real")
    elif not isinstance(value, numbers.Real):
        raise SceneError(f"{what} is {shortened(value)}, not a number; give a plain number")
    try:
        result = float(value)
    except TypeError:
        raise SceneError(f"{what} is {value}; it must be a finite real number") from None
    if not math.isfinite(result):
        raise SceneError(f"{what} is {result}; it must be finite")
    return result


def positive(value: Any, name: str, *, zero: bool = False) -> float:
    """Return an argument as a finite number above zero, or not below it; the error begins with its name."""
    number = finite(value, name)
    if number < 0 or (number == 0 and not zero):
        raise SceneError(f"{name} is {number:g}; it must {'not be negative' if zero else 'be positive'}")
    return number


def numbers_of(value: Any, what: str) -> np.ndarray:
    """Return a number or an array of numbers as an array of floats; text is an error."""
    try:
        array = np.asarray(value)
        if array.dtype.kind in "USO" and any(isinstance(v, str | bytes) for v in array.flat):
            raise TypeError
        return array.astype(float)
    except (TypeError, ValueError):
        raise SceneError(f"{what} is {shortened(value)}; give numbers") from None


def listed(value: Any, what: str) -> tuple[Any, ...]:
    """Return a list or another sequence as a tuple; a single item is an error that shows the list."""
    if isinstance(value, sp.Tuple) or not isinstance(value, str | sp.Basic):
        try:
            return tuple(value)
        except TypeError:
            pass
    text = shortened(value)  # only now: the text of equations takes as long as reading a scene
    raise SceneError(f"{what} is {text}; give a list, {what}=[{text}]")


def pair(value: Any, name: str) -> tuple[Any, Any]:
    """Return the two entries of a range; anything else is an error that shows its form."""
    try:
        if isinstance(value, str | Mapping):
            raise TypeError
        low, high = value
    except (TypeError, ValueError):
        raise SceneError(f"{name} is {shortened(value)}; give two numbers, {name}=(lower, upper)") from None
    return low, high


def mapped(value: Any, what: str, example: str) -> Mapping[Any, Any]:
    """Return a mapping; anything else is an error that shows one."""
    if not isinstance(value, Mapping):
        raise SceneError(f"{what} is {shortened(value)}; give a mapping, {example}")
    return value


@alone(SYMBOLIC)
def expression(value: Any, what: str) -> sp.Expr:
    """Return `value` as a SymPy expression of symbols; a string is an error, since only scene files are parsed."""
    result = scalar(value, what)
    if result.has(AppliedUndef, sp.Derivative):
        _refuse_functions(result, what)
    return result


def scalar(value: Any, what: str) -> sp.Expr:
    """Return `value` as a SymPy expression, which may contain functions of time and their derivatives."""
    if isinstance(value, str):
        raise SceneError(f"{what} is the string {shortened(value)}; give a SymPy expression, or use a scene file")
    try:
        result = sp.sympify(value, strict=True)
    except sp.SympifyError:
        raise SceneError(f"{what} is {shortened(value)}, not a SymPy expression") from None
    if getattr(result, "is_Matrix", False):
        raise SceneError(f"{what} is a matrix, not a scalar expression")
    if not isinstance(result, sp.Expr):
        raise SceneError(f"{what} is {shortened(value)}, not a scalar expression")
    if result.has(sp.nan, sp.zoo, sp.oo, -sp.oo):
        raise SceneError(f"{what} is {result}; it must be finite")
    return result


def _refuse_functions(e: sp.Expr, what: str) -> None:
    """Raise on a derivative and on an unknown function, with what stands for them."""
    for d in sorted(e.atoms(sp.Derivative), key=str):
        raise SceneError(
            f"{what} contains {d}; write derivatives with states: a velocity is a symbol of System.u, and an "
            "acceleration is what the forces give divided by the mass"
        )
    for f in sorted(e.atoms(AppliedUndef), key=str):
        raise SceneError(
            f"{what} contains {f}, a function without a formula; states, parameters and inputs are plain symbols, "
            f"sympy.Symbol({f.func.__name__!r})"
        )


def refuse_speed(value: object, what: str) -> None:
    """Raise if an expression, or one in a sequence, contains the reserved symbol of the sliding speed."""
    for e in value if isinstance(value, list | tuple) else (value,):
        if isinstance(e, sp.Basic) and SPEED in e.free_symbols:
            raise SceneError(
                f"{what} contains v, a positive symbol, which is sf.SPEED, the sliding speed inside laws; rename your "
                "symbol v"
            )


def superscript(number: int) -> str:
    """Return a whole number in raised digits."""
    return str(number).translate(_RAISED)


def counted(n: int, noun: str) -> str:
    """Return a count with its noun in singular or plural."""
    return f"{n} {noun}{'' if n == 1 else 's'}"


def shortened(value: object) -> str:
    """Return the Python text of a value in one line of at most 60 letters."""
    return shorten(" ".join(repr(value).split()))


def shorten(value: object, length: int = 60) -> str:
    """Return a value as one line of text, control characters escaped, cut to `length`."""
    text = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(value))
    return text if len(text) <= length else text[: length - 3] + "..."
