"""Outputs that are times: the period of a settled motion, the time after which the system rests."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from symfric.model.outputs.output import Output, OutputAfter
from symfric.model.rows import CROSSINGS, Row
from symfric.spelling import spelt


@spelt
@dataclass(frozen=True)
class Period(OutputAfter):
    """Mean time between the instants at which an expression rises through zero; NaN if there are fewer than two.

    It is the period of a settled motion whose expression does so once in every period, such as the velocity of a
    stick-slip vibration, or ``x - level``. See `sf.limit_cycle` for the period of the limit cycle itself.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    after : float
        Time from which on the motion counts, before the horizon; 0, the whole run, unless given.

    Notes
    -----
    ``(t_n - t_1) / (n - 1)`` with the first and the last of n instants at which the expression, negative before,
    becomes positive. They are roots of the polynomials of the steps, or instants at which the expression jumps.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> u = belt.system.u[0]
    >>> round(sf.simulate(belt.wanting({"T": sf.Period(u, after=50)}))["T"], 6)
    6.799421
    >>> round(sf.limit_cycle(belt).period, 6)
    6.799421
    """

    word: ClassVar[str] = "period"

    def row(self, horizon: float) -> Row:
        return Row(CROSSINGS, self.expr, start=self.after)

    def reduce(self, observable: Any) -> Any:
        first, last, count = observable
        return (last - first) / np.where(np.asarray(count) > 1.0, count - 1.0, np.nan)

    def value(self, run: Any, name: str) -> Any:
        period = super().value(run, name)
        return period if period.ndim else float(period)


@spelt
@dataclass(frozen=True)
class StopTime(Output):
    """Time after which the system stays at rest until the horizon; NaN if it moves at the end, or the run fails.

    A motion whose speed fades exponentially, as of a slide that an integral carries to its target, has no such time: it
    ends where the tolerance no longer tells its speed from zero, later by the same time for each digit of it.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0)
    >>> round(sf.simulate(oscillator.wanting({"rest": sf.StopTime()}))["rest"], 6)
    15.707963
    """

    word: ClassVar[str] = "stop_time"
    scalar: ClassVar[bool] = True

    def value(self, run: Any, name: str) -> Any:
        return run.raw.rest

    def slopes(self, derivatives: Any, name: str) -> Any:
        return derivatives.of_rest()
