"""The damping that the limit cycles of a system require, as a curve over the speeds."""

from dataclasses import dataclass, replace

import numpy as np

from symfric.design.damper.cycles import Left, Requirement, outermost
from symfric.errors import NotFound
from symfric.model.scene import Scene
from symfric.orbits.continuation.bifurcations import Condition
from symfric.orbits.continuation.branch import Branch, Special, continue_cycle
from symfric.orbits.continuation.codim1 import Curve, continue_special
from symfric.orbits.cycle import Orbit
from symfric.search import minimum

_NEIGHBOUR = 0.25  # distance, relative to the range of speeds, within which runs search for the worst speed
_TRIES = 10  # most speeds of that search
SLOWEST = 1e-4  # slowest speed of runs, relative to the highest
_SURVEY = 13  # number of dampings before a bisection on runs
_CLOSE = 1e-6  # relative width at which the bisection ends
_ALIKE = 1e-4  # relative distance of half range and damping from a limit within which the limit is continued


@dataclass(frozen=True)
class Summit:
    """The largest damping that a condition requires over the speeds.

    Attributes
    ----------
    damping, speed : float
    reason : str
        Name of the condition.
    line : ndarray, shape (2, n)
        Speeds, and the damping required there.
    orbit : Orbit or None
        The cycle at the limit of the requirement or of its existence, there or nearby.
    """

    damping: float
    speed: float
    reason: str
    line: np.ndarray
    orbit: Orbit | None = None


def summit(scene: Scene, requirement: Requirement, at: float) -> Summit:
    """Return the damping that the outermost cycles require, starting at a speed where one violates the requirement.

    The branch of the cycle is continued in the damping to where the requirement is met, and the limiting condition
    there over the speeds. If such a branch cannot be continued, runs bracket the damping, speed by speed.

    Parameters
    ----------
    scene : Scene
        With an insufficient damping at the speed.

    Raises
    ------
    NotFound
        If the upper bound of the damping is not enough at that speed.
    """
    r = requirement
    there = scene.where({r.speed: at})
    last = outermost(there.where({r.name: r.bounds[1]}), r)
    if last is not None and not r.meets(last):
        raise NotFound(f"{r.name} = {r.bounds[1]:g} is not enough: at {r.speed} = {at:.6g} {_left(r, last)}")
    try:
        followed = _followed(there, r, at)
    except NotFound:
        followed = None
    known = scene.numbers()[scene.parameter(r.name)]
    return followed if followed is not None and followed.damping > known else _bracketed(scene, r, at)


def _left(r: Requirement, orbit: Orbit | Left) -> str:
    """Return a message: the vibration of a cycle that exceeds the requirement."""
    size, stick = orbit.half_range[0], 100 * orbit.stick_fraction
    words = [f"the system still vibrates with half range {size:.6g} and sticks {stick:.3g} % of the time"]
    if r.half_range > 0 and size > r.half_range:
        words.append(f"its half range exceeds {r.half_range:g} by {size - r.half_range:.6g}")
    if not r.sticking and stick > 0:
        words.append("no sticking is allowed")
    return "; ".join(words)


def _followed(there: Scene, r: Requirement, at: float) -> Summit | None:
    """Return the limiting condition of the cycles from their branch; None if the branch does not show it."""
    start = outermost(there, r)
    if not isinstance(start, Orbit):
        return None
    branch = continue_cycle(there, r.name, r.bounds, start=start)
    special = _need(branch, r)
    if special is None:
        return None
    begin = there.numbers()[there.parameter(r.name)]
    if not begin <= special.value <= r.bounds[1]:
        return None
    if special.kind == "hopf":  # other speeds are covered by the stability of sliding
        return Summit(special.value, at, "stability of sliding", np.array([[at], [special.value]]))
    return _over_speeds(special, r, at)


def _over_speeds(special: Special, r: Requirement, at: float) -> Summit:
    """Return the largest damping that the condition of a special point requires within the speeds.

    The end of a cycle is limiting only if the cycle violates the requirement up to it; if it becomes small enough
    before, the limit on the half range applies.
    """
    curve = continue_special(special, (r.speed, r.name), (r.speeds, r.bounds))
    if special.kind == "half-range" or (special.kind == "stick-onset" and not r.sticking):
        return _top(curve, r, special.kind, np.full(curve.values.shape[1], True))
    sizes = np.array([curve.orbit(k).half_range[0] for k in range(curve.values.shape[1])])
    counts = (sizes > r.half_range * (1 - _ALIKE)) | (r.half_range == 0)
    highest = _top(curve, r, special.kind, counts)
    if special.value > highest.damping:
        highest = replace(highest, damping=special.value, speed=at, orbit=special.orbit)
    for k in np.flatnonzero(counts[1:] != counts[:-1]).tolist():
        further = _on_limit(curve.orbit(k if counts[k] else k + 1), r)
        if further is not None and further.damping > highest.damping:
            highest = further
    return highest


def _top(curve: Curve, r: Requirement, kind: str, counts: np.ndarray) -> Summit:
    damping, speed = _highest(curve, r.speeds, counts)
    near = int(np.argmin(np.where(counts, np.abs(curve.values[0] - speed), np.inf)))
    reason = f"half range {r.half_range:g}" if kind == "half-range" else f"{kind} of the cycle"
    return Summit(damping, speed, reason, curve.values[:, counts], curve.orbit(near))


