"""Check of the parameters of the ready laws."""

import functools
import inspect
from collections.abc import Callable, Mapping
from typing import ParamSpec, TypeAlias

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC
from symfric.model.laws.law import Law
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
) -> list[sp.Expr]:
    """Return the parameters of a law as expressions; those in `positive` must be above zero, the others not below."""
    expressions = []
    for group, least in ((positive, "be positive"), (others or {}, "not be negative")):
        for name, value in group.items():
            e = expression(value, f"{name} of {law}")
            if e.is_number and (e < 0 or (group is positive and e.is_zero)):
                raise SceneError(f"{name} of {law} is {e}; it must {least}")
            expressions.append(e)
    return expressions


def whole(exponent: sp.Expr) -> sp.Expr:
    """Return an exponent, as an integer if it is a float with the value of one: its powers are products then."""
    return sp.Integer(int(exponent)) if exponent.is_Float and float(exponent).is_integer() else exponent
