"""Friction laws of a scene file by their names and signatures, and what reading arguments takes."""

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import ModuleType

import sympy as sp

from symfric.errors import SceneError
from symfric.model import laws
from symfric.model.laws import Law
from symfric.model.numeric import numeric_function
from symfric.model.symbols import SPEED, nearest
from symfric.scenefile.contact_tables import FrictionTable
from symfric.scenefile.expressions import parse_expression, shorten
from symfric.scenefile.schema import Document


@dataclass(frozen=True)
class LawSpec:
    """A friction law as written in the file, for display.

    Attributes
    ----------
    contact, law : str
    coefficients : dict
        Argument of the law to a number, the text of an expression, or a list of them.
    """

    contact: str
    law: str
    coefficients: dict


def functions_returning(module: ModuleType, result: type) -> dict[str, Callable]:
    """Return the public functions of a module or package with the return annotation `result`."""
    found = inspect.getmembers(module, inspect.isfunction)
    return {
        name: f
        for name, f in found
        if not name.startswith("_")
        and f"{f.__module__}.".startswith(f"{module.__name__}.")
        and f.__annotations__.get("return") is result
    }


def friction_laws() -> dict[str, Callable]:
    """Return the friction laws by name."""
    return functions_returning(laws, Law)


def call(place: str, function: Callable, arguments: Mapping):
    """Call a function of the model layer; a wrong kind of argument is reported as an error of the file."""
    try:
        return function(**arguments)
    except SceneError:
        raise
    except (TypeError, ValueError, AttributeError, ArithmeticError, IndexError, MemoryError) as error:
        raise SceneError(f"{place}: {function.__name__} cannot use these arguments ({shorten(error, 100)})") from None


def check_arguments(place: str, function: Callable, given: Mapping, elsewhere: str = "") -> None:
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


def law_of(friction: FrictionTable, place: str, names: Mapping[str, sp.Symbol], values: Mapping[str, float]) -> Law:
    """Return the law of one contact; `names` are the parameters available to it."""
    known = friction_laws()
    if friction.law not in known:
        raise SceneError(f"{place}.law: no law {shorten(friction.law, 40)!r}{nearest(friction.law, known)}")
    function, given = known[friction.law], friction.__pydantic_extra__
    check_arguments(f"[{place}]", function, given)

    def read(value, where: str, own: Mapping[str, sp.Expr]):
        if isinstance(value, list):
            return [read(v, f"{where}[{i}]", own) for i, v in enumerate(value)]
        if not isinstance(value, str):
            return exact(value)
        result = parse_expression(value, own, where)
        if not result.free_symbols:
            raise SceneError(f"{where} is the string {shorten(value, 30)!r}; write the number without quotes")
        return result

    coefficients = {}
    for key, value in given.items():
        own = {**names, SPEED.name: SPEED} if key == "kinetic" else names
        coefficients[key] = read(value, f"{place}.{key}", own)
    try:
        law = call(f"[{place}]", function, coefficients)
    except SceneError as error:
        raise SceneError(f"[{place}]: {str(error).removeprefix(f'[{place}]: ')}") from None
    numbers = {names[n]: v for n, v in values.items() if n in names}
    for what, e in (("static coefficient", law.stick), ("kinetic coefficient", law.kinetic)):
        if law.free_symbols <= set(numbers):
            finite_value(e, {**numbers, SPEED: 0.0}, f"the {what} of [{place}]")
    return law


def exact(value: float) -> float | int:
    """Return a whole number as an integer, so that equations show 2*x and not 2.0*x."""
    return int(value) if value.is_integer() and abs(value) < 1e15 else value


def spec_of(friction: FrictionTable, contact: str) -> LawSpec:
    return LawSpec(contact, friction.law, dict(friction.__pydantic_extra__))


def contact_place(document: Document, i: int) -> str:
    """Return the place of the i-th contact in the file, for messages."""
    if len(document.friction) == 1:
        return "friction"
    return f"friction.{shorten(document.friction[i].name or i + 1, 30)}"


def real_symbols(names) -> dict[str, sp.Symbol]:
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
