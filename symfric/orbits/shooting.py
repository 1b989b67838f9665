"""Shooting: periodic orbits as zeros of the map over a period, by Newton's method.

Unknowns are the start y, the period T of an autonomous scene, and parameters that are free to move. The equations are

    y(T) - y = 0,    n . (y - y_ref) = 0,    and perhaps one more that singles out a point of a branch,

the second for autonomous scenes only: the start moves at right angles to the motion through a reference, where every
state is measured in units of its range. In other units that plane may be all but parallel to the motion, and a branch
would run along one orbit instead of from orbit to orbit. Derivatives are those of the variational equations with the
jumps at the events. Where the slider behind a spring sticks all the time, nothing determines its place: it is chosen
such that the mean elongation is zero, and kept along a branch. Linear equations are solved in these units too: what
counts as zero there must not depend on those of the scene.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from symfric.errors import NotFound
from symfric.orbits.flow_map import FlowMap
from symfric.orbits.passages import Passage
from symfric.orbits.sizes import LEAST

MOST_STEPS = 25  # of Newton's method
_HALVINGS = 6  # most halvings of a Newton step that does not reduce the residual
_LONGER = 10.0  # ratio of the period of a trial to that of the guess, or its inverse, beyond which it is another orbit
_STEP = 1e-6  # finite-difference step relative to the sizes of the unknowns
_ROUNDING = 1e-15  # change relative to a step, and to the sizes of the unknowns, that is rounding only
_STILL = 64 * float(np.finfo(float).eps) / LEAST  # residual, relative to its range, of a state that does not move
_NARROW = 1e-6  # least size of a parameter, relative to its span
_RATIOS = 0.4, 0.8  # length of a step relative to the one before, near roots of order 2 to 5: 1 - 1/order
_STRAIGHT = 0.1  # part of a step that is across the one before, at most
_BEYOND = 1.05  # length of a leap across such a root, relative to that to it
_QUARTER = 0.25  # most of the residual that a leap may leave, about what one step leaves
_STUCK = "Newton's method on the map over a period does not converge from this guess"


class Point(NamedTuple):
    """A trial or a solution of the shooting equations: unknowns, passage over the period, residuals and derivatives.

    Attributes
    ----------
    z : ndarray, shape (n_z,)
        ``[y; T; parameters]``, without T if the scene is forced.
    passage : Passage
    rest : ndarray, shape (n_e,)
    slopes : ndarray, shape (n_e, n_z)
    phase : ndarray, shape (n_x,)
        Normal of the phase condition; its product with a state is in units of the ranges.
    """

    z: np.ndarray
    passage: Passage
    rest: np.ndarray
    slopes: np.ndarray
    phase: np.ndarray


@dataclass(frozen=True)
class TestFunction:
    """A test function: an additional equation.

    Attributes
    ----------
    value : callable
        ``(z, passage) -> float``, of the order of one away from the solution.
    slopes : callable or None
        ``(z, passage) -> ndarray``, shape (n_z,); differences if None.
    """

    value: Callable[[np.ndarray, Passage], float]
    slopes: Callable[[np.ndarray, Passage], np.ndarray] | None = None


@dataclass(frozen=True)
class ShootingSystem:
    """The equations of periodic orbits of one scene.

    Attributes
    ----------
    flow : FlowMap
        With derivatives by the free parameters.
    values : dict
        Values of all parameters, by name.
    multiple : int
        Periods of the excitation in one of the orbit; 0 if the scene is autonomous.
    test : TestFunction or None
    lift : ndarray or None
        See `Flow.run`.
    widths : tuple of float
        Widths of the spans of the free parameters, which scale changes of a parameter near zero.
    """

    flow: FlowMap
    values: dict[str, float]
    multiple: int = 0
    test: TestFunction | None = None
    lift: np.ndarray | None = None
    widths: tuple[float, ...] = ()

    @property
    def free(self) -> bool:
        """Whether the period is an unknown."""
        return self.multiple == 0

    def pack(self, start: np.ndarray, period: float, values: dict[str, float]) -> np.ndarray:
        """Return the unknowns as one vector."""
        moving = [values[n] for n in self.flow.parameters]
        return np.concatenate([start, [period] if self.free else [], moving])

    def unpack(self, z: np.ndarray) -> tuple[np.ndarray, float, dict[str, float]]:
        """Return start, period, and all values."""
        n = len(self.flow.states)
        values = {**self.values, **dict(zip(self.flow.parameters, z[n + self.free :].tolist(), strict=True))}
        if self.free:
            return z[:n], float(z[n]), values
        assert self.flow.period is not None
        return z[:n], self.multiple * self.flow.period(values), values

    def period(self, z: np.ndarray) -> float:
        """Return the period."""
        return float(z[len(self.flow.states)]) if self.free else self.unpack(z)[1]

    def sizes(self, z: np.ndarray, passage: Passage) -> np.ndarray:
        """Return the sizes of the unknowns (ranges of the states, period, parameters), (n_z,)."""
        size = np.append(passage.ranges, np.abs(z[passage.end.size :]))
        if self.widths:
            size[-len(self.widths) :] = np.maximum(size[-len(self.widths) :], _NARROW * np.array(self.widths))
        return size

    def follow(self, z: np.ndarray) -> Passage:
        """Evaluate the flow map over the period."""
        return self._over(*self.unpack(z))

    def _over(self, start: np.ndarray, period: float, values: dict[str, float]) -> Passage:
        if not period > 0:
            raise NotFound(_STUCK)
        return self.flow.run(start, values, period, self.lift)

    def at(self, z: np.ndarray, phase: np.ndarray | None, reference: np.ndarray, beside: Point | None = None) -> Point:
        """Return residuals and derivatives, with phase condition `phase`, by default from the motion itself.

        With an orbit `beside` of the same branch the start moves from that, across the mean of both motions.
        """
        y, period, values = self.unpack(z)
        passage = self._over(y, period, values)
        if phase is None:
            phase = _across(passage) if beside is None else 0.5 * (_across(passage) + _across(beside.passage))
        n = y.size
        by_value = passage.by_value
        if not self.free and self.flow.parameters and self.flow.period_by:
            by_value = by_value + self.multiple * np.outer(passage.rate, self.flow.period_by(values))
        columns = [passage.by_start - np.eye(n), *([passage.rate[:, None]] if self.free else []), by_value]
        rest, slopes = passage.end - y, np.hstack(columns)
        for k in passage.idle:  # closed with the coordinates
            row = np.eye(1, z.size, k)[0]
            rest[k] = 0.5 * (passage.low[k] + passage.high[k])
            if self.flow.parameters:  # along a branch the slider stays where it is
                row[: len(self.flow.springs[k])] = -self.flow.springs[k]
                rest[k] = row[:n] @ (y - reference)
            slopes[k] = row
        if self.free:
            row = np.concatenate([phase, np.zeros(z.size - n)])
            away = y - (reference if beside is None else beside.z[:n])
            rest, slopes = np.append(rest, phase @ away), np.vstack([slopes, row])
        if self.test:
            more = self._slopes(self.test, z, passage)
            rest, slopes = np.append(rest, self.test.value(z, passage)), np.vstack([slopes, more])
        return Point(z, passage, rest, slopes, phase)

    def across_itself(self, point: Point) -> Point:
        """Return a solution with the phase condition of its own motion, which a tangent of the branch has to meet."""
        if not self.free:
            return point
        phase, slopes, n = _across(point.passage), point.slopes.copy(), point.passage.end.size
        slopes[n, :n] = phase
        return point._replace(phase=phase, slopes=slopes)

    def _slopes(self, test: TestFunction, z: np.ndarray, passage: Passage) -> np.ndarray:
        if test.slopes:
            return test.slopes(z, passage)
        steps, value = _STEP * self.sizes(z, passage), test.value(z, passage)
        ahead = [z + step for step in np.diag(steps)]
        return np.array([test.value(there, self.follow(there)) - value for there in ahead]) / steps


def solve(
    system: ShootingSystem,
    z: np.ndarray,
    normal: np.ndarray | None = None,
    most: int = MOST_STEPS,
    through: np.ndarray | None = None,
    reference: np.ndarray | None = None,
    first: Point | None = None,
    beside: Point | None = None,
    slow: int | None = None,
    reach: np.ndarray | None = None,
) -> Point:
    """Solve the shooting equations by Newton's method from a guess.

    Parameters
    ----------
    system : ShootingSystem
    z : ndarray, shape (n_z,)
    normal : ndarray, shape (n_z,), optional
        Direction along the solution curve if there is one unknown more than equations; steps are orthogonal to it.
    most : int
        Steps of Newton's method.
    through : ndarray, shape (n_z,), optional
        A point of the plane orthogonal to `normal` that contains the solution; the guess unless given.
    reference : ndarray, shape (n_z,), optional
        Unknowns from which phase and the places of idle sliders are measured; the guess unless given.
    first : Point, optional
        The equations at the guess, where they are known.
    beside : Point, optional
        An orbit of the same branch from which the phase is measured instead.
    slow : int, optional
        Number of steps that may leave more than half of the residual; by default all of them.
    reach : ndarray, shape (n_z,), optional
        Largest distance of a trial from the guess, by default any.

    Raises
    ------
    NotFound
        If Newton's method does not converge, or not within these limits.
    """
    plane, base = z if through is None else through, z if reference is None else reference
    now = system.at(z, None, base[: len(system.flow.states)], beside) if first is None else first
    size, last = (misfit(now) if through is None else 1.0), None
    for _ in range(most):
        before, start = max(size, 100 * system.flow.closed), now
        now, size, share = _improved(system, now, size, normal, base, plane, beside)
        step = (now.z - start.z) / system.sizes(start.z, start.passage)
        ahead = _root_ahead(last, step) if share == 1.0 and size > system.flow.closed else 0.0
        if ahead > 0.0:
            now, size = _leapt(system, now, size, ahead * (now.z - start.z), base, beside)
        last = step
        if size <= system.flow.closed and share == 1.0:
            return now
        if slow is not None:
            slow -= size > 0.5 * before
            if slow < 0:
                break
        if reach is not None and np.any(np.abs(now.z - z) > reach):
            break
    raise NotFound(_STUCK)


def _improved(
    system: ShootingSystem,
    now: Point,
    size: float,
    normal: np.ndarray | None,
    guess: np.ndarray,
    plane: Any,
    beside: Point | None,
) -> tuple[Point, float, float]:
    """Take one step of Newton's method, shortened until the residual falls."""
    n = len(system.flow.states)
    away = 0.0 if normal is None else -float(normal @ (now.z - plane))
    step = step_of(system, now, -now.rest, normal, away)
    if not np.all(np.isfinite(step)):
        raise NotFound(_STUCK)
    period = system.period(guess)
    for halving in range(_HALVINGS + 1):
        share = 0.5**halving
        if not period / _LONGER < system.period(now.z + share * step) < period * _LONGER:
            continue  # a run over it would cost as much as very many orbits
        try:
            then = system.at(now.z + share * step, now.phase, guess[:n], beside)
        except NotFound:
            continue
        worse = misfit(then)
        if worse < max(2.0 * size, 100 * system.flow.closed):
            return then, worse, share
    raise NotFound(_STUCK)


