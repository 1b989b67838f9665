"""The smallest damper that prevents or limits vibration over a range of speeds, or ends a motion in time."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric.design.damper.best_load import Peaks, best_load
from symfric.design.damper.cycles import Disturbed, Requirement, distances, outermost
from symfric.design.damper.growth import Growth, steepest_falls
from symfric.design.damper.settling import Transient, settled
from symfric.design.damper.summit import SLOWEST, Summit, summit
from symfric.design.result import Curve, Design
from symfric.design.verification import Neighbour, design
from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged, tell
from symfric.model.arguments import flag
from symfric.model.excitation import excitation_of, is_excited
from symfric.model.results import Result
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import Key, finite, name_of, nearest, pair, positive
from symfric.orbits.cycle import Orbit
from symfric.search import zero

_SCAN = 7  # points of the damper's bounds, before polishing
_REFERENCES = 5  # speeds at which cycles that coexist with stable sliding are sought
_ROUNDS = 12  # most speeds from which the conditions on the cycles are continued
_SLOW, _LOWEST = 1e-3, 0.02  # slowest reference speed, and the lowest of the spread ones, relative to the highest
_BEYOND = 1e-6  # relative excess over the present optimum at which cycles are sought
_STEP = 0.01  # relative distance from the optimum at which the full model is run


@dataclass(frozen=True)
class DamperProbe:
    """Vibration of the full model at one speed and damping.

    Attributes
    ----------
    speed, damping : float
    half_range, stick_fraction : float
        Of the outermost motion; zero for steady sliding.
    meets : bool
        Whether the requirement is met.
    growth : float
        Rate at which a small disturbance of steady sliding grows in runs; NaN where vibration is allowed.
    """

    speed: float
    damping: float
    half_range: float
    stick_fraction: float
    meets: bool
    growth: float


@dataclass(frozen=True)
class DamperCheck(Result):
    """Verification: the full model with 1 % more and less damping than the optimum, at the critical speed.

    Attributes
    ----------
    above, below : DamperProbe
        Below is None where the lower bound is already sufficient.
    others : tuple of DamperProbe
        With 1 % more damping at other speeds of the range.
    starts : int
        Number of starts at each speed from which a cycle was sought.
    """

    _told = ("agrees", "above", "below", "others", "starts")

    above: DamperProbe
    below: DamperProbe | None
    others: tuple[DamperProbe, ...] = ()
    starts: int = 0

    @property
    def agrees(self) -> bool:
        """Whether the requirement is met above the optimum, at all speeds that were run, and violated below."""
        return not self.disagreements

    @property
    def disagreements(self) -> tuple[str, ...]:
        """The motions that contradict the optimum, as lines of text."""
        wrong = [_words(p, "a little more") for p in (self.above, *self.others) if not p.meets]
        if self.below is not None and self.below.meets:
            wrong.append(_words(self.below, "a little less") + ", which meets the requirement too")
        return tuple(wrong)

    def __str__(self) -> str:
        words = [_words(p, "a little more") for p in (self.above, *self.others)]
        words += [_words(self.below, "a little less")] if self.below else []
        return "; ".join([*words, f"based on {self.starts} motions at each speed; other starts may behave differently"])


def _words(p: DamperProbe, share: str) -> str:
    state = f"half range {p.half_range:.6g}, sticking {100 * p.stick_fraction:.3g} % of the time"
    state = state if p.half_range else f"small vibration grows at rate {p.growth:.4g}" if p.growth > 0 else "quiet"
    return f"with {share} damping at speed {p.speed:.6g}: {state}"


@logged
def damper(
    scene: Scene,
    parameter: Key,
    bounds: tuple[float, float],
    speeds: tuple[float, float] | None = None,
    half_range: float = 0.0,
    *,
    sticking: bool = True,
    speed: Key = "v_b",
    settle: float | None = None,
    coordinate: Key | None = None,
) -> Design:
    """Find the smallest damping with which a system does not vibrate at any speed of a range, or settles in time.

    Of a forced scene, find the value of a parameter, such as the normal load of a friction damper, with the smallest
    peak of the response over a range of the excitation's frequency.

    Parameters
    ----------
    scene : Scene
        Autonomous, with steady sliding at the speeds of the range. Its own values of the two parameters are not used.
        With `settle`: the motion from its initial state is what must settle.
    parameter : Symbol or str
        The parameter to minimise: a damping, or another one that reduces vibration as it grows.
    bounds : (float, float)
        Of the parameter.
    speeds : (float, float)
        Lowest and highest speed. May be left out with `settle`, for the scene as it is.
    half_range : float
        Of the first coordinate, the largest that is allowed; 0.0: no vibration at all, not even beside a stable
        sliding that a large disturbance leaves for good.
    sticking : bool
        Whether contacts may stick; if not, cycles without sticking are allowed, of a half range as large as they like
        unless `half_range` limits it.
    speed : Symbol or str
        Name of the speed.
    settle : float, optional
        Time by which the motion must be over. With ``half_range=0`` it is at rest by then, in the sense of
        `symfric.StopTime`; else the first coordinate moves over no more than `half_range` from then until the scene's
        horizon, at every speed of the range. Limit cycles play no part.

    coordinate : Symbol or str, optional
        State whose half range counts, of a forced scene; the first coordinate unless given.

    Returns
    -------
    Design
        Its active condition names the speed that decides. With `settle` and rest it mostly lies on a jump of the time
        of rest, which the condition names with both times: a little less damping takes half a cycle longer.

    Raises
    ------
    NotFound
        If the upper bound is not enough; says at which speed and what is left there.
    SceneError
        If an argument is wrong.

    Notes
    -----
    Three conditions bound the damping from below: the stability of sliding (eigenvalues), the end of the large cycles
    (a fold, a corner or a graze of their branch) or the limit on their size, and the onset of sticking. The last two
    are followed as curves in the plane of speed and damping, so the worst speed is a maximum of a curve, not of
    samples. For one mass on a belt whose law falls steepest at rest it is ``2 beta = eta`` as the speed goes to zero,
    Thomsen (19).

    That no cycle is left is shown by runs that start far out, as far as steady sliding displaces the system, and near,
    in every coordinate in turn, at a few speeds over the range, at a thousandth of the highest if the range begins
    below, and where the laws fall steepest; a cycle that only other starts lead to is not seen. Below a ten-thousandth
    of the highest speed cycles are not looked at, small vibration is.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> sf.design.damper(belt, "beta", bounds=(0, 1), speeds=(0.1, 0.45)).values
    {'beta': 0.21600000000000003}

    The normal load of a joint that keeps a resonance smallest is found likewise; ``examples/blade_friction_damper.py``
    does so.
    """
    flag(sticking, "sticking")
    check_scene(scene)
    name = scene.parameter(parameter).name
    low, high = _pair(bounds, "bounds", f"bounds of {name}")
    if settle is None and is_excited(scene):
        return best_load(_peaks(scene, name, speed, speeds, half_range, coordinate), (low, high))
    if coordinate is not None:
        raise SceneError("coordinate is for forced scenes; no force of this one depends on time")
    half_range = positive(half_range, "half_range", zero=True)
    if speeds is not None and name_of(speed) not in {s.name for s in scene.parameters}:
        known = nearest(name_of(speed), [s.name for s in scene.parameters])
        raise SceneError(f"speeds is the range of {name_of(speed)}, which the scene has not; give speed='...'{known}")
    speed = name_of(speed) if speeds is None else scene.parameter(speed).name
    if name == speed:
        raise SceneError(f"the damping and the speed are both {name}; give speed='...' another name")
    ends = None if speeds is None else _pair(speeds, "speeds", f"speeds {speed}")
    if settle is not None:
        settle = finite(settle, "settle")
        if not settle > 0:
            raise SceneError(f"settle is {settle:g}; it is a time, so positive")
        if not sticking:
            raise SceneError("sticking=False is a condition on limit cycles; leave it out with settle")
        return settled(Transient(scene, name, (low, high), settle, half_range, speed, ends))
    if ends is None:
        raise SceneError("give the speeds (lowest, highest), or settle, the time by which the motion must be over")
    requirement = Requirement(name, speed, (low, high), ends, half_range, sticking)
    scene = scene.where({name: low, speed: max(ends[0], 1e-9 * ends[1])})
    return _design(scene, requirement, _cycles(scene, requirement, _local(scene, requirement)))


def _peaks(scene: Scene, name: str, speed: Key, speeds: Any, half_range: float, coordinate: Key | None) -> Peaks:
    """Check the arguments of the design of a forced scene."""
    parameters = excitation_of(scene).parameters
    frequency = name_of(speed)
    if frequency not in parameters:
        told = " or ".join(sorted(parameters)) or "a parameter in the sine of the force"
        raise SceneError(f"the scene is forced, and {frequency} is not its frequency; give speed={told!r}")
    if name in parameters:
        raise SceneError(f"{name} is the frequency of the excitation; give the parameter of the damper")
    if speeds is None or half_range != 0:
        raise SceneError("of a forced scene, give the speeds, the range of the frequency, and no half_range")
    names = [s.name for s in scene.system.states]
    state = names[0] if coordinate is None else name_of(coordinate)
    if state not in names:
        raise SceneError(f"{state} is no state{nearest(state, names)}")
    return Peaks(scene, name, frequency, _pair(speeds, "speeds", f"speeds {frequency}"), state)


def _pair(given: tuple[float, float], name: str, what: str) -> tuple[float, float]:
    low, high = (finite(e, f"an end of the {what}") for e in pair(given, name))
    if not 0 <= low <= high or high == 0:
        raise SceneError(f"the {what} are ({low:g}, {high:g}); give 0 <= low <= high, and high > 0")
    return low, high


def _largest(summits: list[Summit | None]) -> Summit | None:
    return max((s for s in summits if s is not None), key=lambda s: s.damping, default=None)


def _local(scene: Scene, r: Requirement) -> Summit | None:
    """Return the least damping with which steady sliding is stable at every speed; None without this condition.

    Raises
    ------
    NotFound
        If the upper bound is not enough.
    """
    if not r.quiet:
        return None
    tell("stability of steady sliding")
    growth = Growth(scene, r)
    values = np.linspace(*r.bounds, _SCAN)
    worst = [growth.worst(value, polished=False) for value in values]
    stable = np.array([rate <= 0 for rate, _ in worst])
    if stable.all():
        return None
    last = int(np.flatnonzero(~stable)[-1])
    if last == _SCAN - 1:
        rate, speed = worst[-1]
        raise NotFound(
            f"{r.name} = {r.bounds[1]:g} is not enough: at {r.speed} = {speed:.6g} small vibration still grows with "
            f"rate {rate:.6g}"
        )
    # a margin, since slightly more may be needed between the speeds of the grid
    ends = values[last], values[min(last + 2, _SCAN - 1)]
    edge = zero(lambda value: growth.worst(value)[0], *ends)
    speed = growth.worst(edge)[1]
    line = np.array([growth.speeds, [growth.least(float(v)) for v in growth.speeds]])
    return Summit(edge, speed, "stability of sliding", line)


def _cycles(scene: Scene, r: Requirement, local: Summit | None) -> Summit | None:
    """Return the damping that the limit cycles require beyond the stability of sliding."""
    speeds, best = _references(scene, r), local
    for _ in range(_ROUNDS):
        damping = r.bounds[0] if best is None else best.damping * (1 + _BEYOND)
        tell(f"cycles with {r.name} = {damping:.5g}")
        bad = next((v for v in speeds if not r.meets(outermost(scene.where({r.speed: v, r.name: damping}), r))), None)
        if bad is None:
            return best
        required = summit(scene.where({r.name: damping}), r, float(bad))
        best = _largest([best, required])
    raise NotFound("the conditions on the cycles change too often over the speeds; give a smaller range of them")


def _design(scene: Scene, r: Requirement, required: Summit | None) -> Design:
    tell("verification of the design")
    low, claim = r.bounds[0], "optimal"
    if required is None:
        speeds = np.array([max(r.speeds[0], _LOWEST * r.speeds[1]), r.speeds[1]])
        required = Summit(low, float(speeds[0]), "", np.array([speeds, [low, low]]))
        active = (f"{r.name} at its lower bound",)
    else:
        active = (f"{required.reason} at {r.speed} = {required.speed:.6g}",)
    at = max(required.speed, SLOWEST * r.speeds[1])
    more = required.damping * (1 + _STEP) if required.damping else low + _STEP * r.bounds[1]
    disturbed = Disturbed(scene.where({r.speed: at, r.name: more}), r) if r.quiet else None
    above = _probe(scene, r, disturbed, at, more)
    below = None
    if required.damping > low:  # the cycle that just meets the requirement is close to one that violates it
        below = _probe(scene, r, disturbed, at, max(required.damping * (1 - _STEP), low), required.orbit)
    others = (_probe(scene, r, disturbed, float(v), more) for v in _references(scene, r) if v != at)
    check = DamperCheck(above, below, tuple(others), len(scene.system.q) * len(distances(r)))
    beside = [Neighbour(f"{r.name} larger by {100 * _STEP:g} %", more, 0.0 if above.meets else 1.0)]
    if below is not None:
        violation = 0.0 if below.meets else 1.0
        beside.append(Neighbour(f"{r.name} smaller by {100 * _STEP:g} %", below.damping, violation))
    values = {r.name: required.damping}
    x, y = required.line
    curve = Curve(x, y, required.damping, f"speed {r.speed}", f"required {r.name}", (required.speed,))
    placed = scene.where({**values, r.speed: max(required.speed, 1e-9 * r.speeds[1])})
    return design(values, required.damping, active, placed, check, curve, claim=claim, neighbours=beside)


def _probe(
    scene: Scene, r: Requirement, disturbed: Disturbed | None, speed: float, damping: float, beside: Orbit | None = None
) -> DamperProbe:
    orbit = outermost(scene.where({r.speed: speed, r.name: damping}), r, beside)
    size, stick = (float(orbit.half_range[0]), orbit.stick_fraction) if orbit else (0.0, 0.0)
    growth = disturbed.rate(speed, damping) if disturbed else np.nan
    return DamperProbe(speed, damping, size, stick, r.meets(orbit) and not growth > 0, growth)


def _references(scene: Scene, r: Requirement) -> np.ndarray:
    """Return the speeds at which cycles are sought: slow, over the range, and where the laws fall steepest."""
    spread = np.linspace(max(r.speeds[0], _LOWEST * r.speeds[1]), r.speeds[1], _REFERENCES)
    return np.unique([max(r.speeds[0], _SLOW * r.speeds[1]), *spread, *steepest_falls(scene, r)])
