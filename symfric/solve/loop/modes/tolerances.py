"""Thresholds of zero in the state of a run: rounding, ties, and the error of the run."""

from symfric.codegen.numba_types import compiled
from symfric.solve.loop import arithmetic
from symfric.solve.loop.codes import COUPLING, FORCES, PULL, TERMS
from symfric.solve.loop.precision import ROUNDING
from symfric.solve.loop.workspace import LoopArrays

LAST = 1e-12  # part of the natural time before a stop in the plane that is a straight line
EARLIER = 0.125  # weight of the size of a slip with the largest velocities so far beside the present size


@compiled(inline=True)
def sizes_of_velocities(w: LoopArrays, n_x: int) -> None:
    """Put the state with the largest velocities so far into ``w.step.end``."""
    n_q = w.limits.n_q
    for r in range(n_x + 1):
        w.step.end[r] = abs(w.start[r]) + w.scale[r] if n_q <= r < 2 * n_q else w.y[r]


@compiled(inline=True)
def no_acceleration(w: LoopArrays, i: int, jerk: float) -> float:
    """Return the slip acceleration of contact i below which it is zero."""
    return arithmetic.no_acceleration(little(w, i), w.y[w.y.size - 1], jerk)


@compiled(inline=True)
def stays(a: float, b: float, c: float, little: float, time: float, now: float) -> bool:
    """Whether a guard ``a + b t + c t^2/2`` is not negative just after; `now` is the rounding of the present time."""
    little += abs(b) * now
    if not abs(a) <= little:
        return a > 0.0  # false for NaN
    if not abs(b) * time <= little:
        return b > 0.0
    return c * time * time >= -little


@compiled(inline=True)
def little(w: LoopArrays, i: int) -> float:
    """Return the same without the rounding of time."""
    return arithmetic.little_acceleration(w.gauge[PULL, i], w.gauge[FORCES, i])


@compiled
def natural_time(w: LoopArrays) -> float:
    """Return the natural time."""
    return arithmetic.natural_time(w.scale, w.limits.n_q, w.clock.t_end)


@compiled
def instant(w: LoopArrays) -> float:
    """Return the rounding error of time, at least that of the natural time."""
    return arithmetic.instant(w.y[w.y.size - 1], natural_time(w))


@compiled
def no_load(w: LoopArrays, i: int) -> float:
    """Return the rounding error of a zero load, from the forces on the bodies of contact i."""
    coupling = w.gauge[COUPLING + i, i]
    return ROUNDING * w.gauge[FORCES, i] / coupling if coupling > 0.0 else 0.0


@compiled(inline=True)
def doubt_of(w: LoopArrays, i: int) -> float:
    """Return the possible error of the stick force of contact i, by rounding and by the error of the run.

    It is at least what makes no acceleration: a smaller excess would release a slip whose acceleration then counts as
    none. The forces that cancel in the stick force set this least, not its bound, which may be far smaller.
    """
    coupling = w.gauge[COUPLING + i, i]
    return doubted_acceleration(w, i, 0.0) / coupling if coupling > 0.0 else 0.0


@compiled(inline=True)
def doubted_acceleration(w: LoopArrays, i: int, jerk: float) -> float:
    """Return the possible error of the slip acceleration of contact i, by rounding and by the error of the run.

    A contact that sticks up to its bound and one that slips are told apart by the same size, so that one of them is
    right.
    """
    least = no_acceleration(w, i, jerk)
    if w.counts.steps > 0:
        least = arithmetic.doubted_force(least, w.gauge[PULL, i], w.span[TERMS, i], natural_time(w), w.clock.doubt)
    return least


@compiled(inline=True)
def fastest(w: LoopArrays) -> float:
    """Return the scale of the largest velocity."""
    largest = 0.0
    for r in range(w.limits.n_q, 2 * w.limits.n_q):
        largest = max(largest, w.scale[r])
    return largest