def _root_ahead(before: np.ndarray | None, step: np.ndarray) -> float:
    """Return how many of its last steps lead Newton's method just beyond a root of higher order; 0 if it nears none.

    There every step is ``1 - 1/m`` of the one before, in its direction, of order m. So a body whose creep dies out
    comes to where it is held: what it moves in a period is a power of the way that is left, and zero beyond.
    """
    if before is None:
        return 0.0
    ratio = float(before @ step) / max(float(before @ before), 1e-300)
    aside = np.linalg.norm(step - ratio * before)
    if not (_RATIOS[0] < ratio < _RATIOS[1] and aside <= _STRAIGHT * np.linalg.norm(step)):
        return 0.0
    return _BEYOND * ratio / (1.0 - ratio)


def _leapt(
    system: ShootingSystem, now: Point, size: float, step: np.ndarray, guess: np.ndarray, beside: Point | None
) -> tuple[Point, float]:
    """Return the point after a longer step and its misfit, if that is less than one of the next step would be."""
    try:
        then = system.at(now.z + step, now.phase, guess[: len(system.flow.states)], beside)
    except NotFound:
        return now, size
    left = misfit(then)
    return (then, left) if left < _QUARTER * size else (now, size)


def step_of(
    system: ShootingSystem, point: Point, change: np.ndarray, normal: np.ndarray | None = None, along: float = 0.0
) -> np.ndarray:
    """Return the change of the unknowns that changes the residuals by given amounts, (n_z,).

    If the equations do not determine it, it is the shortest one in units of `sizes`; with `normal` one that has
    the product `along` with that.
    """
    size, scale = system.sizes(point.z, point.passage), scale_of(point)
    A, rest = scaled_slopes(point, size, scale), change / scale
    if normal is not None:
        row = normal * size
        length = float(np.linalg.norm(row))
        A, rest = np.vstack([A, row / length]), np.append(rest, along / length)
    if not (np.all(np.isfinite(A)) and np.all(np.isfinite(rest))):
        raise NotFound("the orbit has no derivatives: it grazes, or a law with an infinite slope comes to rest on it")
    step = _solution(A, rest, system.flow.closed)
    rounding = np.abs(step) <= _ROUNDING * max(1.0, np.max(np.abs(step)))
    return size * np.where(rounding, 0.0, step)  # changes below rounding are zero, so that a body at rest stays at rest


