"""Result of a fit."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.special import ndtri, stdtrit

from symfric.axes import Axes
from symfric.errors import NotFound, SceneError
from symfric.identification.bounded import bounded_interval
from symfric.identification.crossings import Crossing
from symfric.identification.diagnostics import Diagnostics, diagnose
from symfric.identification.local_fit import Minimum, Problem
from symfric.identification.prediction import Predictor
from symfric.identification.profile import FEWEST, Profile, profile_of, rise_of
from symfric.identification.records import Channel
from symfric.identification.sensor_faults import Faults
from symfric.identification.uncertainty import Direction, Uncertainty, uncertainty
from symfric.long_calls import logged
from symfric.model.laws import Law
from symfric.model.outputs import Trajectory
from symfric.model.results import ArrayResult, Drawable, Labelled, plain
from symfric.model.scene import Scene
from symfric.model.symbols import Key, name_of, nearest
from symfric.solve.routes import prepare
from symfric.solve.run import Run


@dataclass(frozen=True, eq=False)
class Fit(ArrayResult, Drawable):
    """Values of a scene that fit measured records best, with their uncertainty.

    `plot` draws records and predictions against time, residuals below.

    Attributes
    ----------
    names : tuple of str
        The unknowns.
    values : dict of str to float
    scenes : dict of str to Scene
        With the fitted values, by label; `scene` if there is one.
    tries : tuple of Minimum
        What the starts led to, the lowest first: ``values``, ``cost``, ``evaluations``.
    crossings : tuple of Crossing
        Changes in the sequence of events within one standard error of the solution.
    notes : tuple of str
        What a reader should know before using the numbers.
    active : tuple of str
        Unknowns that ended at a bound. They have no standard errors; those of the others regard them as free, and
        `interval` follows the cost.
    sigma : dict of str to float
        Standard deviation of the noise of each record, given or estimated; the mean if it varies over the record.
    evaluations : int
        Runs with derivatives that the fit took.
    law : Law or None
        With the fitted values, if a law was fitted and no scene.
    faults : Faults
        Records whose clock seems shifted against the run (``shifts``), and outliers (``outliers``).

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> scene = sf.scenes.coulomb_oscillator(0.03, delta_s=0.05)
    >>> t = np.linspace(0.1, 40.0, 200)
    >>> y = sf.simulate(scene)(t)[0] + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    >>> fit = sf.identify(scene, {"x": (t, y)}, {"delta": (0.001, 0.05)}, starts=2)
    >>> low, high = fit.interval("delta")
    >>> low < 0.03 < high
    False
    >>> round(round(fit.profile("delta", points=5).interval[0], 3), 6)
    0.03
    >>> sorted(fit.to_dict())[:2]
    ['active', 'correlation']
    >>> len(fit.to_xarray().data_vars) > 0
    True
    >>> ax = fit.plot()
    """

    names: tuple[str, ...]
    values: dict[str, float]
    scenes: dict[str, Scene]
    tries: tuple[Minimum, ...]
    crossings: tuple[Crossing, ...]
    notes: tuple[str, ...]
    active: tuple[str, ...]
    sigma: dict[str, float]
    evaluations: int
    law: Law | None
    _problem: Problem = field(repr=False)
    _known: bool = field(repr=False)  # whether the noise was given
    _y: np.ndarray = field(repr=False)  # predictions
    _jacobian: np.ndarray = field(repr=False)  # of the weighted residuals
    faults: Faults = field(default_factory=lambda: Faults({}, {}), repr=False)
    _step: np.ndarray | None = field(default=None, repr=False)  # left over at bounds, of records cut into pieces
    _inflation: float = field(default=1.0, repr=False)  # of the rise of the cost by a robust loss

    def _labelled(self) -> Labelled:
        data: dict[str, tuple[str, np.ndarray]] = {}
        times: dict[str, np.ndarray] = {}
        for name, (t, y) in self.records.items():
            over = f"time_of_{name}"
            times[over] = t
            rows = {name: y, f"{name} predicted": self.predictions[name], f"{name} residual": self.residuals[name]}
            data |= {n: (over, row) for n, row in rows.items()}
        return data, times, {}

    @property
    def scene(self) -> Scene:
        """The scene with the fitted values; raises `SceneError` if there are several."""
        if not self.scenes:
            raise SceneError("a law was fitted and no scene; use fit.law")
        if len(self.scenes) > 1:
            raise SceneError(f"the fit has several scenes; use fit.scenes with {', '.join(self.scenes)}")
        return next(iter(self.scenes.values()))

    @cached_property
    def vector(self) -> np.ndarray:
        """The values as a row (n_p,), in the order of `names`."""
        return np.array([self.values[n] for n in self.names])

    @property
    def loss(self) -> str:
        """Name of the loss of the residuals: "linear" for their squares."""
        return self._problem.loss.name

    @property
    def samples(self) -> int:
        """Number of samples that count."""
        return int(np.count_nonzero(self._problem.weight))

    @property
    def freedom(self) -> int:
        """Samples less unknowns that are not at a bound."""
        return self.samples - (len(self.names) - len(self.active))

    @cached_property
    def cost(self) -> float:
        """Half the sum of squares of the residuals, or of the loss if it is another one.

        Each over its standard deviation if `sigma` was given, or estimated because there are several records; plain for
        one record with unknown noise.
        """
        return float(self._problem.loss.cost(self._problem.weight * (self._problem.y - self._y)))

    @property
    def variance(self) -> float:
        """Variance of a weighted residual: estimated if there is one record with unknown noise, else 1."""
        return 1.0 if self._known or self._problem.loss.is_robust else 2 * self.cost / max(1, self.freedom)

    @cached_property
    def residuals(self) -> dict[str, np.ndarray]:
        """Measured minus predicted values of each record, in its unit."""
        rest = self._problem.y - self._y
        return {c.key: rest[rows] for c, rows in self._rows()}

    @cached_property
    def predictions(self) -> dict[str, np.ndarray]:
        """Predicted values of each record."""
        return {c.key: self._y[rows] for c, rows in self._rows()}

    @cached_property
    def records(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Times and values of each record."""
        return {c.key: (c.t, c.y) for c, _ in self._rows()}

    def _rows(self) -> Iterator[tuple[Channel, slice]]:
        return zip(self._problem.predictor.channels, self._problem.predictor.rows, strict=True)

    @cached_property
    def _uncertainty(self) -> Uncertainty:
        bound = np.array([n in self.active for n in self.names])
        unknowns = self._problem.predictor.unknowns
        ranges = unknowns.high - unknowns.low
        return uncertainty(self.names, self.vector, self._jacobian, bound, self.variance, ranges)

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the values, shape (n_p, n_p), in the order of `names`.

        That of least squares without bounds: an unknown at its bound counts as free in the rows of the others, and its
        own row is NaN.
        """
        return self._uncertainty.covariance

    @property
    def correlation(self) -> np.ndarray:
        """Correlation of the values, shape (n_p, n_p)."""
        return self._uncertainty.correlation

    @cached_property
    def standard_errors(self) -> dict[str, float]:
        """Standard error of each value; NaN at a bound, infinite where the records say nothing."""
        return dict(zip(self.names, self._uncertainty.errors.tolist(), strict=True))

    @property
    def unidentifiable(self) -> tuple[Direction, ...]:
        """Directions that the records do not fix better than the bounds do, the worst first."""
        return self._uncertainty.directions

    @cached_property
    def diagnostics(self) -> dict[str, Diagnostics]:
        """Statistics of the residuals of each record."""
        return {c.key: diagnose(self.residuals[c.key], len(self.names)) for c, _ in self._rows()}

    @property
    def predictor(self) -> Predictor:
        """The scenes with what the records measure; raises `SceneError` if a law was fitted and no scene."""
        if not isinstance(self._problem.predictor, Predictor):
            raise SceneError("a law was fitted and no scene; use fit.law")
        return self._problem.predictor

    @cached_property
    def runs(self) -> tuple[Run, ...]:
        """The motion of each scene with the fitted values, with its trajectory and what the sensors show."""
        predictor = self.predictor
        runs = []
        for label in predictor.labels:
            scene = predictor.scene_of(label, self.vector)
            runs.append(prepare(scene.wanting({**scene.outputs, "path": Trajectory()}), predictor.tolerance).run())
        return tuple(runs)

    def interval(self, name: Key, level: float = 0.95) -> tuple[float, float]:
        """Return the interval of a value: from its standard error, or from its profile if an unknown is at a bound.

        Parameters
        ----------
        name : symbol or str
        level : float
            Probability with which such intervals hold the truth.

        Returns
        -------
        (float, float)
            With an unknown at a bound an end that the bounds cut off is the bound; the interval of the unknown at its
            bound itself is therefore one-sided.

        Raises
        ------
        SceneError
            If the unknown does not exist.
        NotFound
            If a profile finds that the fit was no minimum.

        Notes
        -----
        By Student's distribution with `freedom` degrees of freedom if the noise was estimated, else by the normal one.
        Estimates do not scatter about the truth in that way where an unknown is at a bound; the likelihood ratio, with
        that unknown fitted anew for every value and free to leave its bound, then holds the truth more often than
        `level` says for the unknown at the bound, and nearly as often for the others (Self and Liang, Journal of the
        American Statistical Association 82 (1987) 605). `profile` gives such an interval always.
        """
        k = self._index(name)
        if not 0 < level < 1:
            raise SceneError(f"level is {level}; give a probability between 0 and 1")
        if self.active:
            if (k, level) not in self._followed:
                self._followed[k, level] = self._between_bounds(k, level)
            return self._followed[k, level]
        spread = ndtri(0.5 + level / 2) if self._known else stdtrit(max(1, self.freedom), 0.5 + level / 2)
        error = self.standard_errors[self.names[k]] * float(spread)
        return self.values[self.names[k]] - error, self.values[self.names[k]] + error

    @logged
    def profile(self, name: Key, level: float = 0.95, points: int = 15) -> Profile:
        """Return the lowest cost for given values of one unknown, the others fitted, and the interval it gives.

        Parameters
        ----------
        name : symbol or str
        level : float
            Probability of the interval.
        points : int
            Fewest values at which the cost is computed.

        Returns
        -------
        Profile

        Raises
        ------
        SceneError
            If the name is none of the unknowns.
        NotFound
            If the cost goes below that of the fit, which therefore was no minimum.
        """
        k = self._index(name)
        rise = self._rise(level)
        profiled = profile_of(self._problem, self.vector, self.cost, k, level, rise, self._jacobian, points)
        if profiled.lowest.cost < self.cost * (1 - 1e-4) - 1e-300:
            better = dict(zip(self.names, profiled.lowest.values.tolist(), strict=True))
            shown = ", ".join(f"{n} = {v:.6g}" for n, v in better.items())
            raise NotFound(f"the fit is no minimum: the cost is lower at {shown}; fit again with more starts")
        return profiled.profile

    def _between_bounds(self, k: int, level: float) -> tuple[float, float]:
        """Return the interval of the profile, of its linearisation if no run follows the records."""
        unknowns = self._problem.predictor.unknowns
        if self._step is None:
            low, high = self.profile(self.names[k], level, FEWEST).interval
            return max(low, float(unknowns.low[k])), min(high, float(unknowns.high[k]))
        room = unknowns.low - self.vector, unknowns.high - self.vector
        ends = bounded_interval(self._jacobian, self._step, *room, k, self._rise(level))
        return float(self.vector[k] + ends[0]), float(self.vector[k] + ends[1])

    def _rise(self, level: float) -> float:
        """Return by how much the cost rises to the ends of an interval."""
        return rise_of(level, self.variance * self._inflation, None if self._known else max(1, self.freedom))

    @cached_property
    def _followed(self) -> dict[tuple[int, float], tuple[float, float]]:
        """Intervals of profiles that were computed, by unknown and level."""
        return {}

    def _index(self, name: Key) -> int:
        unknown = name_of(name)
        if unknown not in self.names:
            raise SceneError(f"{unknown} was not fitted{nearest(unknown, self.names)}")
        return self.names.index(unknown)

    def _draw(self, ax: Axes | None) -> Axes:
        from symfric.identification.plotting import plot_fit

        return plot_fit(self, ax)

    def holding(self, name: Key, value: float) -> "Problem":
        """Return the least-squares problem with one unknown held.

        Parameters
        ----------
        name : symbol or name
            Of the unknown.
        value : float

        Returns
        -------
        Problem

        Examples
        --------
        >>> import numpy as np
        >>> import symfric as sf
        >>> scene = sf.scenes.coulomb_oscillator(0.03)
        >>> t = np.linspace(0.1, 20.0, 50)
        >>> fit = sf.identify(scene, {"x": (t, sf.simulate(scene)(t)[0])}, {"delta": (0.001, 0.05)}, starts=1)
        >>> fit.holding("delta", 0.03).fixed
        {0: 0.03}
        """
        return replace(self._problem, fixed={**self._problem.fixed, self._index(name): float(value)})

    def to_dict(self) -> dict[str, Any]:
        directions = [{"weights": dict(d), "error": d.error, "words": str(d)} for d in self.unidentifiable]
        first = ("values", "standard_errors", "covariance", "correlation", "loss", "cost", "samples", "sigma", "active")
        return {
            **{name: plain(getattr(self, name)) for name in first},
            "unidentifiable": directions,
            "diagnostics": plain(self.diagnostics),
            "shifts": plain(self.faults.shifts),
            "outliers": plain(self.faults.outliers),
            **{name: plain(getattr(self, name)) for name in ("crossings", "notes", "evaluations")},
        }

    def __str__(self) -> str:
        wide = max(map(len, self.names))
        lines = [f"{n:<{wide}} = {v:.6g} +- {self.standard_errors[n]:.2g}" for n, v in self.values.items()]
        lines += [f"noise of {n}: {s:.3g}" for n, s in self.sigma.items()]
        return "\n".join([*lines, *(f"note: {n}" for n in self.notes)])

    def __repr__(self) -> str:
        shown = ", ".join(f"{n}={v:.6g}+-{self.standard_errors[n]:.2g}" for n, v in self.values.items())
        return f"Fit({shown}; cost {self.cost:.6g}, {self.samples} samples)"
