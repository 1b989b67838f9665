"""Reference for steps, sampled controllers and kicks: SciPy from one known instant to the next.

One mass, or two in a row, with friction that cannot chatter: no contact feels the force of another. Whether a contact
at slip zero sticks is decided by the balance of its forces. Everything is numbers and plain functions; nothing is
shared with the package, which gets the same system as a scene, see `symfric_evidence.stress.families.instants`.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

Coefficient = Callable[[float], float]
State = np.ndarray
_TOLERANCE = 1e-12  # relative; DOP853
_LONGEST = 0.04  # longest step of the integrator; slips and sticks that are shorter may be skipped
_ZERO = 1e-11  # slip relative to its terms that counts as zero
_TOGETHER = 1e-9  # difference of instants, relative to the horizon, that counts as none
_MOST = 2000  # most changes of mode


class NoAnswer(Exception):
    """Raised where the reference does not go on; the message says why."""


@dataclass(frozen=True)
class Friction:
    """One contact.

    Attributes
    ----------
    row : ndarray, shape (n,)
        Slip = row @ velocities - belt(t).
    belt, load : callable
        Piecewise constant functions of time.
    static : float
    kinetic : callable
        Coefficient at a speed.
    """

    row: np.ndarray
    belt: Callable[[float], float]
    load: Callable[[float], float]
    static: float
    kinetic: Coefficient


@dataclass(frozen=True)
class Instant:
    """What happens at an instant; of those at one time the ones of lower rank come first.

    Attributes
    ----------
    time : float
    rank : int
    act : callable
        ``act(state, memory)`` changes both in place.
    """

    time: float
    rank: int
    act: Callable[[State, dict[str, float]], None]


@dataclass(frozen=True)
class SteppedSystem:
    """A system between known instants.

    Attributes
    ----------
    masses : ndarray, shape (n,)
    force : callable
        ``force(state, t, piece, memory)``, shape (n,), smooth in state and t; `piece` is a time within the piece, from
        which functions that step are taken.
    contacts : sequence of Friction
        No two of them on one mass.
    steps : sequence of float
        Times at which forces, loads and belts step.
    instants : sequence of Instant
    memory : mapping of str to float
        Held values at the start.
    longest : float
        Longest step of the integrator; modes that last shorter may be skipped.
    """

    masses: np.ndarray
    force: Callable[[State, float, float, Mapping[str, float]], np.ndarray]
    contacts: Sequence[Friction]
    steps: Sequence[float]
    instants: Sequence[Instant]
    memory: Mapping[str, float]
    longest: float = _LONGEST

    def run(self, start: Sequence[float], times: Sequence[float]) -> np.ndarray:
        """Return the states at increasing times, shape (n_x, n_t).

        Raises
        ------
        NoAnswer
            If a step fails, forces are not finite, or modes change too often.
        """
        y, memory, horizon = np.array(start, dtype=float), dict(self.memory), times[-1]
        near = _TOGETHER * horizon
        stops = sorted({*self.steps, *(i.time for i in self.instants), *times})
        edges = [0.0]
        for stop in stops:
            if edges[-1] + near < stop <= horizon:
                edges.append(stop)
        found = []
        for k, begin in enumerate(edges):
            if k:
                y = self._passed(y, edges[k - 1], begin, memory)
            found += [y.copy() for time in times if abs(time - begin) <= near]
            if begin < horizon - near:
                due = [i for i in self.instants if abs(i.time - begin) <= near]
                for instant in sorted(due, key=lambda i: i.rank):
                    instant.act(y, memory)
        return np.array(found).T

    def _passed(self, y: State, begin: float, end: float, memory: Mapping[str, float]) -> State:
        """Return the state after a piece without instants."""
        piece, t = 0.5 * (begin + end), begin
        hit: list[int] = []
        modes: list[int] = []
        for _ in range(_MOST):
            modes = self._modes(y, t, piece, memory, {i: modes[i] for i in hit})
            y, t, hit = self._in_mode(y, t, end, piece, memory, modes)
            if t >= end:
                return y
        raise NoAnswer(f"too many changes of mode near t = {t:g}")

    def _needed(self, contact: Friction, f: np.ndarray) -> float:
        """Return the force of a contact that keeps its slip, by the balance of forces."""
        inertia = contact.row / self.masses
        return -float(inertia @ f) / float(inertia @ contact.row)

    def _modes(
        self, y: State, t: float, piece: float, memory: Mapping[str, float], ended: Mapping[int, int]
    ) -> list[int]:
        """Return 0 for every contact that sticks, else the direction of its slip; slips that stick are set to zero.

        `ended` holds the modes that have just ended, by contact: a slip at zero, or a stick at its bound.
        """
        n, modes = self.masses.size, []
        for i, c in enumerate(self.contacts):
            belt, u = c.belt(piece), y[n:]
            w = float(c.row @ u) - belt
            if i not in ended and abs(w) > _ZERO * (float(np.abs(c.row) @ np.abs(u)) + abs(belt)):
                modes.append(1 if w > 0 else -1)
                continue
            inertia = c.row / self.masses
            y[n:] -= inertia * (w / float(inertia @ c.row))
            needed, bound = self._needed(c, self.force(y, t, piece, memory)), c.load(piece) * c.static
            sticks = abs(needed) <= bound and ended.get(i) != 0
            modes.append(0 if sticks else (-1 if needed > 0 else 1))
        return modes

    def _in_mode(
        self, y: State, t: float, end: float, piece: float, memory: Mapping[str, float], modes: Sequence[int]
    ) -> tuple[State, float, list[int]]:
        """Return state and time of the first change of a mode, or of the end, and the contacts whose mode ended."""
        n = self.masses.size

        def rate(time: float, x: State) -> np.ndarray:
            f = self.force(x, time, piece, memory)
            if not np.all(np.isfinite(f)):  # SciPy would look for a step length without end
                raise NoAnswer(f"forces are not finite at t = {time:g}")
            total = f.copy()
            for c, m in zip(self.contacts, modes, strict=True):
                w = float(c.row @ x[n:]) - c.belt(piece)
                pull = -m * c.load(piece) * c.kinetic(max(m * w, 0.0)) if m else self._needed(c, f)
                total += c.row * pull
            return np.concatenate([x[n:], total / self.masses])

        def ends(i: int) -> Callable[[float, State], float]:
            c, m = self.contacts[i], modes[i]

            def left(time: float, x: State) -> float:
                if m:
                    return m * (float(c.row @ x[n:]) - c.belt(piece))
                return c.load(piece) * c.static - abs(self._needed(c, self.force(x, time, piece, memory)))

            left.terminal, left.direction = True, -1.0  # type: ignore[attr-defined]
            return left

        guards = [ends(i) for i in range(len(modes))]
        found = solve_ivp(
            rate, (t, end), y, "DOP853", rtol=_TOLERANCE, atol=1e-14, max_step=self.longest, events=guards or None
        )
        if not found.success or not np.all(np.isfinite(found.y[:, -1])):
            raise NoAnswer(f"no step beyond t = {found.t[-1]:g}")
        if found.status != 1:
            return found.y[:, -1], end, []
        hit = [i for i, times in enumerate(found.t_events) if len(times)]
        after = np.array(found.y_events[hit[0]][-1])
        return after, float(found.t_events[hit[0]][-1]), hit


def stairs(begin: float, jumps: Sequence[tuple[float, float]]) -> Callable[[float], float]:
    """Return a function that starts at a value and changes by some amounts at some times."""
    return lambda t: begin + math.fsum(size for time, size in jumps if t >= time)
