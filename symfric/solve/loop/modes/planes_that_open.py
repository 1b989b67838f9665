"""Mode selection of contacts in the plane beside contacts that open: whether they stick, and where they start to.

A contact whose slip is zero starts in a direction e in which its slip accelerates, ``w' = c e`` with c >= 0, against
its friction ``-mu N e``; N is given, or follows from e. See `symfric.solve.loop.events.directions` for all such
directions of one contact. Several that start at once are turned one after the other, until they agree: one choice at
most, which is the only one as long as the contacts affect each other weakly.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import FOLLOWS, HOLDS
from symfric.lower.planes import SINCE, STARTS
from symfric.solve.loop.codes import COUPLING
from symfric.solve.loop.events.direction_sizes import SAMPLES
from symfric.solve.loop.events.directions import (
    AGREE,
    MOST_SWEEPS,
    POLISHES,
    START_ANGLE,
    chord_step,
    find_angles,
    sample_angle,
)
from symfric.solve.loop.events.impacts import LEAST, told
from symfric.solve.loop.modes.layout import backward, direction
from symfric.solve.loop.modes.tolerances import doubt_of, doubted_acceleration, stays
from symfric.solve.loop.precision import ROUNDING
from symfric.solve.loop.stepping.calls import prelude, probe
from symfric.solve.loop.workspace import LoopArrays

_ASIDE = 1e-9  # acceleration across a direction, relative to that along it, which is no turn


@compiled
def begin_planes(w: LoopArrays) -> None:
    """Let every contact in the plane stand for itself."""
    for i in range(w.planes.stands.size):
        w.planes.stands[i] = i


@compiled
def has_arrived(w: LoopArrays) -> bool:
    """Whether a contact in the plane has just come to rest."""
    found = False
    for k in range(w.planes.arrived.size):
        found = found or w.planes.arrived[k] != 0
    return found


@compiled
def forget_arrivals(w: LoopArrays) -> None:
    """Forget which contacts in the plane have come to rest."""
    for k in range(w.planes.arrived.size):
        w.planes.arrived[k] = 0


@compiled
def set_plane(w: LoopArrays, i: int, apart: bool, sticks: bool) -> None:
    """Set the trial mode of a contact in the plane whose slip is zero; its direction is found later."""
    j, v = i + 1, w.planes.variable[i]
    w.m[i] = 0.0 if apart else (FOLLOWS if sticks else STARTS)
    w.m[j] = w.m[i]
    w.m[direction(i, w.contacts.sticks.size)], w.m[direction(j, w.contacts.sticks.size)] = 1.0, 1.0
    for k in range(SINCE):  # no force is told, and no direction
        w.m[v + k] = 0.0
    if w.m[i] == STARTS:
        w.m[v + SINCE] = w.y[w.y.size - 1]
        _point(w, i, START_ANGLE)


@compiled
def is_undetermined(w: LoopArrays) -> bool:
    """Whether a contact in the plane sticks whose slip follows from those of others, so that its force is unknown."""
    found = False
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        found = found or (w.m[i] > 0.5 and w.m[i] != HOLDS) or (w.m[i + 1] > 0.5 and w.m[i + 1] != HOLDS)
    return found


@compiled
def aim_starts(w: LoopArrays, n_x: int) -> int:
    """Find the directions in which contacts in the plane start in the trial mode; return the number of choices."""
    starting, last = 0, -1
    for k in range(w.planes.row.size):
        if w.m[w.planes.row[k]] == STARTS:
            starting, last = starting + 1, w.planes.row[k]
    w.planes.aimed[0] = last if starting == 1 else -1
    if starting == 0:
        return 1
    if starting == 1:
        return _ways(w, n_x, last)
    for _ in range(MOST_SWEEPS):
        turned = 0.0
        for k in range(w.planes.row.size):
            if w.m[w.planes.row[k]] == STARTS:
                turned = max(turned, _turn_to_best(w, n_x, w.planes.row[k]))
        if not turned > AGREE:
            return 1 if turned >= 0.0 else 0
    return 0


@compiled
def take_start(w: LoopArrays, way: int) -> None:
    """Take one of the directions that were found."""
    if w.planes.aimed[0] >= 0:
        _point(w, w.planes.aimed[0], w.planes.angles[way])


@compiled(inline=True)
def _point(w: LoopArrays, i: int, angle: float) -> None:
    """Set the direction in which contact i starts."""
    w.m[w.planes.variable[i]], w.m[w.planes.variable[i] + 1] = np.cos(angle), np.sin(angle)


@compiled
def _ways(w: LoopArrays, n_x: int, i: int) -> int:
    """Find the directions of contact i, with those of the others as they are; return how many there are."""
    k = w.contacts.opens[i]
    pressed, little = k >= 0, 0.0 if k < 0 else ROUNDING * told(w, LEAST, k)
    for s in range(SAMPLES):
        _point(w, i, sample_angle(s))
        prelude(w)
        probe(w)
        w.planes.samples[s] = _swerve(w, n_x, i)
        if k >= 0:
            force = _force(w, n_x, k)
            pressed = pressed and abs(force) > little
            w.planes.weights[s] = force
    for s in range(SAMPLES):
        w.planes.samples[s] /= w.planes.weights[s] if pressed else 1.0
    n = find_angles(w)
    for s in range(n):
        for _ in range(POLISHES):
            angle = w.planes.angles[s]
            _point(w, i, angle)
            prelude(w)
            probe(w)
            off = _swerve(w, n_x, i) / (_force(w, n_x, k) if pressed else 1.0)
            w.planes.angles[s] = angle - chord_step(w, angle, off)
    return n


@compiled(inline=True)
def _force(w: LoopArrays, n_x: int, k: int) -> float:
    """Return the normal force of contact k that opens."""
    return w.probe[n_x + w.limits.first_opening + 2 * k + 1, 0]


@compiled(inline=True)
def _swerve(w: LoopArrays, n_x: int, i: int) -> float:
    """Return the slip acceleration of contact i across the direction in which it starts."""
    v = w.planes.variable[i]
    return w.m[v] * w.probe[n_x + backward(i + 1), 1] - w.m[v + 1] * w.probe[n_x + backward(i), 1]


@compiled(inline=True)
def _along(w: LoopArrays, n_x: int, i: int, order: int) -> float:
    """Return a coefficient of the slip of contact i along the direction in which it starts."""
    v = w.planes.variable[i]
    return w.m[v] * w.probe[n_x + backward(i), order] + w.m[v + 1] * w.probe[n_x + backward(i + 1), order]


@compiled
def _turn_to_best(w: LoopArrays, n_x: int, i: int) -> float:
    """Turn contact i to the direction of the largest acceleration; return by how much, NaN if there is none."""
    v = w.planes.variable[i]
    e, f, best, angle = w.m[v], w.m[v + 1], -np.inf, np.nan
    for s in range(_ways(w, n_x, i)):
        _point(w, i, w.planes.angles[s])
        prelude(w)
        probe(w)
        if _along(w, n_x, i, 1) > best:
            best, angle = _along(w, n_x, i, 1), w.planes.angles[s]
    _point(w, i, angle)
    return abs(w.m[v] - e) + abs(w.m[v + 1] - f)


@compiled
def plane_is_right(w: LoopArrays, n_x: int, i: int, time: float, now: float) -> bool:
    """Whether a contact in the plane that is closed sticks within its bound, or starts with its acceleration.

    A start without an acceleration is not contradicted: whether it sticks instead, sticking tells.
    """
    g, j = n_x + backward(i), i + 1
    if w.m[i] > 0.5:
        row = COUPLING + w.contacts.sticks.size + w.limits.n_q + w.limits.coupled
        doubt = max(doubt_of(w, i), doubt_of(w, j))
        doubt *= 2.0 * w.gauge[row, i] + doubt  # the guard is the difference of two squares
        return stays(w.probe[g, 0], w.probe[g, 1], 2.0 * w.probe[g, 2], doubt, time, now)
    if w.selection.zero[i] == 0:
        return True
    a, b = _along(w, n_x, i, 1), 2.0 * _along(w, n_x, i, 2)
    little = max(doubted_acceleration(w, i, b), doubted_acceleration(w, j, b)) + abs(b) * now
    return a >= -little and abs(_swerve(w, n_x, i)) <= little + _ASIDE * abs(a)
