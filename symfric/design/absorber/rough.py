"""Mass damper with a dry contact: least worst-case steady amplitude over a frequency band, on the event-driven model.

The amplitude at a frequency comes from runs over whole periods until it repeats. The worst frequencies are the local
maxima of the amplitude, each polished; where one of them is highest the amplitude's slopes with tuning and damping are
those at a fixed frequency, because the slope with the frequency vanishes there. So the least worst amplitude is the
least bound above all of them: a smooth problem for each set of worst frequencies, which is completed and solved again.
"""

import itertools
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import pi
from typing import Any, TypeAlias

import numpy as np

from symfric.design.comparison import Compared, Comparison
from symfric.design.polish import polished
from symfric.design.result import Curve, Design
from symfric.design.verification import BEST_FOUND, Interrupted, Neighbour, design
from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import tell, until_interrupted
from symfric.model import scenes
from symfric.model.excitation import excitation_of
from symfric.model.outputs import HalfRange
from symfric.model.scene import Scene
from symfric.model.symbols import TIME, finite, positive
from symfric.orbits.steady_state import Schedule, Settling
from symfric.search import minimum
from symfric.solve.run import finished
from symfric.theory import absorber as theory

# peaks, point, and how the search ended
Candidate: TypeAlias = tuple[list[tuple[float, float]], np.ndarray, str]
TOLERANCE = 1e-10  # tolerance of the runs
# forcing periods in one run; most runs until the amplitude repeats; the same in a survey
BLOCK, BLOCKS, FEW = 10, 30, 4
CONTENDER = 0.7  # amplitude relative to the highest of the survey from which a peak is followed
REPEATS = 1e-8  # relative change of the amplitude between blocks that counts as zero
NEAR = 0.9  # height relative to the highest peak from which a new peak joins the set
GRID = 41  # frequencies of the band at which peaks are sought
STEP = 1e-4  # step of central differences
TUNINGS = np.linspace(0.85, 1.15, 7)  # survey of starting points, relative to the optimum without contact
DAMPINGS = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2])
STARTS = 2  # number of searches, from the best points of the survey
ROUNDS = 4  # most rounds of completing the set of worst frequencies
REGION, SMALLEST = 0.03, 1e-4  # largest and smallest step of damping, and of tuning relative to itself
BUDGET = 12000  # most runs of one search; some seconds
DAMPING = (0.0, 2.0)
REACH = 0.15, 2e-3  # first and last distance of the derivative-free search, relative to the survey
POLISHED = 3  # points of that search that are evaluated at all frequencies
_AXES = "frequency Omega/omega1", "amplitude |x1 k1/F|"
AROUND = 3e-3  # distance of the neighbouring designs: relative in tuning, absolute in damping


class Spent(Exception):
    """Raised when the budget of runs is used up."""


