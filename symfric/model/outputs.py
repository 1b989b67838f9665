"""What a scene may ask for; only what is asked for is computed and kept."""

from dataclasses import dataclass

import sympy as sp

from symfric.errors import SceneError
from symfric.model.symbols import expression, finite


@dataclass(frozen=True)
class Output:
    """Anything that can stand in ``Scene.outputs``."""


@dataclass(frozen=True)
class ScalarOfExpression(Output):
    """An output that follows one expression of states, time and parameters along the run."""

    expr: sp.Expr

    def __post_init__(self):
        object.__setattr__(self, "expr", expression(self.expr, f"the expression of {type(self).__name__}"))


@dataclass(frozen=True)
class End(Output):
    """The final state, shape (n_x,)."""


@dataclass(frozen=True)
class Max(ScalarOfExpression):
    """Largest value of an expression over the run."""


@dataclass(frozen=True)
class Min(ScalarOfExpression):
    """Smallest value of an expression over the run."""


@dataclass(frozen=True)
class HalfRange(ScalarOfExpression):
    """(largest - smallest) / 2 of an expression over the run."""


@dataclass(frozen=True)
class Integral(ScalarOfExpression):
    """Integral of an expression over time."""


@dataclass(frozen=True)
class At(ScalarOfExpression):
    """Value of an expression at a time; at the end of the run unless given, and at the latest then."""

    time: float | None = None

    def __post_init__(self):
        super().__post_init__()
        if self.time is not None:
            object.__setattr__(self, "time", finite(self.time, "the time of At"))
            if self.time < 0:
                raise SceneError(f"the time of At is {self.time:g}; it must not be negative")


@dataclass(frozen=True)
class StopTime(Output):
    """Time at which the system comes to rest for good (within the horizon); NaN if it does not."""


@dataclass(frozen=True)
class Trajectory(Output):
    """The whole motion with its modes, events and dense output."""


@dataclass(frozen=True)
class Events(Output):
    """The list of events, without the motion between them."""


def friction_force(contact: str) -> sp.Symbol:
    """Return the friction force of a contact (on the body, along its slip) for use inside output expressions."""
    return sp.Symbol(f"friction_force({contact})", real=True)


def slip(contact: str) -> sp.Symbol:
    """Return the slip velocity of a contact for use inside output expressions."""
    return sp.Symbol(f"slip({contact})", real=True)
