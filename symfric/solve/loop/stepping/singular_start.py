"""Starts at points where the equations have no Taylor series although the motion is well defined.

A law like mu_d + alpha sqrt(v) has an infinite slope at rest. The slip then grows like B t^2 (release at the static
bound) or c t + C t^(3/2) (release with a jump of the force); one short step with the right weight of its end catches
the leading terms.

Where such a slip falls to zero again, steps shrink until they are a rounding error short of it, and the coefficients
overflow: the rest is a straight line.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.codes import EXPAND, NOT_FINITE, OK, PULL, SELECT, SLIP, TERMS
from symfric.solve.loop.modes.layout import backward, way
from symfric.solve.loop.modes.tolerances import natural_time, no_acceleration
from symfric.solve.loop.precision import ROUNDING, TIE
from symfric.solve.loop.recording.trajectory import store_step
from symfric.solve.loop.stepping.calls import expand, measure
from symfric.solve.loop.workspace import LoopArrays

# length of the step relative to the natural time: rounding of the slip and truncation are both about 1e-11
FRACTION = 1e-6
ARRIVAL = 1e-9  # longest straight step to a singular rest, likewise: the rate changes by its square root at most
NEGLIGIBLE = 1e-9  # displacement by a curvature in that time, relative to a state's range, that is negligible


@compiled
def within_rounding(w: LoopArrays, n_x: int, n_c: int, h: float) -> bool:
    """Whether a step leaves a slip that begins within its rounding error, whose chance decides on the series there."""
    within = 0
    for i in range(n_c):
        if w.m[i] >= 0.5 or w.guards.fresh[backward(i)] == 0 or w.contacts.partner[i] >= 0:
            continue
        row = n_x + backward(i)
        reach = abs(w.c[row, 0]) + h * (abs(w.c[row, 1]) + h * abs(w.c[row, 2]))
        if reach <= ROUNDING * w.gauge[TERMS, i]:
            little = no_acceleration(w, i, 0.0)  # up to which others hold it at zero
            within += abs(w.c[row, 1]) > little or abs(w.c[row, 2]) * natural_time(w) > little
    return within > 0


@compiled
def start_singular(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Step over a singular start from ``w.y``; the rate there is in ``w.c`` or, if undefined, in ``w.step.base``.

    A slip that has fallen to zero up to rounding has arrived there, although its series overflows before.
    """
    if _arrives(w, n_x, n_c):
        return OK
    w.counts.stall += 1
    begins = False
    for g in range(w.guards.fresh.size):
        begins = begins or w.guards.fresh[g] != 0
    if not begins and arrives(w, n_x, n_c):
        return OK
    if w.counts.stall > 20 or (w.counts.stall == 1 and not begins):
        return NOT_FINITE
    if begins:
        _turn_slips(w, n_c)
    for r in range(n_x):
        w.step.base[0, r] = w.y[r]
        if abs(w.c[r, 1]) < np.inf:
            w.step.base[1, r] = w.c[r, 1]
        elif _varies(w, n_x, r):
            w.step.base[1, r] = 0.0
            w.counts.doubts += 1
        if not abs(w.step.base[1, r]) < np.inf:
            return NOT_FINITE
    which, weight, time = -1, 2.0 / 3.0, natural_time(w)
    for i in range(n_c):
        if w.m[i] < 0.5 and w.guards.fresh[backward(i)] and w.gauge[PULL, i] > 0.0:
            which = i
            size, rate = max(w.gauge[TERMS, i], w.span[TERMS, i]), abs(w.c[n_x + backward(i), 1])
            pull = max(w.gauge[PULL, i], rate)
            time = size / pull if size > 0.0 else time
            if rate <= TIE * w.gauge[PULL, i]:
                weight = 0.5
    h = min(FRACTION * time, w.clock.t_end - w.y[n_x], 0.5 * _next_stop(w, n_x, n_c))
    for r in range(n_x):  # a branch that is singular too has a large curvature
        if not h * h * abs(w.step.base[2, r]) < NEGLIGIBLE * max(w.scale[r], h * abs(w.step.base[1, r])):
            w.step.base[2, r] = 0.0
    w.y[n_x] += h
    status = OK
    if which >= 0:
        _balance(w, n_x, which, weight, h)
        status = _endpoint(w, n_x, weight, h)
    else:  # a kink: the old branch is regular here with the same force, so it is used for one short step
        for r in range(n_x):
            w.y[r] = w.step.base[0, r] + h * (w.step.base[1, r] + h * w.step.base[2, r])
    keep_straight(w, n_x, n_c, h)
    for g in range(w.guards.fresh.size):
        w.guards.fresh[g] = 0
    w.counts.phase = EXPAND
    return status


@compiled
def _turn_slips(w: LoopArrays, n_c: int) -> None:
    """Move slips of contacts that begin to slip, whose rounding lies on the other side, to their side of zero."""
    moved = False
    for i in range(n_c):
        measure(w, w.y, w.gauge)
        little = ROUNDING * max(w.gauge[TERMS, i], 0.125 * w.span[TERMS, i])  # as slips that are zero are told
        if w.m[i] < 0.5 and w.guards.fresh[backward(i)] and -little <= way(w, i) * w.gauge[SLIP, i] < 0.0:
            k, slope = _moved_most(w, i)
            w.y[k] += way(w, i) * little / slope
            moved = True
    if moved:
        measure(w, w.y, w.gauge)
        expand(w)


