"""Closed forms: a function that states its formula gives numbers, unless the formula itself is asked for."""

from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC
from symfric.model.symbols import finite

P = ParamSpec("P")
R = TypeVar("R")


def closed_form(evaluate: Callable[..., Any]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorate a function that returns a formula so that it returns the number, except with ``symbolic=True``.

    Parameters
    ----------
    evaluate : callable
        ``evaluate(formula, *arguments)``, with the arguments of the function but `symbolic`: returns the number, and
        raises where arguments are missing or the formula does not hold.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def evaluated(*args: P.args, **kwargs: P.kwargs) -> R:
            with SYMBOLIC:
                formula = function(*args, **kwargs)
                others = {name: value for name, value in kwargs.items() if name != "symbolic"}
                return formula if kwargs.get("symbolic") else evaluate(formula, *args, **others)

        return evaluated

    return decorate


def positive(value: Any, name: str, *, zero: bool = False) -> float:
    """Return an argument as a finite number above zero, or not below it; the error begins with its name."""
    number = finite(value, name)
    if number < 0 or (number == 0 and not zero):
        raise SceneError(f"{name} is {number:g}; it must {'not be negative' if zero else 'be positive'}")
    return number


def needed(value: Any, name: str) -> Any:
    """Return an argument that only the formula does without."""
    if value is None:
        raise SceneError(f"no {name}; give a number, or ask for the formula with symbolic=True")
    return value
