"""The speed above which nothing vibrates: a vibration is followed up, each speed from where the last one settled."""

from dataclasses import dataclass

from symfric.errors import NoRoute, NotFound, SceneError
from symfric.model.outputs import Max, Min
from symfric.model.scene import Scene
from symfric.orbits.steady_state import END, Settling, schedule
from symfric.scenefile import SweepPlan

_FACTOR, _MOST = 1.05, 60  # steps up, and how many of them
_HALVINGS = 12
_SLOW = 0.02  # beyond the onset, relative to it
_GONE = 1e-3  # half range, relative to that of the vibration at the start, that counts as none


@dataclass(frozen=True)
class SafeSpeed:
    """Where a vibration that is followed to higher speeds ends.

    Attributes
    ----------
    parameter : str
    value : float
        The lowest speed at which it was not found any more.
    onset : float
        Speed at which steady sliding becomes stable.
    ended : bool
        Whether it ended; if not, `value` is the highest speed that was tried.
    """

    parameter: str
    value: float
    onset: float
    ended: bool = True

    @property
    def overhangs(self) -> bool:
        """Whether vibrations go on beyond the onset of small ones; just beyond, they die too slowly to tell."""
        return self.value > (1 + _SLOW) * self.onset

    def to_dict(self) -> dict[str, object]:
        """Return plain data."""
        return {
            "parameter": self.parameter,
            "value": self.value,
            "onset": self.onset,
            "overhangs": self.overhangs,
            "ended": self.ended,
        }


def safe_speed(scene: Scene, plan: SweepPlan, onset: float) -> SafeSpeed:
    """Follow the vibration of a scene to higher speeds until it ends.

    Parameters
    ----------
    scene : Scene
        Vibrates at the value it has of the plan's parameter.
    plan : SweepPlan
    onset : float
        Where steady sliding becomes stable.

    Raises
    ------
    NotFound
        If it does not vibrate at the value it has.
    """
    (coordinate,) = (s for s in scene.system.states if s.name == plan.coordinate)
    settling = Settling(
        scene, schedule(scene, plan.settle, plan.window), {"low": Min(coordinate), "high": Max(coordinate)}
    )

    def after(value: float, start: dict | None) -> tuple[float, dict]:
        run = settling.measured({plan.parameter: value}, start)
        return 0.5 * float(run["high"] - run["low"]), settling.start(run[END])

    low = float(scene.numbers()[scene.parameter(plan.parameter)])
    size, state = after(low, None)
    if not low > 0 or size <= 1e-9 * abs(state[plan.coordinate]):
        raise NotFound(f"nothing vibrates at {plan.parameter} = {low:g}")
    high = low
    for _ in range(_MOST):
        high *= _FACTOR
        left, settled = after(high, state)
        if left <= _GONE * size:
            break
        low, state = high, settled
    else:
        return SafeSpeed(plan.parameter, low, onset, ended=False)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        left, settled = after(middle, state)
        if left <= _GONE * size:
            high = middle
        else:
            low, state = middle, settled
    return SafeSpeed(plan.parameter, max(high, _end_of_orbits(scene, plan, high)), onset)


def _end_of_orbits(scene: Scene, plan: SweepPlan, expected: float) -> float:
    """Return the largest speed with a stable orbit on the branch of one mass, from which motions fall away before."""
    from symfric.orbits.continuation.branch import continue_cycle

    if len(scene.system.q) > 1:
        return 0.0
    now = float(scene.numbers()[scene.parameter(plan.parameter)])
    try:
        branch = continue_cycle(scene, plan.parameter, (now, 1.5 * max(now, expected)))
    except (NotFound, SceneError, NoRoute, NotImplementedError):
        return 0.0
    return max((float(v) for v, o in zip(branch.values, branch.orbits, strict=True) if o.stable), default=0.0)
