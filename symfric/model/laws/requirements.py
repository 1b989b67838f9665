"""What the parameters of a law must satisfy, whatever values they get later."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import sympy as sp

from symfric.errors import SceneError


class Requirement(NamedTuple):
    """A number that must be positive, or not negative.

    Attributes
    ----------
    name : str
        As messages say it.
    value : Expr
    zero : bool
        Whether it may be zero.
    """

    name: str
    value: sp.Expr
    zero: bool = False

    def holds(self, number: Any) -> Any:
        """Whether a number, or each of an array, is one that is asked for; NaN is none."""
        return number >= 0 if self.zero else number > 0

    def complaint(self, number: float | sp.Expr) -> str:
        """Return what is wrong with a number."""
        return f"{self.name} is {float(number):.6g}; it must {'not be negative' if self.zero else 'be positive'}"


def open_ones(requirements: Iterable[Requirement]) -> tuple[Requirement, ...]:
    """Return those of requirements whose value is no number yet; raise for a number that fails."""
    found = []
    for e in requirements:
        if not e.value.is_number:
            found.append(e)
        elif not e.holds(e.value):
            raise SceneError(e.complaint(e.value))
    return tuple(found)