def _bracketed(scene: Scene, r: Requirement, at: float) -> Summit:
    """Return the required damping from runs, at the worst speed near a given one."""
    least = scene.numbers()[scene.parameter(r.name)]
    seen: dict[float, float] = {}

    def need(speed: float) -> float:
        if speed not in seen:
            seen[speed] = _enough(scene.where({r.speed: float(speed)}), r, least)
        return seen[speed]

    low, high = max(r.speeds[0], SLOWEST * r.speeds[1]), r.speeds[1]
    ends = max(low, at - _NEIGHBOUR * (high - low)), min(high, at + _NEIGHBOUR * (high - low))
    for end in (at, *ends):
        need(end)
    if ends[0] < ends[1]:
        minimum(lambda v: -need(float(v)), *ends, xatol=1e-3 * high, most=_TRIES)
    speed = max(seen, key=seen.__getitem__)
    orbit = outermost(scene.where({r.speed: speed, r.name: seen[speed]}), r)
    if isinstance(orbit, Orbit) and abs(orbit.half_range[0] - r.half_range) < _ALIKE * r.half_range:
        sharper = _on_limit(orbit, r)
        if sharper is not None and sharper.damping >= seen[speed] * (1 - _ALIKE):
            return sharper
    speeds = np.array(sorted(seen))
    return Summit(seen[speed], speed, _reason(r), np.array([speeds, [seen[v] for v in speeds]]))


def _on_limit(orbit: Orbit, r: Requirement) -> Summit | None:
    """Continue the limit on the half range over the speeds, from a cycle close to it; None if none is found."""
    numbers = {s.name: value for s, value in orbit.scene.parameter_values().items()}
    special = Special("half-range", numbers[r.name], orbit, Condition("half-range", level=r.half_range))
    try:
        return _over_speeds(special, r, numbers[r.speed])
    except NotFound:
        return None


def _reason(r: Requirement) -> str:
    words = [f"half range {r.half_range:g}"] if r.half_range > 0 else []
    words += [] if r.sticking else ["end of sticking"]
    return " and ".join(words) or "end of the cycle"


def _enough(scene: Scene, r: Requirement, least: float) -> float:
    """Return the least sufficient damping at one speed, by bisection on runs."""

    def met(d: float) -> bool:
        return r.meets(outermost(scene.where({r.name: float(d)}), r))

    low, high = least, None
    if met(low):
        return low
    for share in np.linspace(0, 1, _SURVEY)[1:] ** 2:
        d = least + share * (r.bounds[1] - least)
        if met(d):
            high = d
            break
        low = d
    if high is None:
        raise NotFound(
            f"{r.name} = {r.bounds[1]:g} is not enough at {r.speed} = {scene.numbers()[scene.parameter(r.speed)]:.6g}"
        )
    while high - low > _CLOSE * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if met(middle) else (middle, high)
    return high


def _need(branch: Branch, r: Requirement) -> Special | None:
    """Return the least damping on a branch from which its cycles meet the requirement; None if they never do."""
    turn = int(np.argmax(branch.values))
    outer = branch.orbits[: turn + 1]
    fine = next((k for k, orbit in enumerate(outer) if r.meets(orbit)), None)
    if fine is not None and fine > 0:
        before, after = outer[fine - 1], outer[fine]
        if r.half_range > 0 and before.half_range[0] > r.half_range >= after.half_range[0]:
            return Special("half-range", float(branch.values[fine]), after, Condition("half-range", level=r.half_range))
        low, high = sorted(branch.values[fine - 1 : fine + 1])
        low, high = (
            low * (1 - _CLOSE),
            np.inf if fine == turn else high * (1 + _CLOSE),
        )  # a corner lies beyond the points of the branch
        near = [s for s in branch.special if s.kind == "stick-onset" and low <= s.value <= high]
        return min(near, key=lambda s: s.value, default=None)
    last = branch.values[turn] * (1 - _CLOSE)  # points of the branch near a corner are less accurate
    ends = [s for s in branch.special if s.value >= last and s.kind not in ("flip", "neimark-sacker")]
    return next((s for s in ends if s.kind != "fold"), ends[0] if ends else None)


def _highest(curve: Curve, speeds: tuple[float, float], counts: np.ndarray) -> tuple[float, float]:
    """Return the largest second parameter on a curve within a range of the first, with the first parameter there.

    Only the points of the mask are used, shape (n,).
    """
    within = (curve.values[0] >= speeds[0] * (1 - 1e-12)) & (curve.values[0] <= speeds[1] * (1 + 1e-12)) & counts
    k = int(np.argmax(np.where(within, curve.values[1], -np.inf)))
    best = float(curve.values[1, k]), float(curve.values[0, k])
    if not (0 < k < curve.values.shape[1] - 1 and np.all(within[k - 1 : k + 2])):
        return best
    ends = np.clip(sorted((curve.values[0, k - 1], curve.values[0, k + 1])), *speeds)

    def lower(value: float) -> float:
        dampings = curve.at(value)
        return -float(np.max(dampings)) if dampings.size else -best[0]

    lowest = minimum(lower, *ends, xatol=1e-9 * abs(ends[1]))
    return (-lowest.value, lowest.place) if -lowest.value > best[0] else best
