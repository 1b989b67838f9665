"""Outputs made of the smallest and the largest value of an expression."""

from dataclasses import dataclass
from typing import Any, ClassVar

import sympy as sp

from symfric.model.outputs.output import OutputAfter
from symfric.model.outputs.roots import is_root, root, slopes_of_root
from symfric.model.rows import RANGE, Row
from symfric.spelling import spelt


@dataclass(frozen=True)
class OutputOfRange(OutputAfter):
    """Base of outputs made of the smallest and the largest value of an expression.

    Of a root, such as the length of a vector, the extremes are the roots of those of its radicand, which has a series
    where it is zero.
    """

    def row(self, horizon: float) -> Row:
        magnitude = isinstance(self.expr, sp.Abs)
        plain = self.expr.args[0] if magnitude or is_root(self.expr) else self.expr
        return Row(RANGE, plain, magnitude=magnitude, start=self.after)

    def _of_ends(self, low: Any, high: Any) -> Any:
        """Return the output from the smallest and the largest value, or its derivative from theirs.

        Parameters
        ----------
        low, high : float or ndarray

        Returns
        -------
        float or ndarray
        """
        raise NotImplementedError

    def reduce(self, observable: Any) -> Any:
        return self._of_ends(*(map(root, observable) if is_root(self.expr) else observable))

    def slopes(self, derivatives: Any, name: str) -> Any:
        slopes = derivatives.of_row(name)
        if is_root(self.expr):
            slopes = map(slopes_of_root, slopes, derivatives.ends(name))
        return self._of_ends(*slopes)


@spelt
@dataclass(frozen=True)
class Max(OutputOfRange):
    """Largest value of an expression over the run.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.Max(x)}))["size"], 6)
    1.0
    """

    word: ClassVar[str] = "max"

    def _of_ends(self, low: Any, high: Any) -> Any:
        return high


@spelt
@dataclass(frozen=True)
class Min(OutputOfRange):
    """Smallest value of an expression over the run.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.Min(x)}))["size"], 6)
    -0.8
    """

    word: ClassVar[str] = "min"

    def _of_ends(self, low: Any, high: Any) -> Any:
        return low


@spelt
@dataclass(frozen=True)
class HalfRange(OutputOfRange):
    """(largest - smallest) / 2 of an expression over the run.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.HalfRange(x)}))["size"], 6)
    0.9

    The amplitude of a vibration that has settled:

    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> x = belt.system.q[0]
    >>> round(sf.simulate(belt.wanting({"settled": sf.HalfRange(x, after=50)}))["settled"], 6)
    0.286209
    """

    word: ClassVar[str] = "half_range"

    def _of_ends(self, low: Any, high: Any) -> Any:
        return 0.5 * (high - low)
