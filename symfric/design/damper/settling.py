"""The smallest damping with which a motion is over in time: at rest, or down to a given half range.

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
from scipy.optimize import minimize_scalar

from symfric.design.comparison import Compared, Comparison
from symfric.design.result import Curve, Design
from symfric.design.verification import Neighbour, design
from symfric.errors import NotFound, SceneError
from symfric.model.excitation import is_excited
from symfric.model.outputs import Events, HalfRange, StopTime
from symfric.model.scene import Scene
from symfric.orbits.steady_state import Schedule, Settling
from symfric.solve.routes import Program, prepare

TOLERANCE, FINER = 1e-12, 1e-13  # of the runs that search, and of those that check
SURVEY, DECADES, SPEEDS = 65, 16, 17  # points over the bounds, over their decades, and over the speeds
JUMPS = 50  # between two points of the survey, at most
HAIR = 1e-6  # of the damping: how far beside the optimum the check asks
SHARES = (0.9, 0.97, 0.99, 0.999, 1 - 1e-4, 1 - HAIR, 1 + HAIR)  # of the damping: designs beside the optimum


@dataclass(frozen=True)
class Seen:
    """How long a motion lasts, or how large it still is; its events, and the speed at which it is worst."""

    value: float
    events: int
    speed: float | None = None


@dataclass(frozen=True, eq=False)
class Transient:
    """What is left of a motion as a function of a parameter.

    Attributes
    ----------
    scene : Scene
    name : str
        The parameter.
    bounds : (float, float)
    settle, half_range : float
        Time by which the motion must be over, and what may be left; 0 for rest.
    speed : str
    speeds : (float, float) or None
        None where the scene has its own.
    route : str or None
        Of the runs; None for the cheapest.
    tolerance : float
    known : dict
        What was seen, by the parameter.
    """

    scene: Scene
    name: str
    bounds: tuple[float, float]
    settle: float
    half_range: float
    speed: str
    speeds: tuple[float, float] | None
    route: str | None = None
    tolerance: float = TOLERANCE
    known: dict = field(default_factory=dict)

    @property
    def level(self) -> float:
        """What the value may be."""
        return self.half_range or self.settle

    @cached_property
    def _numeric(self) -> Scene:
        """The scene at the upper bounds, so that nothing is left out for being zero, started from numbers."""
        high = {self.name: self.bounds[1]} | ({self.speed: self.speeds[1]} if self.speeds else {})
        numbers = self.scene.numbers()
        fixed = {s: numbers[s] for s, e in self.scene.initial.items() if not {self.name, self.speed} & _names(e)}
        return self.scene.starting(fixed).where(high)

    @cached_property
    def until_rest(self) -> Program:
        """Runs until the rest."""
        until = self._numeric.until(max(self.scene.horizon, 2 * self.settle))
        return prepare(until.wanting({"rest": StopTime(), "events": Events()}), self.tolerance, self.route)

    @cached_property
    def beyond(self) -> Settling:
        """Runs until the time given, and measures from there to the horizon."""
        times, x = Schedule(self.settle, self.scene.horizon - self.settle), self.scene.system.q[0]
        return Settling(self._numeric, times, {"x": HalfRange(x)}, tolerance=self.tolerance, route=self.route)

    def __call__(self, damping: float) -> Seen:
        """Run, at the worst speed if there are several."""
        if damping not in self.known:
            self.known[damping] = self._worst(damping, self.speeds) if self.speeds else self.at(damping, None)
        return self.known[damping]

    def at(self, damping: float, speed: float | None) -> Seen:
        """Run at one speed."""
        values = {self.name: float(damping)} | ({} if speed is None else {self.speed: float(speed)})
        if self.half_range:
            return Seen(float(self.beyond.measured(values)["x"]), 0, speed)
        run = self.until_rest.run(values=values).checked()
        rest = float(run["rest"])
        return Seen(rest if np.isfinite(rest) else np.inf, len(run.events))

    def _worst(self, damping: float, between: tuple[float, float]) -> Seen:
        speeds = np.unique(np.linspace(*between, SPEEDS))
        seen = [self.at(damping, float(v)) for v in speeds]
        k = max(range(len(seen)), key=lambda i: seen[i].value)
        if 0 < k < len(seen) - 1:
            ends = speeds[k - 1], speeds[k + 1]
            options = {"xatol": 1e-9 * ends[1]}
            best = minimize_scalar(lambda v: -self.at(damping, v).value, bounds=ends, method="bounded", options=options)
            seen.append(self.at(damping, float(best.x)))
        return max(seen, key=lambda s: s.value)

    def good(self, damping: float) -> bool:
        """Whether the motion is over in time."""
        return self(damping).value <= self.level


def _names(expr) -> set[str]:
    return {s.name for s in sp.sympify(expr).free_symbols}


def settled(transient: Transient) -> Design:
    """Return the smallest damping with which a motion is over in time; see `symfric.design.damper.design`."""
    _check(transient)
    low, high = transient.bounds
    survey = np.linspace(low, high, SURVEY)
    if high > 0:
        survey = np.union1d(survey, np.geomspace(max(low, 1e-4 * high), high, DECADES))
    survey = np.clip(survey, low, high).tolist()
    if transient.good(low):
        return _design(transient, low, survey)
    for k, (a, b) in enumerate(itertools.pairwise(survey)):
        found = _first(transient, a, b)
        if found is None and transient.half_range:
            found = _dip(transient, survey, k + 1)
        if found is not None:
            return _design(transient, found, survey)
    raise NotFound(_missing(transient))


def _check(t: Transient) -> None:
    if not t.half_range:
        if t.speeds:
            raise SceneError("a system that slides never rests; give half_range, what may be left after settle")
        return
    if not t.scene.horizon > t.settle:
        raise SceneError(
            f"the scene's horizon {t.scene.horizon:g} ends before settle = {t.settle:g}; half_range is measured from "
            "settle to the horizon, so take scene.until(...) longer"
        )
    if is_excited(t.scene, frozenset({t.name, t.speed})):
        raise SceneError("the forces depend on time; settle with a half_range takes free motions")


def _other_events(t: Transient, events: int, damping: float) -> bool:
    return t(damping).events != events


def _first(t: Transient, a: float, b: float) -> float | None:
    """Return the smallest damping between a, not enough, and b that is enough; None if there is none."""
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
    """Return the smallest damping that is enough beside a point of the survey that the others exceed."""
    if not (0 < k < len(survey) - 1 and t(survey[k]).value <= min(t(survey[k - 1]).value, t(survey[k + 1]).value)):
        return None
    ends = survey[k - 1], survey[k + 1]
    options = {"xatol": 1e-9 * (ends[1] - ends[0])}
    best = minimize_scalar(lambda d: t(float(d)).value, bounds=ends, method="bounded", options=options)
    return _between(t.good, ends[0], float(best.x))[1] if t.good(float(best.x)) else None


def _between(holds: Callable[[float], bool], a: float, b: float) -> tuple[float, float]:
    """Return two neighbouring numbers between which a condition that fails at a and holds at b begins to hold."""
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
    return f"no motion {within} is over by t = {t.settle:g}: {nearest}"


def _design(t: Transient, damping: float, survey: list[float]) -> Design:
    seen = t(damping)
    at = "" if seen.speed is None else f" at {t.speed} = {seen.speed:.6g}"
    if damping == t.bounds[0]:
        active = f"{t.name} at its lower bound"
    elif t.half_range:
        active = f"half range {t.half_range:g} after t = {t.settle:g}{at}"
    else:
        less = t(damping * (1 - HAIR)).value
        active = f"at rest at t = {seen.value:.9g}; a hair less {t.name} takes {less:.9g}"
    changes = {t.name: damping} | ({} if seen.speed is None else {t.speed: seen.speed})
    curve = _curve(t, damping, survey)
    check, scene = _checked(t, damping), t.scene.where(changes)
    beside = [_neighbour(t, damping, share) for share in SHARES if damping * share >= t.bounds[0]]
    if damping == 0:
        beside = [Neighbour(f"{t.name} = {survey[1]:g}", survey[1], t(survey[1]).value / t.level - 1)]
    return design({t.name: damping}, damping, (active,), scene, check, curve, claim="optimal", neighbours=beside)


def _neighbour(t: Transient, damping: float, share: float) -> Neighbour:
    """Return the design with another damping."""
    word = "larger" if share > 1 else "smaller"
    change = f"{t.name} {word} by {100 * abs(share - 1):.2g} %"
    return Neighbour(change, damping * share, t(damping * share).value / t.level - 1)


def _checked(t: Transient, damping: float) -> Comparison:
    """Ask the event-driven model a hair above and below, by the general route and more finely."""
    other = Transient(
        t.scene, t.name, t.bounds, t.settle, t.half_range, t.speed, t.speeds, route="taylor", tolerance=FINER
    )
    sides = [("a hair more", 1 + HAIR)] + ([("a hair less", 1 - HAIR)] if damping > t.bounds[0] else [])
    quantity = f"half range after t = {t.settle:g}" if t.half_range else "time of rest"
    rows = []
    for words, share in sides:
        seen = t(damping * share)
        value = other.at(damping * share, seen.speed).value
        at = "" if seen.speed is None else f" at {t.speed} = {seen.speed:.6g}"
        rows.append(Compared(f"{quantity}{at}, {words} {t.name}", seen.value, value, 1e-7, size=t.level))
    return Comparison(tuple(rows))


def _curve(t: Transient, damping: float, survey: list[float]) -> Curve:
    """Return the value over the bounds, apart where it jumps."""
    above = [d for d in survey if d > damping][:: 4 if t.speeds else 1]
    x = np.array([*(d for d in survey if d < damping), damping, *above])
    seen = [t(float(d)) for d in x]
    y = np.array([s.value if np.isfinite(s.value) else np.nan for s in seen])
    jumps = np.flatnonzero(np.diff([s.events for s in seen])) + 1
    label = f"half range after t = {t.settle:g}" if t.half_range else "time of rest"
    return Curve(np.insert(x, jumps, x[jumps]), np.insert(y, jumps, np.nan), t.level, t.name, label, (damping,))
