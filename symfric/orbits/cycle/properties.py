"""Properties of a periodic orbit, from the solution of its equations: Floquet multipliers, time of sticking, events."""

from collections.abc import Collection

import numpy as np

from symfric.lower.mode_layout import OPEN
from symfric.model.scene import Scene
from symfric.orbits.cycle.orbit import Orbit
from symfric.orbits.passages import Passage
from symfric.orbits.shooting import Point, ShootingSystem
from symfric.solve.run import Event

_ZERO = 1e-11  # relative to the largest: a multiplier below it is zero, its direction lost by sticking
_NEUTRAL = 1e-10  # largest rounding error of a multiplier of 1
_CARRIED = 1e-3  # largest relative change of the rate of the motion under the map over a period
_AT_START = 1e-9  # fraction of the period within which a slip of the size of rounding ends


def orbit_of(scene: Scene, system: ShootingSystem, point: Point) -> Orbit:
    """Compute the properties of a periodic orbit from a solution of its equations."""
    flow, passage = system.flow, point.passage
    start, period, values = system.unpack(point.z)
    multipliers, trivial = multipliers_of(passage, system.free)
    others = np.delete(multipliers, trivial) if trivial is not None else multipliers
    stops = {k for k in flow.openings if k >= len(flow.lines)}
    second = {k for k in flow.planes if k and flow.contacts[k] == flow.contacts[k - 1]}  # of the slip in the plane
    stick = stick_time(passage, period, stops | second)
    return Orbit(
        period=period,
        start=start.copy(),
        half_range=0.5 * (passage.high - passage.low),
        x_max=passage.high,
        x_min=passage.low,
        stick_time=stick,
        stick_fraction=stick / period,
        multipliers=multipliers,
        trivial=trivial,
        stable=bool(np.all(np.abs(others) < 1 + _NEUTRAL)),
        events=tuple(
            Event(t, flow.contacts[i], a, b)
            for t, i, a, b in passage.changes
            # a stick that lasts beyond the end of the period does not begin with it; the slip there is rounding
            if not (b == passage.modes[i] == 0 and t <= _AT_START * period)
        ),
        names=flow.states,
        differentiable=not passage.doubtful,
        base=scene,
        values={n: values[n] for n in flow.parameters},
    )


def multipliers_of(passage: Passage, free: bool) -> tuple[np.ndarray, int | None]:
    """Return the ordered eigenvalues of the monodromy matrix, and the index of the trivial one."""
    eigenvalues = np.linalg.eigvals(passage.by_start)
    eigenvalues = np.where(np.abs(eigenvalues) <= _ZERO * max(1.0, np.max(np.abs(eigenvalues))), 0.0, eigenvalues)
    eigenvalues = eigenvalues[np.argsort(-np.abs(eigenvalues), kind="stable")]
    if free:
        # zero on an exact orbit: the flow maps the rate onto itself
        shift = passage.by_start @ passage.rate - passage.rate
        k = int(np.argmin(np.abs(eigenvalues - 1.0)))
        shift, rate = shift / passage.ranges, passage.rate / passage.ranges
        if np.linalg.norm(shift) <= _CARRIED * np.linalg.norm(rate):
            eigenvalues = np.concatenate([eigenvalues[k : k + 1], np.delete(eigenvalues, k)])
    eigenvalues = eigenvalues.real if np.all(np.abs(eigenvalues.imag) == 0) else eigenvalues
    return eigenvalues, 0 if free else None


def stick_time(passage: Passage, period: float, others: Collection[int] = ()) -> float:
    """Return the time during which at least one contact sticks; some `others`, as stops that are closed, do not."""
    modes = [OPEN if k in others else mode for k, mode in enumerate(passage.modes)]
    changes = [e for e in passage.changes if e[1] not in others]
    for _, i, before, _ in reversed(changes):
        modes[i] = before
    total, last = 0.0, 0.0
    for t, i, _, after in changes:
        total += (t - last) * (0 in modes)
        modes[i], last = after, t
    return total + (period - last) * (0 in modes)
