"""What a scene file gives as arguments of functions: numbers, expressions, and calls that report in one line."""

import inspect
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from types import ModuleType
from typing import Any, TypeVar

import sympy as sp

from symfric.errors import SceneError
from symfric.model.numeric import numeric_function
from symfric.model.outputs import OF_CONTACTS
from symfric.model.symbols import nearest, shorten
from symfric.scenefile.expressions import parse_expression

_Made = TypeVar("_Made")


def functions_returning(module: ModuleType, result: type) -> dict[str, Callable[..., Any]]:
    """Return the public functions of a module or package with the return annotation `result`."""
    functions = inspect.getmembers(module, inspect.isfunction)
    return {
        name: f
        for name, f in functions
        if not name.startswith("_")
        and f"{f.__module__}.".startswith(f"{module.__name__}.")
        and f.__annotations__.get("return") is result
    }


def check_arguments(place: str, function: Callable[..., Any], given: Mapping[str, Any], elsewhere: str = "") -> None:
    """Raise on unknown and on missing arguments of a function."""
    parameters = inspect.signature(function).parameters
    for name in given:
        if name not in parameters:
            raise SceneError(
                f"{place}: {function.__name__} has no argument {shorten(name, 40)!r}{nearest(name, parameters)}"
            )
    needed = [n for n, p in parameters.items() if p.default is inspect.Parameter.empty and n not in given]
    if needed:
        raise SceneError(f"{elsewhere or place} needs {needed[0]}, an argument of {function.__name__}; add it")


def call(place: str, function: Callable[..., _Made], arguments: Mapping[str, Any]) -> _Made:
    """Call a function of the model layer; a wrong kind of argument is reported as an error of the file."""
    try:
        return function(**arguments)
    except SceneError:
        raise
    except (TypeError, ValueError, AttributeError, ArithmeticError, IndexError, MemoryError) as error:
        raise SceneError(f"{place}: {function.__name__} cannot use these arguments ({shorten(error, 100)})") from None


def call_at(place: str, function: Callable[..., _Made], arguments: Mapping[str, Any]) -> _Made:
    """Call a function with the place in front of whatever it reports."""
    try:
        return call(place, function, arguments)
    except SceneError as error:
        raise SceneError(f"{place}: {str(error).removeprefix(f'{place}: ')}") from None


def exact(value: float) -> float | int:
    """Return a whole number as an integer, so that equations show 2*x and not 2.0*x."""
    return int(value) if value.is_integer() and abs(value) < 1e15 else value


def exact_numbers(given: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return arguments with whole numbers as integers."""
    return {k: exact(v) if isinstance(v, float) else v for k, v in (given or {}).items()}


def as_expr(
    given: float | str,
    place: str,
    names: Mapping[str, sp.Expr],
    contacts: Sequence[str] = (),
    kinds: Collection[str] = tuple(OF_CONTACTS),
) -> sp.Expr:
    """Return a number or the text of an expression as an expression; see `parse_expression`."""
    if isinstance(given, str):
        return parse_expression(given, names, place, contacts, kinds)
    return sp.sympify(exact(given))


def real_symbols(names: Iterable[str]) -> dict[str, sp.Symbol]:
    """Return real symbols by name."""
    return {name: sp.Symbol(name, real=True) for name in names}


def finite_value(expr: sp.Expr, numbers: Mapping[sp.Symbol, float], place: str) -> float:
    """Return the value of an expression, or raise if it is not finite."""
    used = sorted(expr.free_symbols & set(numbers), key=str)
    try:
        value = float(numeric_function(tuple(used), expr)(*(numbers[s] for s in used)))
    except (TypeError, ValueError, ArithmeticError):
        value = math.nan
    if not math.isfinite(value):
        raise SceneError(f"{place} is {shorten(expr, 60)}, which has no finite real value at the start")
    return value