@dataclass(eq=False)
class Forced:
    """Steady amplitude of the main mass under a force of amplitude 1.

    Attributes
    ----------
    settling : Settling
        Its windows are of `BLOCK` periods, time in units of 1/Omega.
    band : (float, float)
    left : int
        Runs that may still be made; beyond, `Spent` is raised.
    known : dict
        Peaks that were computed, by tuning and damping.
    """

    settling: Settling
    band: tuple[float, float]
    left: int = 0
    known: dict[tuple[float, float], list[tuple[float, float]]] = field(default_factory=dict)

    def amplitude(self, tuning: float, damping: float, Omega: float, blocks: int = BLOCKS) -> float:
        """Return half the range of x1 over the last `BLOCK` periods; it starts at rest.

        While the contact sticks in the absorber nothing damps the main mass, so that away from the peaks the amplitude
        may never repeat; then it is the largest one after half of the blocks. A survey takes few of them.
        """
        values = {"tuning": float(tuning), "damping": float(damping), "Omega": float(Omega)}
        windows = self.settling.windows(values, dict.fromkeys(self.settling.states, 0.0))
        sizes: list[float] = []
        for _ in range(blocks):
            if self.left <= 0:
                raise Spent
            self.left -= 1
            sizes.append(finished(next(windows))["amplitude"])
            if len(sizes) > 1 and abs(sizes[-1] - sizes[-2]) <= REPEATS * max(sizes[-1], 1e-6):
                return sizes[-1]
        return max(sizes[blocks // 2 :])

    def peaks(self, tuning: float, damping: float) -> list[tuple[float, float]]:
        """Return frequency and amplitude of the high peaks in the band, its ends too, the highest first."""
        g = np.linspace(*self.band, GRID)
        y = np.array([self.amplitude(tuning, damping, e, FEW) for e in g])
        left, right = np.concatenate([[-np.inf], y[:-1]]), np.concatenate([y[1:], [-np.inf]])
        peaks = []
        for k in np.flatnonzero((y >= left) & (y >= right) & (y >= CONTENDER * np.max(y))).tolist():
            ends = g[max(k - 1, 0)], g[min(k + 1, g.size - 1)]
            peaks.append(self._polished(tuning, damping, *ends))
        self.known[float(tuning), float(damping)] = sorted(peaks, key=lambda p: -p[1])
        return self.known[float(tuning), float(damping)]

    def near(self, tuning: float, damping: float, Omega: float) -> tuple[float, float]:
        """Return frequency and amplitude of the highest point within one grid cell around a frequency."""
        cell = (self.band[1] - self.band[0]) / (GRID - 1)
        ends = max(Omega - cell, self.band[0]), min(Omega + cell, self.band[1])
        return self._polished(tuning, damping, *ends)

    def _polished(self, tuning: float, damping: float, low: float, high: float) -> tuple[float, float]:
        if not high > low:
            return low, self.amplitude(tuning, damping, low)
        top = minimum(lambda g: -self.amplitude(tuning, damping, g), low, high, xatol=3e-5)
        points = [(top.place, -top.value)]
        points += [(g, self.amplitude(tuning, damping, g)) for g in (low, high) if g in self.band]
        return max(points, key=lambda p: p[1])


def rough_absorber(
    mass_ratio: float, contact: str, friction: float, static_friction: float | None, band: tuple[float, float]
) -> Design:
    """Find tuning and damping of the least worst-case amplitude; see `symfric.design.absorber.classic.absorber`.

    Returns
    -------
    Design
        Its status is "best found" if a search ended with its budget of runs, or if a design beside it was better: so
        with friction so large that the contact sticks for whole periods, where the amplitude jumps and may not repeat.
        There a short search without derivatives follows; a design that is better by some per cent may still exist.
        "optimal" is local: another pair of worst frequencies may have a lower peak.

    Notes
    -----
    The masses start at rest at every frequency; where static friction is large a motion may live beside the rest, and
    is not seen. The friction of a contact is a share of the force: another force needs another design.
    """
    low, high = (finite(e, "a bound of band") for e in band)
    if not 0 < low <= high:
        raise SceneError(f"band is ({low:g}, {high:g}); give frequencies over omega1, the lower one first and positive")
    positive(friction, "friction", zero=True)
    plain = theory.least_peak(mass_ratio)
    options: dict[str, Any] = {"contact": contact, "friction": friction, "static_friction": static_friction}
    scene = scenes.absorber(mass_ratio=mass_ratio, tuning=plain.tuning, damping=plain.damping, **options)
    x1 = scene.system.q[0]
    times, outputs = Schedule(0.0, 2 * pi * BLOCK, 2 * pi), {"amplitude": HalfRange(x1)}
    forced = Forced(Settling(_in_phase(scene), times, outputs, tolerance=TOLERANCE), (low, high))
    with until_interrupted("absorber"):
        tell("a survey of tuning and damping")
        starts = _starts(forced, plain)
        tell("the best points refined")
        best = min((_least(forced, start) for start in starts), key=lambda f: f[0][0][1])
        if best[2] != "optimal" or any(n.beats(best[0][0][1], 1) for n in _beside(forced, best[1])):
            best = min([best, *_polled(forced, plain, [best[1], starts[0]])], key=lambda f: f[0][0][1])
        tell("verification of the design")
        return _design(forced, scene, *best)
    return _interrupted(forced, scene)


def _interrupted(forced: Forced, scene: Scene) -> Design:
    """Return the best design whose peaks were computed before an interrupt."""
    if not forced.known:
        raise KeyboardInterrupt
    tuning, damping = min(forced.known, key=lambda p: forced.known[p][0][1])
    peaks, values = sorted(forced.known[tuning, damping]), {"tuning": tuning, "damping": damping}
    worst, highest = max(peaks, key=lambda p: p[1])
    frequencies, amplitudes = np.array(peaks).T
    curve = Curve(frequencies, amplitudes, highest, *_AXES, (worst,))
    placed = scene.where({**values, "Omega": worst})
    return design(values, highest, (), placed, Interrupted(), curve, claim=BEST_FOUND, neighbours=())


@alone(SYMBOLIC)
def _in_phase(scene: Scene) -> Scene:
    """Return the scene with time in units of 1/Omega, so that whole periods have the same length at all frequencies."""
    system, Omega = scene.system, scene.parameter("Omega")
    slow = {u: Omega * u for u in system.u} | {TIME: TIME / Omega}
    force = [e.subs(slow, simultaneous=True) for e in system.force]
    return replace(scene, system=replace(system, mass=system.mass * Omega**2, force=force))


def _starts(forced: Forced, plain: theory.Tuned) -> list[np.ndarray]:
    """Return the best points of a coarse survey."""
    places = [np.array([plain.tuning * f, plain.damping * z]) for f in TUNINGS for z in DAMPINGS]
    forced.left = FEW * GRID * len(places)
    g = np.linspace(*forced.band, GRID)[::2]
    worst = [max(forced.amplitude(tuning, damping, e, FEW) for e in g) for tuning, damping in places]
    return [places[k] for k in np.argsort(worst)[:STARTS]]


def _least(forced: Forced, start: np.ndarray) -> Candidate:
    """Return the peaks and the point of the least worst-case amplitude near a start, and how the search ended."""
    forced.left = BUDGET
    p, peaks = start, forced.peaks(*start)
    best, places = (peaks, p, "best found"), [g for g, _ in peaks]
    with suppress(Spent):
        for _ in range(ROUNDS):
            p, peaks, places, done = _round(forced, p, places)
            best = (peaks, p, "optimal" if done else "best found") if peaks[0][1] <= best[0][0][1] else best
            if done:
                break
    return best


def _polled(forced: Forced, plain: theory.Tuned, starts: list[np.ndarray]) -> Iterator[Candidate]:
    """Search without derivatives, for amplitudes that jump; returns the same as `_least`."""
    low = np.array([plain.tuning * TUNINGS[0], DAMPINGS[0]])
    width = np.array([plain.tuning * TUNINGS[-1], plain.damping * DAMPINGS[-1]]) - low
    g, known = np.linspace(*forced.band, GRID)[::2], {}

    def merit(place: np.ndarray) -> tuple[float]:
        tuning, damping = low + place * width
        known[tuning, damping] = max(forced.amplitude(tuning, damping, e, FEW) for e in g)
        return (known[tuning, damping],)

    for start in starts:
        forced.left = BUDGET // 2
        with suppress(Spent):
            polished(merit, np.clip((start - low) / width, 0.0, 1.0), *REACH)
    forced.left = BUDGET
    for p in sorted(known, key=known.__getitem__)[:POLISHED]:
        with suppress(Spent):
            yield forced.peaks(*p), np.array(p), "best found"


def _round(
    forced: Forced, p: np.ndarray, places: list[float]
) -> tuple[np.ndarray, list[tuple[float, float]], list[float], bool]:
    """Return the next point, its peaks, the set of worst frequencies, and whether the search has converged."""
    p, known = _bounded(forced, p, places)
    peaks = forced.peaks(*p)
    apart = 0.5 * (forced.band[1] - forced.band[0]) / (GRID - 1)
    new = [g for g, y in peaks if y > NEAR * peaks[0][1] and min(abs(g - k) for k in known) > apart]
    return p, peaks, known + new, not new


def _bounded(forced: Forced, p: np.ndarray, places: list[float]) -> tuple[np.ndarray, list[float]]:
    """Minimise the highest of the peaks near given frequencies; return the point and the frequencies.

    Linear programs in a trust region. Where two peaks are equally high, as is usual, the amplitude is curved along the
    remaining direction, and the region shrinks towards its lowest point.
    """
    points = [forced.near(p[0], p[1], g) for g in places]
    size, slopes = REGION, None
    while size > SMALLEST:
        if slopes is None:
            slopes = np.array([_slopes(forced, p, g) for g, _ in points])
        step = _step(np.array([y for _, y in points]), slopes, p, size)
        tuning, damping = p + step
        trial = [forced.near(tuning, damping, g) for g, _ in points]
        gain = max(y for _, y in points) - max(y for _, y in trial)
        if gain > 0:
            p, points, slopes = p + step, trial, None
            size = min(1.5 * size, REGION)
        else:
            size *= 0.4
    return p, [g for g, _ in points]


def _step(heights: np.ndarray, slopes: np.ndarray, p: np.ndarray, size: float) -> np.ndarray:
    """Return the step to the least bound above the linearised peaks; `size` bounds damping, and tuning as a share."""
    from scipy.optimize import linprog

    width = size * np.array([p[0], 1.0])
    low, high = np.maximum(-width, [-np.inf, DAMPING[0] - p[1]]), np.minimum(width, [np.inf, DAMPING[1] - p[1]])
    above = np.column_stack([slopes, -np.ones(heights.size)])
    bounds = [*zip(low, high, strict=True), (None, None)]
    return linprog([0.0, 0.0, 1.0], A_ub=above, b_ub=-heights, bounds=bounds).x[:2]


def _slopes(forced: Forced, p: np.ndarray, Omega: float) -> list[float]:
    """Return the slopes of the amplitude with tuning and damping at a frequency."""
    slopes = []
    for d in np.eye(2) * STEP:
        low, high = np.maximum(p - d, [0.0, DAMPING[0]]), p + d
        rise = forced.amplitude(high[0], high[1], Omega) - forced.amplitude(low[0], low[1], Omega)
        slopes.append(float(rise / np.sum(high - low)))
    return slopes


def _design(forced: Forced, scene: Scene, peaks: list[tuple[float, float]], p: np.ndarray, status: str) -> Design:
    forced.left = BUDGET
    values = {"tuning": float(p[0]), "damping": float(p[1])}
    highest = peaks[0][1]
    worst = sorted(g for g, y in peaks if y >= highest * (1 - 1e-5))
    scene = scene.where({**values, "Omega": worst[0]})
    active = [f"amplitude at Omega = {g:.6g}" for g in worst]
    if values["damping"] <= DAMPING[0]:
        active.append("damping at its lower bound")
    rows = [Compared(f"amplitude at Omega = {g:.6g}", highest, _in_time(scene, g), 1e-5) for g in worst]
    g = np.unique(np.concatenate([np.linspace(*forced.band, 2 * GRID - 1), worst]))
    y = np.array([forced.amplitude(p[0], p[1], e, FEW) for e in g])
    curve = Curve(g, y, highest, *_AXES, tuple(worst))
    check, beside = Comparison(tuple(rows)), _beside(forced, p)
    return design(values, highest, active, scene, check, curve, claim=status, neighbours=beside)


def _beside(forced: Forced, p: np.ndarray) -> list[Neighbour]:
    """Return the neighbours of a design, with all peaks in the band."""
    forced.left, neighbours = BUDGET, []
    with suppress(Spent):
        for f, z in itertools.product((-1, 0, 1), (-1, 0, 1)):
            q = np.array([p[0] * (1 + f * AROUND), p[1] + z * AROUND])
            if (f or z) and DAMPING[0] <= q[1] <= DAMPING[1]:
                neighbours.append(Neighbour(f"tuning {q[0]:.6g}, damping {q[1]:.6g}", forced.peaks(*q)[0][1], 0.0))
    return neighbours


def _in_time(scene: Scene, Omega: float) -> float:
    """Return the amplitude of the original scene after the largest number of periods of `Forced.amplitude`."""
    scene = scene.where({"Omega": Omega})
    period = excitation_of(scene).period({s.name: v for s, v in scene.parameter_values().items()})
    times = Schedule(BLOCKS * BLOCK * period, BLOCK * period, period)
    outputs = {"amplitude": HalfRange(scene.system.q[0])}
    return Settling(scene, times, outputs, tolerance=TOLERANCE).measured()["amplitude"]
