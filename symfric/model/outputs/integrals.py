"""Outputs made of the integral of an expression over time."""

from dataclasses import dataclass
from typing import Any, ClassVar

from symfric.model.outputs.output import OutputAfter, OutputOfExpression
from symfric.model.outputs.roots import second_slopes_of_root, slopes_of_root
from symfric.model.rows import INTEGRAL, Row
from symfric.spelling import spelt


@spelt
@dataclass(frozen=True)
class Integral(OutputOfExpression):
    """Integral of an expression over time.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.Integral(x**2)}))["size"], 6)
    2.006043
    """

    word: ClassVar[str] = "integral"

    def row(self, horizon: float) -> Row:
        return Row(INTEGRAL, self.expr)


@spelt
@dataclass(frozen=True)
class Mean(OutputAfter):
    """Mean of an expression over time, to the end of the run.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Notes
    -----
    ``integral of expr from after to T, / (T - after)`` with the horizon T.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.Mean(x, after=2.0)}))["size"], 6)
    -0.29641
    """

    word: ClassVar[str] = "mean"

    def row(self, horizon: float) -> Row:
        return Row(INTEGRAL, self.expr / (horizon - self.after), start=self.after)


@spelt
@dataclass(frozen=True)
class RMS(OutputAfter):
    """Root of the mean square of an expression over time, to the end of the run.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Notes
    -----
    ``sqrt(integral of expr**2 from after to T, / (T - after))`` with the horizon T.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(sf.simulate(oscillator.wanting({"size": sf.RMS(x, after=2.0)}))["size"], 6)
    0.53982
    """

    word: ClassVar[str] = "rms"

    def row(self, horizon: float) -> Row:
        return Row(INTEGRAL, self.expr**2 / (horizon - self.after), start=self.after)

    def reduce(self, observable: Any) -> Any:
        return observable**0.5

    def slopes(self, derivatives: Any, name: str) -> Any:
        return slopes_of_root(derivatives.of_row(name), derivatives.integral(name))

    def second_slopes(self, derivatives: Any, name: str, twice: Any) -> Any:
        slopes, mean_square = self.slopes(derivatives, name), derivatives.integral(name)
        return second_slopes_of_root(twice, slopes, mean_square, derivatives.columns.pairs)
