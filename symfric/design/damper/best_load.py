"""The parameter of a friction damper, most often its normal load, with the smallest peak of a forced response."""

from dataclasses import dataclass, field

import numpy as np

from symfric.design.comparison import Compared, Comparison
from symfric.design.result import Curve, Design
from symfric.design.verification import Neighbour, design
from symfric.model.outputs import HalfRange
from symfric.model.scene import Scene
from symfric.orbits.continuation.branch import Peak
from symfric.orbits.cycle import Orbit
from symfric.orbits.frequency_response import frequency_response
from symfric.search import minimum_near
from symfric.solve.routes import simulate

_SURVEY = 9  # values of the parameter, before polishing
_LEAST = 1e-3  # of the largest value: the smallest of the survey if the bounds begin at zero
_CLOSE = 1e-4  # relative error of the optimal parameter
_TOLERANCE = 1e-10  # of the motions
_BESIDE = (0.98, 1.02)  # neighbouring designs, as shares of the optimum
_SETTLED, _AGREES = 1e-9, 1e-6  # part of a disturbance left after settling; relative error of the check
_LONGEST = 2000  # most periods of the check


@dataclass
class Peaks:
    """Peaks of the forced response by the parameter, each computed once.

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

    def __call__(self, value: float) -> Peak:
        """Return the peak for a value of the parameter."""
        if value not in self.known:
            scene = self.scene.where({self.name: value})
            peak = frequency_response(scene, self.speed, self.span, self.coordinate, tolerance=_TOLERANCE).peak
            assert peak is not None
            self.known[value] = peak
        return self.known[value]


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
    low, high = max(bounds[0], _LEAST * bounds[1]), bounds[1]
    grid = np.geomspace(low, high, _SURVEY) if high > low else np.array([high])
    sizes = np.array([peaks(float(v)).half_range for v in grid])
    i = int(np.argmin(sizes))
    if 0 < i < len(grid) - 1:
        minimum_near(lambda e: peaks(float(np.exp(e))).half_range, np.log(grid), i, xatol=_CLOSE)
    best = min(peaks.known, key=lambda v: peaks.known[v].half_range)
    peak, name = peaks(best), peaks.name
    active = [f"peak of {peaks.coordinate} at {peaks.speed} = {peak.value:.6g}"]
    if best in (grid[0], grid[-1]):
        active.insert(0, f"{name} at {'its lower bound' if best == grid[0] == bounds[0] else 'an end of its bounds'}")
    shares = [s for s in _BESIDE if bounds[0] <= s * best <= bounds[1]]
    words = {s: f"{name} {'larger' if s > 1 else 'smaller'} by {100 * abs(s - 1):.0f} %" for s in shares}
    beside = [Neighbour(words[s], peaks(s * best).half_range, 0.0) for s in shares]
    x = np.array(sorted(peaks.known))
    y = np.array([peaks.known[v].half_range for v in x])
    curve = Curve(x, y, peak.half_range, name, f"largest half range of {peaks.coordinate}", (best,))
    placed = peaks.scene.where({name: best, peaks.speed: peak.value})
    check = Comparison((_settled(placed, peaks.coordinate, peak),))
    return design({name: best}, peak.half_range, active, placed, check, curve, claim="optimal", neighbours=beside)


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
