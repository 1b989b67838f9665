"""Check of the parameters of the ready laws."""

import functools
import inspect
from collections.abc import Callable, Mapping
from typing import ParamSpec, TypeAlias

import sympy as sp

from symfric.locks import SYMBOLIC
from symfric.model.laws.law import Law
from symfric.model.laws.requirements import Requirement, open_ones
from symfric.model.symbols import expression, refuse_speed
from symfric.spelling import spelt

Parameter: TypeAlias = float | sp.Expr  # of a law
_Given = ParamSpec("_Given")


def ready_law(make: Callable[_Given, Law]) -> Callable[_Given, Law]:
    """Decorate the function of a law: what it annotates as a `Parameter` is an expression without the sliding speed."""
    names = tuple(inspect.signature(make).parameters)
    expressions = {name for name, kind in make.__annotations__.items() if kind in (Parameter, Parameter | None)}

    needed = {name for name in expressions if make.__annotations__[name] is Parameter}
    made = spelt(make)

    @functools.wraps(make)
    def checked(*args: _Given.args, **kwargs: _Given.kwargs) -> Law:
        with SYMBOLIC:
            for name, value in (*zip(names, args, strict=False), *kwargs.items()):
                refuse_speed(value, f"{name} of {make.__name__}")
                if name in expressions and (value is not None or name in needed):
                    expression(value, f"{name} of {make.__name__}")
            return made(*args, **kwargs)

    return checked


def parameters_of(
    law: str, positive: Mapping[str, Parameter], others: Mapping[str, Parameter] | None = None
) -> tuple[list[sp.Expr], tuple[Requirement, ...]]:
    """Return the parameters of a law as expressions, and what those must satisfy that have no number yet.

    Parameters
    ----------
    law : str
        Its name.
    positive, others : mapping of str to float or Expr
        Those that must be above zero, and those that must not be below.

    Raises
    ------
    SceneError
        If a number is none that is asked for.
    """
    groups = ((positive, False), (others or {}, True))
    every = [
        Requirement(f"{name} of {law}", expression(value, f"{name} of {law}"), zero)
        for group, zero in groups
        for name, value in group.items()
    ]
    return [e.value for e in every], open_ones(every)


def whole(exponent: sp.Expr) -> sp.Expr:
    """Return an exponent, as an integer if it is a float with the value of one: its powers are products then."""
    return sp.Integer(int(exponent)) if exponent.is_Float and float(exponent).is_integer() else exponent
