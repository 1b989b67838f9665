"""How much damping the limit cycles of a system ask for, as a curve over the speeds."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from symfric.errors import NotFound
from symfric.model.outputs import End
from symfric.model.scene import Scene
from symfric.orbits.branch import Branch, Special, continue_cycle
from symfric.orbits.curve import Curve, continue_special
from symfric.orbits.cycle import Orbit, limit_cycle
from symfric.orbits.special import Condition
from symfric.solve.choose import prepare
from symfric.theory.equilibrium import Equilibrium, equilibrium
from symfric.theory.stability import stability

_FAR = 20.0  # displacements of steady sliding: starts so far out settle to the outermost cycle
_SMALL = 1e-7  # of the same: disturbances whose growth is that of the linear motion, also beside narrow features
_TOLERANCE = 1e-13  # of the runs whose differences show growth


@dataclass(frozen=True)
class Requirement:
    """What a damper must do.

    Attributes
    ----------
    name, speed : str
        Parameters: the damping and the speed.
    bounds, speeds : (float, float)
    half_range : float
        Largest half range of the first coordinate; 0 for none at all.
    sticking : bool
        Whether contacts may stick.
    """

    name: str
    speed: str
    bounds: tuple[float, float]
    speeds: tuple[float, float]
    half_range: float
    sticking: bool

    @property
    def quiet(self) -> bool:
        """Whether no vibration is allowed."""
        return self.half_range == 0 and self.sticking

    def meets(self, orbit: Orbit | None) -> bool:
        """Whether the system may move like that; None is steady sliding."""
        if orbit is None:
            return True
        small = orbit.half_range[0] <= self.half_range or (self.half_range == 0 and not self.sticking)
        return small and (self.sticking or orbit.stick_fraction == 0)


@dataclass(frozen=True)
class Summit:
    """The most damping that a condition asks for, the speed where it does, its name, and what it is over the speeds."""

    damping: float
    speed: float
    reason: str
    line: np.ndarray


def outermost(scene: Scene, r: Requirement) -> Orbit | None:
    """Return the limit cycle to which motions from far out settle; None if they settle to steady sliding.

    Every coordinate is displaced in turn; of several cycles one that does not meet the requirement comes first, the
    largest of them.
    """
    rest = equilibrium(scene)
    states, q = scene.system.states, scene.system.q
    start = dict(zip(states, rest.x.tolist(), strict=True))
    found = []
    for coordinate, far in zip(q, _FAR * _sizes(scene, rest)[: len(q)], strict=True):
        try:
            found.append(limit_cycle(scene.starting({**start, coordinate: start[coordinate] + float(far)})))
        except NotFound as failure:
            if "settles" not in str(failure):
                raise
    return max(found, key=lambda o: (not r.meets(o), o.half_range[0]), default=None)


def grows(scene: Scene) -> float:
    """Return the rate, 1/time, at which small disturbances of steady sliding grow in runs of the full model.

    From differences of runs over one period of the fastest mode; negative where all of them shrink.
    """
    rest = equilibrium(scene)
    duration = 2 * np.pi / _fastest(scene)
    program = prepare(scene.until(duration).wanting({"end": End()}), _TOLERANCE)
    names, columns = [s.name for s in scene.system.states], []
    for k, size in enumerate(_SMALL * _sizes(scene, rest)):
        ends = []
        for side in (1, -1):
            x = rest.x.copy()
            x[k] += side * size
            ends.append(program.run(initial=dict(zip(names, x.tolist(), strict=True))).checked().final)
        columns.append((ends[0] - ends[1]) / (2 * size))
    largest = np.max(np.abs(np.linalg.eigvals(np.column_stack(columns))))
    return float(np.log(max(largest, 1e-300)) / duration)


def _fastest(scene: Scene) -> float:
    """Return the largest absolute eigenvalue of steady sliding, 1/time."""
    return float(np.max(np.abs(stability(scene).eigenvalues)))


def _sizes(scene: Scene, rest: Equilibrium) -> np.ndarray:
    """Return what counts as a large displacement, velocity and further state: what sliding itself has of them."""
    speed = max(abs(v) for v in rest.sliding.values())
    n, numbers = len(scene.system.q), scene.numbers()
    length = max(speed / _fastest(scene), float(np.max(np.abs(rest.x[:n]))))
    length = max(length, *(abs(numbers[s]) for s in scene.system.q))
    others = np.abs(rest.x[2 * n :])
    return np.concatenate([np.full(n, length), np.full(n, speed), np.where(others > 0, others, 1.0)])


def summit(scene: Scene, requirement: Requirement, at: float) -> Summit:
    """Return what the outermost cycles ask for, from the curve that passes through one speed.

    Raises
    ------
    NotFound
        If the upper bound of the damping is not enough at that speed.
    """
    r = requirement
    there = scene.where({r.speed: at})
    orbit = outermost(there, r)
    branch = continue_cycle(there, r.name, r.bounds, start=orbit)
    special = _need(branch, r)
    if special is None:
        last = branch.orbits[-1]
        raise NotFound(
            f"{r.name} = {branch.values[-1]:.6g} is not enough: at {r.speed} = {at:.6g} the system still vibrates with "
            f"half range {last.half_range[0]:.6g} and sticks {100 * last.stick_fraction:.3g} % of the time"
        )
    if special.kind == "hopf":  # of this speed; the local condition has the others
        return Summit(special.value, at, "stability of sliding", np.array([[at], [special.value]]))
    reason = f"half range {r.half_range:g}" if special.kind == "half-range" else f"{special.kind} of the cycle"
    curve = continue_special(special, (r.speed, r.name), (r.speeds, r.bounds))
    damping, speed = _highest(curve)
    return Summit(damping, speed, reason, curve.values)


def _need(branch: Branch, r: Requirement) -> Special | None:
    """Return where, with growing damping, the outermost cycle first does what is required; None if it never does."""
    turn = int(np.argmax(branch.values))
    outer = branch.orbits[: turn + 1]
    fine = next((k for k, orbit in enumerate(outer) if r.meets(orbit)), None)
    if fine is not None and fine > 0:
        before, after = outer[fine - 1], outer[fine]
        if r.half_range > 0 and before.half_range[0] > r.half_range >= after.half_range[0]:
            return Special("half-range", float(branch.values[fine]), after, Condition("half-range", level=r.half_range))
        low, high = branch.values[fine - 1 : fine + 1]
        return next(s for s in branch.special if s.kind == "stick-onset" and low <= s.value <= high)
    ends = [s for s in branch.special if s.value >= branch.values[turn] - 1e-12 and s.kind not in ("flip", "torus")]
    return next((s for s in ends if s.kind != "fold"), ends[0] if ends else None)


def _highest(curve: Curve) -> tuple[float, float]:
    """Return the largest second parameter on a curve, and the first one there."""
    k = int(np.argmax(curve.values[1]))
    best = float(curve.values[1, k]), float(curve.values[0, k])
    if not 0 < k < curve.values.shape[1] - 1:
        return best
    ends = sorted((curve.values[0, k - 1], curve.values[0, k + 1]))

    def lower(value: float) -> float:
        found = curve.at(value)
        return -float(np.max(found)) if found.size else -best[0]

    found = minimize_scalar(lower, bounds=ends, method="bounded", options={"xatol": 1e-9 * abs(ends[1])})
    return (-float(found.fun), float(found.x)) if -found.fun > best[0] else best
