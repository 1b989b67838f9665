"""Accelerations and friction of one mode, and mode selection by enumeration."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric_evidence.event_reference.equations import Equations

Motion = tuple[np.ndarray, np.ndarray, list[np.ndarray]]  # accelerations, friction forces, terms of the equations
EPS = 2.2e-16
ROUNDING = 64 * EPS  # rounding error relative to the forces
TIE = 1e-11  # force relative to the others below which the sign is decided by the motion a moment later
_RANK = 1e-13  # singular value of slip rows relative to the largest that counts as zero
_ROUNDING = 8 * 2.0**-52  # slip relative to the sum of its terms that counts as zero
LEADS = (1e-7, 1e-5, 1e-3)  # times after which a tie is evaluated, relative to the time scale


@dataclass(frozen=True)
class SmoothMode:
    """One smooth piece of the equations.

    Attributes
    ----------
    modes : tuple of int
        Of every contact: -1, 0, 1.
    signs : tuple of int
        Of every kink.
    resting : tuple of bool
        Kinks that stay at zero in this mode.
    pushes : tuple of float
        Where kinks rest: the sign of the friction of every sticking contact, which says to which side the body would
        go; zero for the others.
    """

    modes: tuple[int, ...]
    signs: tuple[int, ...]
    resting: tuple[bool, ...] = ()
    pushes: tuple[float, ...] = ()


class Mechanics:
    """The equations of motion with the numbers of one run."""

    def __init__(self, equations: Equations, values: tuple[float, ...], time_scale: float):
        self.e, self.values, self.time_scale = equations, values, time_scale
        self.signals: tuple[float, ...] = ()  # value at `since` and slope of every sampled input
        self.slopes: tuple[float, ...] = ()
        self.since = 0.0

    def arguments(self, t: Any, y: np.ndarray, mode: SmoothMode) -> tuple[Any, ...]:
        """Return the arguments of the functions; for arrays of times, `y` has one column for each."""
        inputs = [a + b * (t - self.since) for a, b in zip(self.signals, self.slopes, strict=True)]
        return (t, *y, *self.values, *inputs, *self.slopes, *mode.modes, *mode.signs)

    def parts(self, t: float, y: np.ndarray, mode: SmoothMode) -> list[np.ndarray]:
        """Return mass, force, rates, rows, drifts, kinetic friction and bounds of sticking as arrays."""
        e = self.e
        parts = np.split(np.array(e.core(*self.arguments(t, y, mode)), dtype=float), e.cuts[:-1])
        parts[0], parts[3] = parts[0].reshape(e.n, e.n), parts[3].reshape(e.n_c, e.n)
        return parts

    def look(self, t: float, y: np.ndarray, modes: tuple[int, ...]) -> tuple[np.ndarray, tuple[int, ...]]:
        """Return slips and guards of the kinks, and the signs of these, which may depend on each other."""
        e = self.e
        signs = (1,) * e.n_k
        watched = np.zeros(e.n_c + e.n_k)
        for _ in range(e.n_k + 1):
            watched = np.array(e.watched(*self.arguments(t, y, SmoothMode(modes, signs))), dtype=float)
            seen = tuple(1 if g > 0 else -1 for g in watched[e.n_c :])
            if seen == signs:
                break
            signs = seen
        return watched, signs

    def rate(self, t: float, y: np.ndarray, mode: SmoothMode) -> np.ndarray:
        """Return dy/dt."""
        e = self.e
        if e.n == 1 and e.n_c <= 1 and not any(mode.modes) and not e.n_c:
            v = e.core(*self.arguments(t, y, mode))
            return np.array([y[1], v[1] / v[0], *v[2 : 2 + e.n_z]])
        if e.n == 1 and e.n_c == 1:
            v = e.core(*self.arguments(t, y, mode))
            row, drift, friction = v[2 + e.n_z : 5 + e.n_z]
            a = (v[1] + row * friction) / v[0] if mode.modes[0] else -drift / row
            return np.array([y[1], a, *v[2 : 2 + e.n_z]])
        a, _, parts = self.motion(t, y, mode)
        return np.concatenate([y[e.n : 2 * e.n], a, parts[2]])

    def motion(self, t: float, y: np.ndarray, mode: SmoothMode) -> Motion:
        """Return accelerations, friction forces of every contact, and the terms of the equations."""
        parts = self.parts(t, y, mode)
        mass, force, _, rows, drift, friction, _ = parts
        stuck = [i for i, m in enumerate(mode.modes) if m == 0]
        push = friction.copy()
        push[stuck] = 0.0
        loaded = force + rows.T @ push
        if not stuck:
            return np.linalg.solve(mass, loaded), push, parts
        held, drifts = reduced(rows[stuck], drift[stuck])
        n, k = len(force), len(held)
        system = np.zeros((n + k, n + k))
        system[:n, :n], system[:n, n:], system[n:, :n] = mass, -held.T, held
        solution = np.linalg.solve(system, np.concatenate([loaded, -drifts]))
        push[stuck] = np.linalg.lstsq(rows[stuck].T, held.T @ solution[n:], rcond=_RANK)[0]
        return solution[:n], push, parts

    def excess(self, t: float, y: np.ndarray, mode: SmoothMode, motion: Motion | None = None) -> np.ndarray:
        """Return the relative excess of every sticking contact over its bound, <= 0 where it holds.

        Contacts with dependent rows share the force; theirs is that of all, see `least_excess`.
        """
        a, push, parts = self.motion(t, y, mode) if motion is None else motion
        mass, force, _, rows, drift, _, bounds = parts
        result = np.abs(push) - bounds
        stuck, slipping = ([i for i, m in enumerate(mode.modes) if (m == 0) == still] for still in (True, False))
        result[slipping] = -np.inf
        held = rows[stuck]
        if len(stuck) > 1 and np.linalg.matrix_rank(held, tol=_RANK) < len(stuck):
            left = held @ a + drift[stuck]
            reach = np.abs(np.linalg.inv(mass)) @ (np.abs(force) + np.abs(rows.T) @ np.abs(push))
            if np.max(np.abs(left)) > 1e-9 * (np.max(np.abs(held) @ reach) + np.max(np.abs(drift[stuck]))):
                result[stuck] = np.inf  # their slips cannot all stay zero
            else:
                total = mass @ a - force - rows[slipping].T @ push[slipping]
                result[stuck] = shared_excess(held, total, bounds[stuck])
        return result


def reduced(rows: np.ndarray, drifts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return normalised independent rows equivalent to the given rows, and their drifts.

    By elimination, which leaves the small difference of nearly parallel rows exact; their own equations would have
    the square of it as a pivot.
    """
    size = np.max(np.abs(rows), axis=1)
    size[size == 0] = 1.0
    left, rest = rows / size[:, None], drifts / size
    independent, values = [], []
    while left.size and np.max(np.abs(left)) > _RANK:
        i, j = np.unravel_index(np.argmax(np.abs(left)), left.shape)
        row, value = left[i] / left[i, j], rest[i] / left[i, j]
        independent.append(row)
        values.append(value)
        left, rest = left - np.outer(left[:, j], row), rest - left[:, j] * value
        left[:, j] = 0.0
    return np.array(independent).reshape(-1, rows.shape[1]), np.array(values)


