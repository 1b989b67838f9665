"""Profiles: the lowest cost for given values of one unknown, and the interval that a likelihood ratio gives."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri, fdtri

from symfric.axes import Axes
from symfric.errors import SceneError
from symfric.identification.local_fit import Minimum, Problem, minimise
from symfric.model.results import Drawable, Result
from symfric.model.symbols import shortened

REFINED = 40  # most steps towards the end of an interval
CLOSE, NARROW = 1e-4, 1e-6  # distance from the threshold, and from the end of the interval, that suffice (relative)
MOST = 40  # steps outwards
FEWEST = 3  # points of a profile


@dataclass(frozen=True, eq=False)
class Profile(Result, Drawable):
    """Lowest cost over one unknown.

    `plot` draws the cost over the values with the threshold.

    Attributes
    ----------
    name : str
    values : ndarray, shape (n,)
        Increasing.
    cost : ndarray, shape (n,)
        Half the weighted sum of squares with the other unknowns fitted anew.
    interval : (float, float)
        Where the cost is below `threshold`; an end that the bounds cut off is infinite.
    level : float
        Probability of the interval.
    threshold : float

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> scene = sf.scenes.coulomb_oscillator(0.03, delta_s=0.05)
    >>> t = np.linspace(0.1, 40.0, 200)
    >>> y = sf.simulate(scene)(t)[0] + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    >>> fit = sf.identify(scene, {"x": (t, y)}, {"delta": (0.001, 0.05)}, starts=2)
    >>> profile = fit.profile("delta", points=5)
    >>> sorted(profile.to_dict())[:2]
    ['cost', 'interval']
    >>> ax = profile.plot()
    """

    name: str
    values: np.ndarray
    cost: np.ndarray
    interval: tuple[float, float]
    level: float
    threshold: float
    _told = ("name", "values", "cost", "interval", "level")

    def _draw(self, ax: Axes | None) -> Axes:
        from symfric.identification.plotting import plot_profile

        return plot_profile(self, ax)

    def __repr__(self) -> str:
        low, high = self.interval
        return f"Profile({self.name}: {low:.6g} to {high:.6g} at {100 * self.level:g} %)"


class Profiled(NamedTuple):
    """A profile and the lowest point found on the way."""

    profile: Profile
    lowest: Minimum


def rise_of(level: float, variance: float, freedom: int | None) -> float:
    """Return by how much the cost rises to the ends of an interval.

    Notes
    -----
    With known noise twice the rise of the cost is chi-square distributed with one degree of freedom (Wilks 1938); with
    noise estimated from n - p = `freedom` degrees, the ratio of the rise to the cost over them follows Fisher's F
    (Seber and Wild, Nonlinear Regression, 1989, section 5.2).
    """
    if not 0 < level < 1:
        raise SceneError(f"level is {level}; give a probability between 0 and 1")
    return 0.5 * variance * float(chdtri(1, 1 - level) if freedom is None else fdtri(1, freedom, level))


def profile_of(
    problem: Problem,
    values: np.ndarray,
    cost: float,
    k: int,
    level: float,
    rise: float,
    jacobian: np.ndarray,
    points: int,
) -> Profiled:
    """Compute the profile of unknown `k` up to a rise of the cost; see `symfric.identification.fit.Fit.profile`."""
    if not isinstance(points, int) or points < FEWEST:
        raise SceneError(f"points is {shortened(points)}; give at least {FEWEST}")
    walk = _Walk(problem, values, cost, k, cost + rise)
    ends = tuple(walk.end(way, _first_step(problem, values, k, jacobian, rise), points) for way in (-1, 1))
    order = sorted(walk.minima.items())
    unknowns = problem.predictor.unknowns
    row, costs = np.array([v for v, _ in order]), np.array([m.cost for _, m in order])
    profile = Profile(unknowns.names[k], row, costs, (ends[0], ends[1]), level, cost + rise)
    return Profiled(profile, min(walk.minima.values(), key=lambda m: m.cost))


def _first_step(problem: Problem, values: np.ndarray, k: int, jacobian: np.ndarray, rise: float) -> float:
    """Return half the interval that a parabola has, at most a quarter of the range."""
    unknowns = problem.predictor.unknowns
    others = np.delete(jacobian, k, axis=1)
    own = jacobian[:, k] - (others @ np.linalg.lstsq(others, jacobian[:, k], rcond=1e-10)[0] if others.size else 0.0)
    wide = unknowns.high[k] - unknowns.low[k]
    size = float(np.linalg.norm(own))
    return float(np.clip(np.sqrt(2 * rise) / size if size > 0 else wide, 1e-9 * wide, 0.25 * wide))


class _Walk:
    """Costs at values of one unknown, each fitted from the nearest one already known."""

    def __init__(self, problem: Problem, values: np.ndarray, cost: float, k: int, threshold: float):
        self.problem, self.k, self.threshold, self.cost = problem, k, threshold, cost
        self.begin = float(values[k])
        self.minima: dict[float, Minimum] = {self.begin: Minimum(values, cost, 0, 0)}

    def at(self, value: float) -> float:
        """Return how far the lowest cost at a value is from the threshold, as a signed root."""
        if value not in self.minima:
            near = min(self.minima, key=lambda v: abs(v - value))
            held = replace(self.problem, fixed={**self.problem.fixed, self.k: value})
            start = self.minima[near].values.copy()
            start[self.k] = value
            self.minima[value] = minimise(held, start)
        return self._root(self.minima[value].cost)

    def _root(self, cost: float) -> float:
        """Return a measure that is nearly linear in the value and zero at the threshold."""
        return float(np.sqrt(max(cost - self.cost, 0.0)) - np.sqrt(self.threshold - self.cost))

    def end(self, way: int, step: float, points: int) -> float:
        """Return the end of the interval on one side, infinite if the bounds cut it off."""
        unknowns = self.problem.predictor.unknowns
        bound = float((unknowns.high if way > 0 else unknowns.low)[self.k])
        part = step / max(1, points // 2)
        inside, below = self.begin, self._root(self.cost)
        for turn in range(MOST):
            if inside == bound:
                return way * float("inf")
            value = inside + way * part * (1.0 if turn < points // 2 else 1.5 ** (turn - points // 2 + 1))
            value = min(max(value, unknowns.low[self.k]), unknowns.high[self.k])
            above = self.at(float(value))
            if above > 0:
                return self._between(inside, below, float(value), above)
            inside, below = float(value), above
        return way * float("inf")

    def _between(self, inside: float, below: float, outside: float, above: float) -> float:
        """Return the value at the threshold by false position (Illinois), halving the bracket every third time."""
        whole = abs(self._root(self.cost))
        for turn in range(REFINED):
            if turn % 3 == 2 or not np.isfinite(above):
                middle = 0.5 * (inside + outside)
            else:
                middle = inside - below * (outside - inside) / (above - below)
            at = self.at(middle)
            if abs(at) < CLOSE * whole or abs(outside - inside) < NARROW * abs(outside - self.begin):
                return middle
            if at > 0:
                outside, above, below = middle, at, 0.5 * below
            else:
                inside, below, above = middle, at, 0.5 * above
        return middle
