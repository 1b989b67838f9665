"""Thresholds of zero: rounding, ties, and the error of the run."""

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.precision import EPS, MOST_DOUBT, ROUNDING, TIE
from symfric.solve.loop.workspace import COUPLING, FORCES, PULL, TERMS


@compiled(inline=True)
def no_acceleration(w, i, jerk):
    """Return the slip acceleration below which it is zero: by tie, rounding, or rounding of time under a fast load."""
    little = max(TIE * w.gauge[PULL, i], ROUNDING * w.gauge[FORCES, i])
    return max(little, 4.0 * EPS * abs(w.y[w.y.size - 1]) * abs(jerk))


@compiled
def natural_time(w):
    """Return the natural time: the largest ratio of range to speed of a coordinate, about a radian of its vibration.

    Limited by the run, since the speed of a body carried by a belt changes by rounding alone.
    """
    time = 0.0
    n = w.limits.n_q
    for i in range(n):
        if w.scale[n + i] > 0.0:
            time = max(time, w.scale[i] / w.scale[n + i])
    return min(time, w.clock.t_end) if time > 0.0 else 1e-3 * w.clock.t_end


@compiled
def instant(w):
    """Return the rounding error of time, at least that of the natural time."""
    return 4.0 * EPS * max(abs(w.y[w.y.size - 1]), natural_time(w))


@compiled
def no_load(w, i):
    """Return the rounding error of a zero load, from the forces on the bodies of contact i."""
    coupling = w.gauge[COUPLING + i, i]
    return ROUNDING * w.gauge[FORCES, i] / coupling if coupling > 0.0 else 0.0


@compiled(inline=True)
def doubt_of(w, i):
    """Return the possible error of the stick force of contact i, by rounding and by the error of the run.

    It is at least what makes no acceleration: a smaller excess would release a slip whose acceleration then counts as
    none. The forces that cancel in the stick force set this least, not its bound, which may be far smaller. The error
    of the run is its tolerance times acceleration, range of the slip over the natural time, next to that of the bound.
    """
    pull, least = w.gauge[PULL, i], no_acceleration(w, i, 0.0)
    if w.counts.steps > 0:
        error = w.clock.doubt * (pull + w.span[TERMS, i] / natural_time(w))
        least = max(least, min(MOST_DOUBT * pull, error))
    coupling = w.gauge[COUPLING + i, i]
    return least / coupling if coupling > 0.0 else 0.0