@compiled
def _next_stop(w: LoopArrays, n_x: int, n_c: int) -> float:
    """Return the time after which the slip of another contact falls to zero, at its present rate."""
    soonest = np.inf
    for i in range(n_c):
        slip, rate = w.c[n_x + backward(i), 0], w.c[n_x + backward(i), 1]
        if w.m[i] < 0.5 and not w.guards.fresh[backward(i)] and slip > 0.0 and slip < -rate * soonest:
            soonest = slip / -rate
    return soonest


@compiled(inline=True)
def _varies(w: LoopArrays, n_x: int, r: int) -> bool:
    """Whether row r is a derivative of a state: with an infinite slope its rate is infinite, and it is in doubt."""
    return r >= n_x // (1 + w.limits.varied)


@compiled
def arrives(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Step to the rest of the contact whose slip is about to fall to zero; return whether one is that near."""
    h, hit = min(ARRIVAL * natural_time(w), w.clock.t_end - w.y[n_x]), -1
    for i in range(n_c):
        slip, rate = w.c[n_x + backward(i), 0], w.c[n_x + backward(i), 1]
        if w.m[i] < 0.5 and slip >= 0.0 and slip < -rate * h:
            h, hit = slip / -rate, backward(i)
    if hit < 0:
        return False
    for r in range(n_x):
        w.step.base[0, r], w.step.base[1, r], w.step.base[2, r] = w.y[r], w.c[r, 1], 0.0
        if not abs(w.c[r, 1]) < np.inf:
            if not _varies(w, n_x, r):
                return False
            w.step.base[1, r] = 0.0
    w.counts.doubts += w.limits.varied
    for r in range(n_x):
        w.y[r] += h * w.step.base[1, r]
    w.y[n_x] += h
    keep_straight(w, n_x, n_c, h)
    for g in range(w.guards.hit.size):
        w.guards.hit[g], w.guards.fresh[g] = g == hit, 0
    w.counts.phase = SELECT
    return True


@compiled
def _arrives(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Mark the slips that fall and are zero up to rounding as hit; return whether there are any."""
    found = False
    for g in range(w.guards.hit.size):
        w.guards.hit[g] = 0
    for i in range(n_c):
        row = n_x + backward(i)
        if w.m[i] < 0.5 and not w.guards.fresh[backward(i)] and w.c[row, 0] <= ROUNDING * w.scale[row]:
            arrived = not w.c[row, 1] >= 0.0  # on the other side of zero there may be no rate
            w.guards.hit[backward(i)] = arrived
            found = found or arrived
    if found:
        w.counts.phase = SELECT
    return found


@compiled
def keep_straight(w: LoopArrays, n_x: int, n_c: int, h: float) -> None:
    """Append the short step to the trajectory, as a straight line."""
    if w.limits.keep_path == 0 or w.counts.kept_steps >= w.stored.path_t.shape[0]:
        return
    k = store_step(w, n_c, w.y[n_x] - h, h)
    for r in range(n_x):
        for j in range(w.c.shape[1]):
            w.stored.path_c[k, r, j] = 0.0
        w.stored.path_c[k, r, 0], w.stored.path_c[k, r, 1] = w.step.base[0, r], (w.y[r] - w.step.base[0, r]) / h


@compiled
def _balance(w: LoopArrays, n_x: int, i: int, weight: float, h: float) -> None:
    """Bisect for the slip of contact i at the end of the step that is consistent with the rates at both ends.

    The equations depend on the other states smoothly, so that the slip may be that of a change of one velocity.
    """
    for r in range(n_x):
        w.y[r] = w.step.base[0, r] + h * w.step.base[1, r]
    k, slope = _moved_most(w, i)
    measure(w, w.y, w.gauge)
    straight, side, first = w.gauge[SLIP, i], float(way(w, i)), w.y[k]
    high = 2.0 * (h * w.gauge[PULL, i] + abs(straight))
    low = 1e-12 * high
    for _ in range(80):
        slip = np.sqrt(low * high) if low > 0.0 else 0.5 * high
        w.y[k] = first + (side * slip - straight) / slope
        expand(w)
        gain = (1.0 - weight) * side * straight + weight * h * w.c[n_x + backward(i), 1]
        if gain > slip:
            low = slip
        else:
            high = slip


@compiled
def _moved_most(w: LoopArrays, i: int) -> tuple[int, float]:
    """Return the velocity that the slip of contact i depends on most, and its slope."""
    place, slope = w.limits.n_q, 0.0
    measure(w, w.y, w.gauge)
    before = w.gauge[SLIP, i]
    for k in range(w.limits.n_q, 2 * w.limits.n_q):
        velocity = w.y[k]
        step = 1.0 + abs(velocity)
        w.y[k] = velocity + step
        measure(w, w.y, w.gauge)
        w.y[k] = velocity
        if abs(w.gauge[SLIP, i] - before) > abs(slope) * step:
            place, slope = k, (w.gauge[SLIP, i] - before) / step
    return place, slope


@compiled
def _endpoint(w: LoopArrays, n_x: int, weight: float, h: float) -> int:
    """Advance all states by the weighted rates at both ends."""
    expand(w)
    for r in range(n_x):
        if not abs(w.c[r, 1]) < np.inf:
            w.y[r] = w.step.base[0, r] + h * w.step.base[1, r]
        else:
            w.y[r] = w.step.base[0, r] + h * ((1.0 - weight) * w.step.base[1, r] + weight * w.c[r, 1])
        if not abs(w.y[r]) < np.inf:
            return NOT_FINITE
    return OK
