"""Accumulation of the observables, events and trajectory of a run under a sampled input.

An observable is ``r_u u + r_w w + r_f F + r_a a + r_0`` with the friction F over the mass and the input a.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.solve.exact.record.forced_flow import root, value
from symfric.solve.exact.record.workspace import ORDER, RecordArrays
from symfric.solve.loop.arithmetic import slope

# entries of `force`: damping, stiffness, input, constant force, kinetic and static friction, all over the mass
LAM, STIFF, GAIN, CONSTANT, KINETIC, STATIC = range(6)
# entries of a cell: lower edge, upper edge, coefficient and slope of the line through u = 0
LOW, HIGH, MU, SLOPE = range(4)
R_U, R_W, R_F, R_A, R_0 = range(5)
SMALLEST, LARGEST = range(2)  # entries of `total`
_MARGIN = 2.0  # safety factor of a bound on a rate from its values at the ends of a piece
_PARTS = 4  # parts of a piece, in each of which an observable has at most one extremum


@compiled
def enter(w: RecordArrays, s: float) -> None:
    """Set the observables of the current direction and cell: slopes in u, w and the input, and a constant."""
    line = w.cells[w.place.where]
    b0, b1 = -s * w.force[KINETIC] * line[MU], -s * w.force[KINETIC] * line[SLOPE]
    for e in range(w.rows.shape[0]):
        row, now = w.rows[e], w.now[e]
        now[0], now[1], now[2] = row[R_U] + row[R_F] * b1, row[R_W], row[R_A]
        now[3] = row[R_0] + row[R_F] * b0


@compiled
def hold(w: RecordArrays, u: float) -> None:
    """Set the observables while the mass sticks at u, where friction balances the applied force."""
    for e in range(w.rows.shape[0]):
        row, now = w.rows[e], w.now[e]
        now[0], now[1] = row[R_U] + row[R_F] * w.force[STIFF], row[R_W]
        now[2], now[3] = row[R_A] - row[R_F] * w.force[GAIN], row[R_0] - row[R_F] * w.force[CONSTANT]


@compiled
def _extend(w: RecordArrays, e: int, number: float) -> None:
    if number < w.observed.total[e, SMALLEST]:
        w.observed.total[e, SMALLEST] = number
    if number > w.observed.total[e, LARGEST]:
        w.observed.total[e, LARGEST] = number


@compiled
def _ends_and_turns(cr: np.ndarray, h: float) -> tuple[float, float]:
    """Return the smallest and the largest value of a polynomial between 0 and h."""
    low_value = min(cr[0], value(cr, h))
    high_value = max(cr[0], value(cr, h))
    low, rising = 0.0, cr[1] > 0.0
    for part in range(1, _PARTS + 1):
        high = h * part / _PARTS
        rises = slope(cr, high) > 0.0
        if rises != rising:
            number = value(cr, root(cr, 0.0, low, high, True))
            low_value, high_value = min(low_value, number), max(high_value, number)
        low, rising = high, rises
    return low_value, high_value


@compiled
def _row(w: RecordArrays, e: int, a: float, slope_a: float, t: float) -> float:
    """Compute the series of an observable in the current piece; return its value after the time t."""
    now, size = w.now[e], w.place.order + 1
    cr = w.cr[:size]
    for k in range(size):
        cr[k] = now[0] * w.cu[k] + now[1] * w.cw[k]
    cr[0] += now[2] * a + now[3]
    cr[1] += now[2] * slope_a
    return value(cr, t)


@compiled(inline=True)
def wants_values(w: RecordArrays, e: int) -> bool:
    """Whether an observable is sampled at given times."""
    return w.times.first[e] < w.times.first[e + 1]


@compiled
def _note_values(w: RecordArrays, e: int, t: float, h: float, a: float, slope_a: float) -> None:
    """Store the values of an observable at its times in a piece; the next piece may overwrite one at the end."""
    k, end = w.observed.next_due[e], w.times.first[e + 1]
    while k < end and w.times.due[k] <= t + h * (1.0 + 1e-9):
        if w.times.due[k] >= t - 1e-9 * h:
            w.observed.seen[k] = _row(w, e, a, slope_a, w.times.due[k] - t)
        if w.times.due[k] < t + h * (1.0 - 1e-9):
            w.observed.next_due[e] = k + 1
        k += 1


@compiled
def note(w: RecordArrays, t: float, h: float, a: float, slope_a: float, s: int) -> None:
    """Accumulate all observables over a piece of length h with the series cu and cw, and store it if required."""
    size = w.place.order + 1
    cu, cw = w.cu[:size], w.cw[:size]
    # w keeps its sign in a piece, so u moves one way; the bounds spare most observables their polynomial
    far = abs(value(cu, h) - cu[0])
    steep = h * _MARGIN * max(abs(cw[1]), abs(slope(cw, h)))
    for e in range(w.rows.shape[0]):
        now = w.now[e]
        if wants_values(w, e):
            _note_values(w, e, t, h, a, slope_a)
            continue
        begin = now[0] * cu[0] + now[1] * cw[0] + now[2] * a + now[3]
        room = abs(now[0]) * far + abs(now[1]) * steep + abs(now[2] * slope_a) * h
        if begin - room < w.observed.total[e, SMALLEST] or begin + room > w.observed.total[e, LARGEST]:
            _row(w, e, a, slope_a, 0.0)
            smallest, largest = _ends_and_turns(w.cr[:size], h)
            _extend(w, e, smallest)
            _extend(w, e, largest)
    if w.limits.keep_path:
        k = w.counts.kept_steps
        if k < w.stored.path_t.shape[0]:
            w.stored.path_t[k, 0], w.stored.path_t[k, 1] = t, h
            for j in range(ORDER + 1):
                w.stored.path_c[k, 0, j], w.stored.path_c[k, 1, j] = w.cu[j], w.cw[j]
            w.stored.path_m[k, 0] = s
        w.counts.kept_steps += 1


@compiled
def note_end(w: RecordArrays, u: float, a: float) -> None:
    """Extend the ranges by the values at the end of a whole sample of sticking, in which all observables are linear."""
    for e in range(w.rows.shape[0]):
        now = w.now[e]
        if now[2] != 0.0 and not wants_values(w, e):
            _extend(w, e, now[0] * u + now[2] * a + now[3])


@compiled(inline=True)
def is_plain(w: RecordArrays) -> bool:
    """Whether every observable depends on u alone or on w alone in the current mode."""
    mixed = 0
    for e in range(w.rows.shape[0]):
        mixed += not wants_values(w, e) and (w.now[e, 2] != 0.0 or (w.now[e, 0] != 0.0 and w.now[e, 1] != 0.0))
    return mixed == 0


@compiled(inline=True)
def quiet(w: RecordArrays, h: float, u: float, v: float, a: float, steep: float, turns: bool, slope_f: float) -> bool:
    """Extend the ranges by the values at the end of a whole sample; return False if an extremum may lie inside.

    Rows of u alone turn where w is zero, which does not happen here, and those of w alone where its rate is.
    """
    quick = h * h * (abs(w.force[LAM]) * steep + w.sizes.stiffest * abs(v) + abs(slope_f))
    for e in range(w.rows.shape[0]):
        now = w.now[e]
        if wants_values(w, e) or (now[2] == 0.0 and (now[1] == 0.0 or (now[0] == 0.0 and not turns))):
            continue
        number = now[0] * u + now[1] * v + now[2] * a + now[3]
        room = abs(now[0]) * h * h * steep + abs(now[1]) * (h * steep if turns else quick)
        if number - room < w.observed.total[e, SMALLEST] or number + room > w.observed.total[e, LARGEST]:
            return False
    return True


@compiled
def log(w: RecordArrays, t: float, old: float, new: float) -> None:
    """Log an event."""
    if w.limits.keep_events:
        k = w.counts.kept_events
        if k < w.stored.event_t.size:
            w.stored.event_t[k] = t
            w.stored.event_i[k, 0], w.stored.event_i[k, 1], w.stored.event_i[k, 2] = 0, np.int64(old), np.int64(new)
        w.counts.kept_events += 1
    w.counts.events += 1
