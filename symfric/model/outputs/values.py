"""Outputs that are values at given times: the final state, one value of an expression, samples."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from symfric.errors import SceneError
from symfric.model.outputs.output import Output, OutputOfExpression
from symfric.model.outputs.roots import is_root, root, second_slopes_of_root, slopes_of_root
from symfric.model.rows import VALUES, Row
from symfric.model.symbols import finite
from symfric.spelling import spelt


@spelt
@dataclass(frozen=True)
class End(Output):
    """The final state, shape (n_x,).

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> (sf.simulate(oscillator.wanting({"end": sf.End()}))["end"]).round(6)
    array([0.572119, 0.195591])
    """

    word: ClassVar[str] = "end"

    def size(self, n_x: int) -> int | None:
        return n_x

    def value(self, run: Any, name: str) -> Any:
        return run.final

    def slopes(self, derivatives: Any, name: str) -> Any:
        return derivatives.of_end()


@spelt
@dataclass(frozen=True)
class At(OutputOfExpression):
    """Value of an expression at a time, or at the end of the run; NaN if the run fails before.

    Attributes
    ----------
    expr : Expr
        Of states, time and parameters; may use `sf.friction_force` and `sf.slip`.
    time : float or None
        Not after the horizon of the scene; its end unless given.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> x = oscillator.system.q[0]
    >>> round(float(sf.simulate(oscillator.wanting({"size": sf.At(x, 2.0)}))["size"]), 6)
    -0.274532
    """

    word: ClassVar[str] = "at"
    time: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.time is not None:
            object.__setattr__(self, "time", finite(self.time, "the time of At"))
            if self.time < 0:
                raise SceneError(f"the time of At is {self.time:g}; it must not be negative")

    @property
    def latest(self) -> float:
        """Its time, 0 if that is the end of the run."""
        return self.time or 0.0

    def row(self, horizon: float) -> Row:
        taken = self.expr.args[0] if is_root(self.expr) else self.expr
        return Row(VALUES, taken, (horizon if self.time is None else min(self.time, horizon),))

    def reduce(self, observable: Any) -> Any:
        return root(observable[0]) if is_root(self.expr) else observable[0]

    def slopes(self, derivatives: Any, name: str) -> Any:
        slopes = derivatives.of_row(name)[0]
        return slopes_of_root(slopes, derivatives.values(name)[0]) if is_root(self.expr) else slopes

    def second_slopes(self, derivatives: Any, name: str, twice: Any) -> Any:
        if not is_root(self.expr):
            return twice[0]
        slopes, radicand = self.slopes(derivatives, name), derivatives.values(name)[0]
        return second_slopes_of_root(twice[0], slopes, radicand, derivatives.columns.pairs)


@spelt
@dataclass(frozen=True)
class Samples(OutputOfExpression):
    """Values of an expression at given times, shape (n_t,), like the samples of a sensor.

    Parameters
    ----------
    expr : Expr
        Of states, time and parameters.
    times : sequence of float
        Increasing, not negative and not after the horizon of the scene; the values at those that a failed run does not
        reach are NaN.

    Raises
    ------
    SceneError
        If the times are none, or not in their order.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=3.0)
    >>> (x,) = scene.system.q
    >>> run = sf.simulate(scene.wanting({"x": sf.Samples(x, [0.0, 1.5, 3.0])}))
    >>> run["x"].round(6)
    array([ 1.      ,  0.163663, -0.790993])
    """

    word: ClassVar[str] = "samples"
    times: Sequence[float] | np.ndarray = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        try:
            times = tuple(finite(t, "a time of Samples") for t in np.atleast_1d(np.array(self.times, dtype=float)))
        except (TypeError, ValueError) as error:
            raise SceneError(f"the times of Samples are not a sequence of numbers: {error}") from None
        if not times:
            raise SceneError("the times of Samples are empty; give at least one")
        if times[0] < 0 or any(b <= a for a, b in pairwise(times)):
            raise SceneError("the times of Samples must increase and not be negative")
        object.__setattr__(self, "times", times)

    @property
    def latest(self) -> float:
        """The last of its times."""
        return self.times[-1]

    def row(self, horizon: float) -> Row:
        return Row(VALUES, self.expr, (*self.times[:-1], min(self.times[-1], horizon)))

    def size(self, n_x: int) -> int | None:
        return len(self.times)
