"""The parameter of a friction damper, most often its normal load, with the smallest peak of a forced response."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from symfric.design.comparison import Compared, Comparison
from symfric.design.result import Curve, Design
from symfric.design.verification import Interrupted, Neighbour, design
from symfric.long_calls import tell, until_interrupted
from symfric.model.outputs import HalfRange
from symfric.model.scene import Scene
from symfric.orbits.continuation.branch import Peak
from symfric.orbits.continuation.walk import Steps
from symfric.orbits.cycle import Orbit
from symfric.orbits.frequency_response import highest, response, summits
from symfric.search import minimum_near
from symfric.solve.routes import simulate

_SURVEY = 9  # values of the parameter, before polishing
_LEAST = 1e-3  # of the largest value: the smallest of the survey if the bounds begin at zero
_CLOSE = 1e-4  # relative error of the optimal parameter
_INWARD = 1e-3  # of the way to the next value of the survey: where the slope at an end of the bounds is read
_TOLERANCE = 1e-10  # of the motions
_ORBITS, _COARSE = 1000, Steps(0.1, 0.6)  # of a whole response, which only tells where its peaks are
_BESIDE = (0.98, 1.02)  # neighbouring designs, as shares of the optimum
_SETTLED, _AGREES = 1e-9, 1e-6  # part of a disturbance left after settling; relative error of the check
_LONGEST = 2000  # most periods of the check
# distance, relative to the span, within which a peak is first sought; factor of the next searches, and their number;
# distance from an end, relative to it, at which a search goes on beyond
_NEAR, _WIDER, _SEARCHES, _EDGE = 0.02, 3.0, 3, 0.02
_LOW = 0.5  # half range relative to that of the highest peak below which another one is not followed
_PLACED = 1e-6  # relative error of their frequencies; the half range at a peak hardly depends on it
_OTHER = 1e-7  # relative excess of the whole response over the peaks that were followed


@dataclass
class Peaks:
    """Peaks of the forced response by the parameter, each computed once.

    Of the whole response over the span, or, between values for which that is known, of its local peaks alone, which
    are followed from there.

    Attributes
    ----------
    scene : Scene
    name, speed : str
        The parameter, and the frequency of the excitation.
    span : (float, float)
        Of the frequency.
    coordinate : str
        Whose half range counts.
    """

    scene: Scene
    name: str
    speed: str
    span: tuple[float, float]
    coordinate: str
    known: dict[float, Peak] = field(default_factory=dict)
    whole: dict[float, list[Peak]] = field(default_factory=dict)

    @cached_property
    def _state(self) -> int:
        return [s.name for s in self.scene.system.states].index(self.coordinate)

    def __call__(self, value: float) -> Peak:
        """Return the peak of the whole response for a value of the parameter."""
        if value not in self.whole:
            scene = self.scene.where({self.name: value})
            branch = response(scene, self.speed, self.span, self.coordinate, None, _ORBITS, _TOLERANCE, _COARSE)
            assert branch.peak is not None
            self.whole[value], self.known[value] = summits(branch, self._state), branch.peak
        return self.known[value]

    def followed(self, value: float) -> Peak:
        """Return the highest of the local peaks of the whole responses for the values on both sides."""
        if value not in self.known:
            places = np.array(sorted(self.whole))
            i = int(np.clip(np.searchsorted(places, value), 1, places.size - 1))
            begin = []
            for peaks in (self.whole[float(v)] for v in places[i - 1 : i + 1]):
                largest = max(peak.half_range for peak in peaks)
                begin += [peak for peak in peaks if peak.half_range >= _LOW * largest]
            moved = [self._moved(value, peak) for peak in begin]
            reached = [peak for peak in moved if peak is not None]
            if len(reached) < len(moved):
                return self(value)
            self.known[value] = max(reached, key=lambda peak: peak.half_range)
        return self.known[value]

    def _moved(self, value: float, before: Peak) -> Peak | None:
        """Return the local peak that one for another value of the parameter becomes; None if it is not found."""
        scene, reach = self.scene.where({self.name: value}), _NEAR * (self.span[1] - self.span[0])
        peak = before
        for _ in range(_SEARCHES):
            ends = max(self.span[0], peak.value - reach), min(self.span[1], peak.value + reach)
            near = peak._replace(half_range=0.0)
            peak = highest(scene, self.speed, self._state, near, ends, _TOLERANCE, _PLACED)
            if peak.half_range == 0.0:
                return None
            at_end = [abs(peak.value - end) < _EDGE * reach for end in ends]
            if not any(at and end not in self.span for at, end in zip(at_end, ends, strict=True)):
                return peak
            reach *= _WIDER
        return None


def best_load(peaks: Peaks, bounds: tuple[float, float]) -> Design:
    """Find the value with the smallest peak.

    Parameters
    ----------
    peaks : Peaks
    bounds : (float, float)
        Of the parameter; if they begin at zero the survey begins at a thousandth of the upper one.

    Raises
    ------
    NotFound
        If no response is found to start from.
    """
    with until_interrupted("damper"):
        return _best_load(peaks, bounds)
    # interrupted, within `keep_when_interrupted`: the best value until then
    if not peaks.known:
        raise KeyboardInterrupt
    best = min(peaks.known, key=lambda v: peaks.known[v].half_range)
    placed = peaks.scene.where({peaks.name: best, peaks.speed: peaks.known[best].value})
    size, curve = peaks.known[best].half_range, _curve(peaks, best)
    return design({peaks.name: best}, size, (), placed, Interrupted(), curve, claim="best found", neighbours=())


def _best_load(peaks: Peaks, bounds: tuple[float, float]) -> Design:
    low, high = max(bounds[0], _LEAST * bounds[1]), bounds[1]
    grid = np.geomspace(low, high, _SURVEY) if high > low else np.array([high])
    sizes = np.full(grid.size, np.inf)
    for k, value in enumerate(grid.tolist()):
        tell(f"the response at {peaks.name} = {value:.5g}, {k + 1} of {grid.size}")
        sizes[k] = peaks(value).half_range
    tell("the best value refined")
    i = int(np.argmin(sizes))
    if 0 < i < len(grid) - 1 or _falls_inward(peaks, grid, i):
        _polish(peaks, grid, i)
    best = min(peaks.known, key=lambda v: peaks.known[v].half_range)
    peak, name = peaks(best), peaks.name
    active = [f"peak of {peaks.coordinate} at {peaks.speed} = {peak.value:.6g}"]
    if best in (grid[0], grid[-1]):
        active.insert(0, f"{name} at {'its lower bound' if best == grid[0] == bounds[0] else 'an end of its bounds'}")
    shares = [s for s in _BESIDE if bounds[0] <= s * best <= bounds[1]]
    words = {s: f"{name} {'larger' if s > 1 else 'smaller'} by {100 * abs(s - 1):.0f} %" for s in shares}
    beside = [Neighbour(words[s], peaks.followed(s * best).half_range, 0.0) for s in shares]
    curve = _curve(peaks, best)
    placed = peaks.scene.where({name: best, peaks.speed: peak.value})
    check = Comparison((_settled(placed, peaks.coordinate, peak),))
    return design({name: best}, peak.half_range, active, placed, check, curve, claim="optimal", neighbours=beside)


def _falls_inward(peaks: Peaks, grid: np.ndarray, end: int) -> bool:
    """Return whether the peak at an end of the grid, the smallest of the survey, falls from there into the bounds."""
    if len(grid) == 1:
        return False
    inner = grid[1 if end == 0 else -2]
    beside = float(grid[end] ** (1 - _INWARD) * inner**_INWARD)
    return peaks.followed(beside).half_range < peaks.known[float(grid[end])].half_range


def _curve(peaks: Peaks, best: float) -> Curve:
    """Return the largest half range over the values of the parameter that were computed."""
    x = np.array(sorted(peaks.known))
    y = np.array([peaks.known[v].half_range for v in x])
    level = peaks.known[best].half_range
    return Curve(x, y, level, peaks.name, f"largest half range of {peaks.coordinate}", (best,))


def _size(peak_of: Callable[[float], Peak], logarithm: float) -> float:
    return peak_of(float(np.exp(logarithm))).half_range


def _polish(peaks: Peaks, grid: np.ndarray, i: int) -> None:
    """Search the value with the smallest peak between the neighbours of point i of a grid.

    On the local peaks, and on whole responses if that for the best value has a higher one.
    """
    for peak_of in (peaks.followed, peaks):
        minimum_near(partial(_size, peak_of), np.log(grid), i, xatol=_CLOSE)
        best = min(peaks.known, key=lambda v: peaks.known[v].half_range)
        followed = peaks.known[best].half_range
        if peaks(best).half_range <= followed * (1 + _OTHER):
            return
        for value in set(peaks.known) - set(peaks.whole):
            del peaks.known[value]


def _settled(scene: Scene, coordinate: str, peak: Peak) -> Compared:
    """Compare the half range at the peak with that of the motion which settles from a start beside the orbit."""
    orbit: Orbit = peak.orbit
    largest = float(np.max(np.abs(orbit.multipliers[np.abs(orbit.multipliers) < 1 - 1e-9]), initial=0.1))
    periods = int(np.clip(np.ceil(np.log(_SETTLED) / np.log(largest)), 20, _LONGEST))
    state = next(s for s in scene.system.states if s.name == coordinate)
    begin = {s.name: 0.9 * v for s, v in zip(scene.system.states, orbit.start.tolist(), strict=True)}
    run = simulate(scene.starting(begin).until(periods * orbit.period, {}), _TOLERANCE, route="taylor")
    late = scene.starting(dict(zip(run.names, run.final.tolist(), strict=True)))
    size = simulate(late.until(orbit.period, {"size": HalfRange(state)}), _TOLERANCE)["size"]
    quantity = f"half range of {coordinate} after {periods} periods of a disturbed motion"
    return Compared(quantity, peak.half_range, float(size), _AGREES)