def shared_excess(rows: np.ndarray, total: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Return by how much each of the contacts that share a force exceeds its bound.

    Contacts without load carry nothing where the others can.
    """
    result = np.full(len(rows), -np.inf)
    loaded = bounds > 0
    if not np.any(loaded):
        loaded[:] = True
    elif not np.all(loaded):
        left = rows[loaded].T @ np.linalg.lstsq(rows[loaded].T, total, rcond=_RANK)[0] - total
        if np.max(np.abs(left)) > 1e-12 * np.max(np.abs(total)):
            loaded[:] = True
    result[loaded] = least_excess(rows[loaded], total, bounds[loaded])
    return result


def least_excess(rows: np.ndarray, total: np.ndarray, bounds: np.ndarray) -> float:
    """Return by how much forces whose sum is `total` exceed the sum of their bounds, if all exceed them in proportion.

    The forces are one solution and any combination of those that cancel, at the least possible largest ratio of a force
    and its bound; it lies where as many of the planes +-force - ratio bound meet as there are unknowns. Were it the
    excess itself, a small bound would leave nothing to watch: its contact is never further away than this bound.
    """
    _, sizes, right = np.linalg.svd(rows.T)
    rank = int(np.sum(sizes > _RANK * sizes[0]))
    one, free = np.linalg.lstsq(rows.T, total, rcond=_RANK)[0], right[rank:].T
    whole = float(np.sum(bounds))
    part = bounds / whole if whole > 0 else np.full(len(one), 1 / len(one))
    planes = np.vstack([np.hstack([free, -part[:, None]]), np.hstack([-free, -part[:, None]])])
    levels = np.concatenate([-one, one])  # planes @ (combination, sum of the bounds that are needed) <= levels
    corners = np.array(list(itertools.combinations(range(len(levels)), free.shape[1] + 1)))
    parts = planes[corners]
    regular = np.abs(np.linalg.det(parts)) > 1e-12 * np.prod(np.linalg.norm(parts, axis=2), axis=1)
    vertices = np.linalg.solve(parts[regular], levels[corners[regular]][..., None])[..., 0]
    size = np.max(np.abs(levels)) + np.abs(vertices[:, -1:])
    inside = np.all(vertices @ planes.T <= levels + 1e-13 * size, axis=1)
    return float(np.min(vertices[inside, -1], initial=np.inf)) - whole


class Choice:
    """Mode selection at a state with contacts at zero slip, by trying every combination."""

    def __init__(self, mechanics: Mechanics, preference: int = 0):
        self.m, self.preference = mechanics, preference
        self._scales = np.zeros(mechanics.e.n + mechanics.e.n_c + mechanics.e.n_k)
        self.alternatives = False  # whether several combinations were admissible that move differently

    def at(self, t: float, y: np.ndarray, at_zero: Sequence[bool], small: np.ndarray) -> SmoothMode | None:
        """Return the admissible mode in which most contacts stick; None if there is none.

        Where contacts reach what they can hold, those within their bounds go on sticking first: less friction of theirs
        once they slip would also admit that they slip instead of others.

        Parameters
        ----------
        at_zero : sequence of bool
            Slips, then guards of kinks, known to be zero.
        small : ndarray
            Size of each of them that counts as zero.
        """
        e = self.m.e
        watched, signs = self.m.look(t, y, (1,) * e.n_c)
        slips = watched[: e.n_c]
        self.see(t, y, SmoothMode((1,) * e.n_c, signs))
        scales = self._scales
        least = np.maximum(small[: e.n_c], _ROUNDING * scales[e.n : e.n + e.n_c])
        rest = [bool(z) or abs(w) <= limit for z, w, limit in zip(at_zero[: e.n_c], slips, least, strict=False)]
        still = [(-1, 1) if remembers else (0, -1, 1) for remembers in e.remembers]
        options = [s if r else (int(np.sign(w)),) for r, w, s in zip(rest, slips, still, strict=True)]
        candidates = [
            (modes, signs, edge)
            for modes in itertools.product(*options)
            for signs, edge in self._sides(t, y, modes, at_zero[e.n_c :], small[e.n_c :])
        ]
        order, spared = -1 if self.preference else 1, self._spared(t, y, at_zero, slips, signs)

        def rank(modes: tuple[int, ...]) -> tuple[int, int]:
            return sum(modes[i] != 0 for i in spared), -modes.count(0)

        candidates = sorted(candidates[::order], key=lambda c: rank(c[0]))
        accepted: list[tuple[SmoothMode, np.ndarray]] = []
        for modes, signs, edge in candidates:
            if accepted and rank(modes) > rank(accepted[0][0].modes):
                break
            mode = self._admissible(t, y, SmoothMode(modes, signs), rest, edge, scales)
            if mode is not None:
                accepted.append((mode, self.m.rate(t, y, mode)))
        if not accepted:
            return None
        first = accepted[0][1]
        size = np.max(np.abs(first)) + 1e-300
        self.alternatives |= any(np.max(np.abs(other - first)) > 1e-9 * size for _, other in accepted[1:])
        return accepted[0][0]

    def zeros(self) -> np.ndarray:
        """Return the rounding error of every guard of a kink."""
        return ROUNDING * self._scales[self.m.e.n + self.m.e.n_c :]

    def _spared(
        self,
        t: float,
        y: np.ndarray,
        at_zero: Sequence[bool],
        slips: Sequence[float] | np.ndarray,
        signs: Sequence[int],
    ) -> list[int]:
        """Return the contacts within their bounds where those that stick reach the limit.

        Where they share what they hold, a larger bound of one of them would change nothing there.
        """
        n_c, remembers = self.m.e.n_c, self.m.e.remembers
        stuck = [i for i in range(n_c) if at_zero[i] and not remembers[i]]
        mode = SmoothMode(tuple(0 if i in stuck else int(np.sign(w)) for i, w in enumerate(slips)), tuple(signs))
        _, push, parts = motion = self.m.motion(t, y, mode)
        rows, bounds = parts[3][stuck], parts[6][stuck]
        if len(stuck) < 2:
            return []
        if np.linalg.matrix_rank(rows, tol=_RANK) == len(stuck):
            excess = self.m.excess(t, y, mode, motion)[stuck]
            return [i for i, e, bound in zip(stuck, excess, bounds, strict=True) if e < -1e-9 * bound]
        total = rows.T @ push[stuck]
        size = float(np.max(np.abs(total)) + np.max(bounds))
        loaded = np.flatnonzero(bounds > 1e-6 * size)
        excess = self.m.excess(t, y, mode, motion)[stuck][loaded]
        if not loaded.size or not np.all(np.abs(excess) <= 1e-9 * size):
            return []
        larger = [np.where(np.arange(len(stuck)) == k, 1.1 * bounds, bounds) for k in loaded]
        least = [least_excess(rows, total, b) for b in larger]
        return [stuck[k] for k, e in zip(loaded, least, strict=True) if e > -0.01 * bounds[k]]

    def see(self, t: float, y: np.ndarray, mode: SmoothMode) -> None:
        """Update the largest sizes of forces, slips and guards, the scales of their zeros."""
        sizes = np.array(self.m.e.scales(*self.m.arguments(t, y, mode)), dtype=float)
        self._scales = np.maximum(self._scales, sizes)

    def _sides(
        self, t: float, y: np.ndarray, modes: tuple[int, ...], at_zero: Sequence[bool], small: np.ndarray
    ) -> Iterator[tuple[tuple[int, ...], np.ndarray]]:
        """Yield signs of all kinks, and which of them are at zero, where both signs are tried."""
        e = self.m.e
        if not e.n_k:
            yield (), np.zeros(0, dtype=bool)
            return
        watched, signs = self.m.look(t, y, modes)
        guards = watched[e.n_c :]
        edge = np.array([bool(z) or abs(g) <= s for z, g, s in zip(at_zero, guards, small, strict=True)])
        options = [(1, -1) if k else (s,) for k, s in zip(edge, signs, strict=True)]
        for choice in itertools.product(*options):
            yield choice, edge

    def _admissible(
        self, t: float, y: np.ndarray, mode: SmoothMode, rest: Sequence[bool], edge: np.ndarray, scales: np.ndarray
    ) -> SmoothMode | None:
        m, e = self.m, self.m.e
        motion = m.motion(t, y, mode)
        a, push, parts = motion
        mass, rows, drift, bounds = parts[0], parts[3], parts[4], parts[6]
        if not np.all(np.isfinite(a)):
            return None
        forces = np.max(scales[: e.n]) + np.max(np.abs(push), initial=0.0)
        inverse = np.linalg.inv(mass)
        tied = False
        excess = m.excess(t, y, mode, motion)
        for i in range(e.n_c):
            if mode.modes[i] == 0:
                if excess[i] > TIE * (forces + bounds[i]):
                    return None
                tied |= excess[i] >= -TIE * (forces + bounds[i])
            elif rest[i]:
                ahead = mode.modes[i] * float(rows[i] @ a + drift[i])
                rounding = TIE * float(np.sum(np.abs(rows[i]) @ np.abs(inverse)) * forces + np.abs(drift[i]))
                if ahead < -rounding:
                    return None
                tied |= ahead <= rounding
        resting, pushes = [False] * e.n_k, [0.0] * e.n_c
        if np.any(edge):
            slopes = np.array(e.guard_slopes(*m.arguments(t, y, mode)), dtype=float).reshape(e.n_k, -1)
            y_rate = np.concatenate([y[e.n : 2 * e.n], a, parts[2]])
            for k in np.flatnonzero(edge):
                first = slopes[k, 0] + slopes[k, 1:] @ y_rate
                size = abs(slopes[k, 0]) + np.abs(slopes[k, 1:]) @ np.abs(y_rate) + scales[e.n + e.n_c + k]
                second = float(slopes[k, 1 : 1 + e.n] @ a)
                reach = float(np.abs(slopes[k, 1 : 1 + e.n]) @ np.abs(inverse) @ np.full(e.n, forces))
                side = first if abs(first) > 1e-9 * size else second if abs(second) > TIE * reach else 0.0
                if side == 0.0:
                    side = self._side_later(t, y, mode, int(k), reach, ROUNDING * scales[e.n + e.n_c + k])
                    resting[k] = side == 0.0
                if side * mode.signs[k] < 0:
                    return None
        if any(resting):
            pushes = self._pushes(t, y, mode, forces)
            for k in np.flatnonzero(resting):  # direction in which the body would move without this friction
                away = sum(-float(slopes[k, 1 : 1 + e.n] @ inverse @ rows[i]) * pushes[i] for i in range(e.n_c))
                if away * mode.signs[k] < 0:
                    return None
        mode = SmoothMode(mode.modes, mode.signs, tuple(resting), tuple(pushes))
        if tied and not self._holds(t, y, mode, rest, scales):
            return None
        return mode

    def _side_later(self, t: float, y: np.ndarray, mode: SmoothMode, k: int, reach: float, noise: float) -> float:
        """Return the sign of a guard that starts at zero without slope and curvature; zero if it stays there.

        It starts at zero to the error of the state there, which is not the guard's sign: only its change counts.
        """

        def guard_of(t: float, y: np.ndarray) -> float:
            return float(self.m.e.watched(*self.m.arguments(t, y, mode))[self.m.e.n_c + k])

        start = guard_of(t, y)
        for lead in LEADS[1:]:
            guard = guard_of(*self._later(t, y, mode, lead)) - start
            if abs(guard) > 1e-9 * reach * (lead * self.m.time_scale) ** 2 + noise:
                return float(np.sign(guard))
        return 0.0

    def _pushes(self, t: float, y: np.ndarray, mode: SmoothMode, forces: float) -> list[float]:
        """Return the signs of the friction of sticking contacts, a moment later where it is zero."""
        pushes = [0.0] * self.m.e.n_c
        for lead in (0.0, *LEADS):
            if lead:
                t, y = self._later(t, y, mode, lead)
            push = self.m.motion(t, y, mode)[1]
            for i, m in enumerate(mode.modes):
                if m == 0 and not pushes[i] and abs(push[i]) > ROUNDING * forces:
                    pushes[i] = float(np.sign(push[i]))
        return pushes

    def _later(self, t: float, y: np.ndarray, mode: SmoothMode, lead: float) -> tuple[float, np.ndarray]:
        """Return time and state after a fraction of the time scale, by four fourth-order steps."""
        m, n = self.m, 4
        h = lead * m.time_scale / n
        for _ in range(n):
            k1 = m.rate(t, y, mode)
            k2 = m.rate(t + h / 2, y + h / 2 * k1, mode)
            k3 = m.rate(t + h / 2, y + h / 2 * k2, mode)
            k4 = m.rate(t + h, y + h * k3, mode)
            y, t = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), t + h
        return t, y

    def _holds(self, t: float, y: np.ndarray, mode: SmoothMode, rest: Sequence[bool], scales: np.ndarray) -> bool:
        """Whether the mode is still admissible a moment later, for several moments."""
        m, e = self.m, self.m.e
        now = np.array(e.watched(*m.arguments(t, y, mode)), dtype=float)
        for lead in LEADS[:2]:
            time, state = self._later(t, y, mode, lead)
            arguments = m.arguments(time, state, mode)
            slips = np.array(e.watched(*arguments), dtype=float)[: e.n_c]
            later = np.array(e.scales(*arguments), dtype=float)
            forces = np.max(np.maximum(scales[: e.n], later[: e.n]))
            excess = m.excess(time, state, mode)
            for i in range(e.n_c):
                if mode.modes[i] == 0 and excess[i] > ROUNDING * forces:
                    return False
                if mode.modes[i] and rest[i] and mode.modes[i] * (slips[i] - now[i]) < -ROUNDING * later[e.n + i]:
                    return False
        return True
