"""The smallest damping with which a motion settles in time: to rest, or to a given half range.

A motion with dry friction rests at a turning point, so the time of rest jumps by half cycles where a turning point just
fails to stick, and is smooth in between, where it mostly grows with the damping. So the least damping mostly lies on a
jump; between the points of a survey the jumps are found by the number of events, and each is bisected.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
import sympy as sp

from symfric.design.comparison import Compared, Comparison
from symfric.design.result import Curve, Design
from symfric.design.verification import BEST_FOUND, Interrupted, Neighbour, design
from symfric.errors import NotFound, SceneError
from symfric.long_calls import until_interrupted
from symfric.model.excitation import is_excited
from symfric.model.outputs import Events, HalfRange, StopTime
from symfric.model.scene import Scene
from symfric.orbits.steady_state import Schedule, Settling
from symfric.search import minimum, minimum_near
from symfric.solve.protocol import Program
from symfric.solve.routes import RouteName, prepare
from symfric.solve.run import finished

TOLERANCE, FINER = 1e-12, 1e-13  # tolerances of the search and of the verification
SURVEY, DECADES, SPEEDS = 65, 16, 17  # survey points over the bounds, per decade, and over the speeds
JUMPS = 50  # most jumps located between two points of the survey
NEARBY = 1e-6  # relative distance from the optimum at which the verification runs
SHARES = (0.9, 0.97, 0.99, 0.999, 1 - 1e-4, 1 - NEARBY, 1 + NEARBY)  # neighbouring designs, relative to the optimum


@dataclass(frozen=True)
class Seen:
    """Settling time or remaining half range of a motion, its number of events, and the worst speed."""

    value: float
    events: int
    speed: float | None = None


@dataclass(frozen=True, eq=False)
class Transient:
    """Settling time or remaining half range of a motion as a function of a parameter.

    Attributes
    ----------
    scene : Scene
    name : str
        The parameter.
    bounds : (float, float)
    settle, half_range : float
        Time by which the motion must settle, and the half range allowed afterwards; 0 for rest.
    speed : str
    speeds : (float, float) or None
        None if the scene's own speed is used.
    route : str or None
        Route of the runs; None for automatic selection.
    tolerance : float
    known : dict
        Results so far, by parameter value.
    """

    scene: Scene
    name: str
    bounds: tuple[float, float]
    settle: float
    half_range: float
    speed: str
    speeds: tuple[float, float] | None
    route: RouteName | None = None
    tolerance: float = TOLERANCE
    known: dict[float, Seen] = field(default_factory=dict)

    @property
    def level(self) -> float:
        """Largest allowed value."""
        return self.half_range or self.settle

    @property
    def label(self) -> str:
        """Of the value."""
        return f"half range after t = {self.settle:g}" if self.half_range else "time of rest"

    @cached_property
    def _numeric(self) -> Scene:
        """The scene at the upper bounds, so that no parameter is dropped as zero, with a numeric start."""
        high = {self.name: self.bounds[1]} | ({self.speed: self.speeds[1]} if self.speeds else {})
        numbers = self.scene.numbers()
        fixed = {s: numbers[s] for s, e in self.scene.initial.items() if not {self.name, self.speed} & _names(e)}
        return self.scene.starting(fixed).where(high)

    @cached_property
    def until_rest(self) -> Program:
        """Program that runs until rest."""
        outputs = {"rest": StopTime(), "events": Events()}
        until = self._numeric.until(max(self.scene.horizon, 2 * self.settle), outputs)
        return prepare(until, self.tolerance, self.route)

    @cached_property
    def beyond(self) -> Settling:
        """Programs that run until `settle` and measure from there to the horizon."""
        times, x = Schedule(self.settle, self.scene.horizon - self.settle), self.scene.system.q[0]
        return Settling(self._numeric, times, {"x": HalfRange(x)}, tolerance=self.tolerance, route=self.route)

    def __call__(self, damping: float) -> Seen:
        """Simulate, at the worst speed if there are several."""
        if damping not in self.known:
            self.known[damping] = self._worst(damping, self.speeds) if self.speeds else self.at(damping, None)
        return self.known[damping]

    def at(self, damping: float, speed: float | None) -> Seen:
        """Simulate at one speed."""
        values = {self.name: float(damping)} | ({} if speed is None else {self.speed: float(speed)})
        if self.half_range:
            return Seen(float(self.beyond.measured(values)["x"]), 0, speed)
        run = finished(self.until_rest.run(values=values))
        rest = float(run["rest"])
        return Seen(rest if np.isfinite(rest) else np.inf, len(run.events))

    def _worst(self, damping: float, between: tuple[float, float]) -> Seen:
        speeds = np.unique(np.linspace(*between, SPEEDS))
        seen = [self.at(damping, float(v)) for v in speeds]
        k = max(range(len(seen)), key=lambda i: seen[i].value)
        if 0 < k < len(seen) - 1:
            best = minimum_near(lambda v: -self.at(damping, v).value, speeds, k, xatol=1e-9 * speeds[k + 1])
            seen.append(self.at(damping, best.place))
        return max(seen, key=lambda s: s.value)

    def good(self, damping: float) -> bool:
        """Whether the motion settles in time."""
        return self(damping).value <= self.level


def _names(expr: sp.Expr | float) -> set[str]:
    return {s.name for s in sp.sympify(expr).free_symbols}


def settled(transient: Transient) -> Design:
    """Return the smallest damping with which a motion settles in time; see `symfric.design.damper.design`."""
    _check(transient)
    with until_interrupted("damper"):
        return _settled(transient)
    return _interrupted(transient)


def _interrupted(t: Transient) -> Design:
    """Return the smallest damping with which a motion settled in time before an interrupt."""
    good = sorted(damping for damping in t.known if t.good(damping))
    if not good:
        raise KeyboardInterrupt
    best, seen = good[0], t(good[0])
    x = np.array(sorted(t.known))
    y = np.array([t(float(d)).value for d in x])
    curve = Curve(x, np.where(np.isfinite(y), y, np.nan), t.level, t.name, t.label, (best,))
    scene = t.scene.where({t.name: best} | ({} if seen.speed is None else {t.speed: seen.speed}))
    return design({t.name: best}, best, (), scene, Interrupted(), curve, claim=BEST_FOUND, neighbours=())


def _settled(transient: Transient) -> Design:
    low, high = transient.bounds
    survey = np.linspace(low, high, SURVEY)
    if high > 0:
        survey = np.union1d(survey, np.geomspace(max(low, 1e-4 * high), high, DECADES))
    survey = np.clip(survey, low, high).tolist()
    if transient.good(low):
        return _design(transient, low, survey)
    for k, (a, b) in enumerate(itertools.pairwise(survey)):
        damping = _first(transient, a, b)
        if damping is None and transient.half_range:
            damping = _dip(transient, survey, k + 1)
        if damping is not None:
            return _design(transient, damping, survey)
    raise NotFound(_missing(transient))


def _check(t: Transient) -> None:
    if not t.half_range:
        if t.speeds:
            raise SceneError("a system that keeps sliding never rests; give half_range, the one allowed after settle")
        return
    if not t.scene.horizon > t.settle:
        raise SceneError(
            f"the scene's horizon {t.scene.horizon:g} ends before settle = {t.settle:g}; half_range is measured from "
            "settle to the horizon, so take scene.until(...) longer"
        )
    if is_excited(t.scene, frozenset({t.name, t.speed})):
        raise SceneError("the forces depend on time; settle with a half_range needs a free motion")


def _other_events(t: Transient, events: int, damping: float) -> bool:
    return t(damping).events != events


def _first(t: Transient, a: float, b: float) -> float | None:
    """Return the smallest sufficient damping between a, insufficient, and b; None if there is none."""
    for _ in range(JUMPS):
        before = t(a).events
        if t(b).events == before:
            return _between(t.good, a, b)[1] if t.good(b) else None
        short, beyond = _between(partial(_other_events, t, before), a, b)
        if t.good(short):
            return _between(t.good, a, short)[1]
        if t.good(beyond):
            return beyond
        a = beyond
    return _between(t.good, a, b)[1] if t.good(b) else None


def _dip(t: Transient, survey: list[float], k: int) -> float | None:
    """Return the smallest sufficient damping near a point of the survey with a local minimum."""
    if not (0 < k < len(survey) - 1 and t(survey[k]).value <= min(t(survey[k - 1]).value, t(survey[k + 1]).value)):
        return None
    ends = survey[k - 1], survey[k + 1]
    lowest = minimum(lambda d: t(float(d)).value, *ends, xatol=1e-9 * (ends[1] - ends[0])).place
    return _between(t.good, ends[0], lowest)[1] if t.good(lowest) else None


def _between(holds: Callable[[float], bool], a: float, b: float) -> tuple[float, float]:
    """Bisect a condition that fails at a and holds at b, down to two neighbouring floats."""
    while True:
        middle = 0.5 * (a + b)
        if middle <= a or middle >= b:
            return a, b
        a, b = (a, middle) if holds(middle) else (middle, b)


def _missing(t: Transient) -> str:
    damping, best = min(t.known.items(), key=lambda item: item[1].value)
    within = f"within the bounds ({t.bounds[0]:g}, {t.bounds[1]:g}) of {t.name}"
    if not np.isfinite(best.value):
        until = t.until_rest.scene.horizon
        return f"nothing {within} brings the motion to rest by t = {until:g}; if it slides for good, give half_range"
    nearest = f"the nearest, {t.name} = {damping:.6g}, "
    if t.half_range:
        at = "" if best.speed is None else f" at {t.speed} = {best.speed:.6g}"
        nearest += f"leaves a half range of {best.value:.9g}{at}, above {t.half_range:g} by {best.value - t.level:.9g}"
    else:
        nearest += f"is at rest at t = {best.value:.9g}, later than {t.settle:g} by {best.value - t.level:.9g}"
    return f"no motion {within} settles by t = {t.settle:g}: {nearest}"


def _design(t: Transient, damping: float, survey: list[float]) -> Design:
    seen = t(damping)
    at = "" if seen.speed is None else f" at {t.speed} = {seen.speed:.6g}"
    if damping == t.bounds[0]:
        active = f"{t.name} at its lower bound"
    elif t.half_range:
        active = f"half range {t.half_range:g} after t = {t.settle:g}{at}"
    else:
        less = t(damping * (1 - NEARBY)).value
        active = f"at rest at t = {seen.value:.9g}; with {t.name} smaller by {NEARBY:g} (relative): t = {less:.9g}"
    changes = {t.name: damping} | ({} if seen.speed is None else {t.speed: seen.speed})
    curve = _curve(t, damping, survey)
    check, scene = _checked(t, damping), t.scene.where(changes)
    beside = [_neighbour(t, damping, share) for share in SHARES if damping * share >= t.bounds[0]]
    if damping == 0:
        beside = [Neighbour(f"{t.name} = {survey[1]:g}", survey[1], t(survey[1]).value / t.level - 1)]
    return design({t.name: damping}, damping, (active,), scene, check, curve, claim="optimal", neighbours=beside)


def _neighbour(t: Transient, damping: float, share: float) -> Neighbour:
    """Return the neighbouring design with another damping."""
    word = "larger" if share > 1 else "smaller"
    change = f"{t.name} {word} by {100 * abs(share - 1):.2g} %"
    return Neighbour(change, damping * share, t(damping * share).value / t.level - 1)


def _checked(t: Transient, damping: float) -> Comparison:
    """Verify by the route taylor at a finer tolerance, slightly above and below the optimum."""
    other = Transient(
        t.scene, t.name, t.bounds, t.settle, t.half_range, t.speed, t.speeds, route="taylor", tolerance=FINER
    )
    sides = [("slightly more", 1 + NEARBY)]
    sides += [("slightly less", 1 - NEARBY)] if damping > t.bounds[0] else []
    rows = []
    for words, share in sides:
        seen = t(damping * share)
        value = other.at(damping * share, seen.speed).value
        at = "" if seen.speed is None else f" at {t.speed} = {seen.speed:.6g}"
        rows.append(Compared(f"{t.label}{at}, {words} {t.name}", seen.value, value, 1e-7, size=t.level))
    return Comparison(tuple(rows))


def _curve(t: Transient, damping: float, survey: list[float]) -> Curve:
    """Return the curve of the value over the bounds, interrupted at jumps."""
    above = [d for d in survey if d > damping][:: 4 if t.speeds else 1]
    x = np.array([*(d for d in survey if d < damping), damping, *above])
    seen = [t(float(d)) for d in x]
    y = np.array([s.value if np.isfinite(s.value) else np.nan for s in seen])
    jumps = np.flatnonzero(np.diff([s.events for s in seen])) + 1
    return Curve(np.insert(x, jumps, x[jumps]), np.insert(y, jumps, np.nan), t.level, t.name, t.label, (damping,))