def _solution(A: np.ndarray, b: np.ndarray, error: float) -> np.ndarray:
    """Return the solution of ``A x = b``, the shortest if A is not square, or singular up to its relative error.

    So it is where a body that friction holds for good may rest at any place: the map over a period is the identity
    there, but for the error of the motion.
    """
    if A.shape[0] == A.shape[1]:
        try:
            x = np.linalg.solve(A, b)
        except np.linalg.LinAlgError:
            x = np.full(A.shape[1], np.inf)
        if np.max(np.abs(b)) >= error * A.shape[1] * np.max(np.abs(A)) * np.max(np.abs(x)):
            return np.asarray(x)
    return np.asarray(np.linalg.lstsq(A, b, rcond=A.shape[1] * error)[0])


def _across(passage: Passage) -> np.ndarray:
    """Return the normal of Poincare's phase condition: the start moves across the motion, in ranges of the states."""
    rate = passage.rate / passage.ranges
    return np.asarray(rate / max(float(np.linalg.norm(rate)), 1e-300) / passage.ranges)


def null_of(system: ShootingSystem, point: Point) -> np.ndarray:
    """Return a null direction of the equations, (n_z,)."""
    size = system.sizes(point.z, point.passage)
    return np.asarray(size * np.linalg.svd(scaled_slopes(point, size))[2][-1])


def scale_of(point: Point) -> np.ndarray:
    """Return the scales of the equations: the ranges of the states, and 1 for the others, (n_e,)."""
    scale = np.ones(point.rest.size)
    scale[: point.passage.ranges.size] = point.passage.ranges
    return scale


def scaled_slopes(point: Point, size: np.ndarray, scale: np.ndarray | None = None) -> np.ndarray:
    """Return the derivatives for unknowns in units `size` and equations in their scales, (n_e, n_z)."""
    return np.asarray(point.slopes * size / (scale_of(point) if scale is None else scale)[:, None])


def misfit(point: Point) -> float:
    """Return the largest residual relative to the ranges of the states; a large number if one is not finite.

    A state that does not move, such as a place of a body that only turns, comes back up to the rounding of the others.
    """
    away, passage = np.abs(point.rest) / scale_of(point), point.passage
    still = np.flatnonzero(passage.high - passage.low < passage.ranges)
    away[still] = np.where(away[still] <= _STILL, 0.0, away[still])
    worst = float(np.max(away))
    return worst if np.isfinite(worst) else np.inf
