"""Constraint forces of sticking contacts with dependent slips, by trial of all distributions.

Independent of the compiled rule of the route `taylor`, see `symfric.solve.loop.modes.sticking_basis`, which it checks.
"""

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from symfric.lower.automaton import Automaton
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS, HOLDS, REDUNDANT, SHARES
from symfric.lower.mode_layout import backward, forward

_BEYOND = 1e-6  # relative excess over a bound up to which a force is tried
_NOTHING = 1e-9  # slip relative to the largest that counts as zero


@dataclass(frozen=True)
class Rest:
    """Contacts at rest at one time, with their slip rows.

    Attributes
    ----------
    automaton : Automaton
    rows, columns : ndarray, shape (n_c, n_u)
        ``J`` and ``(M^-1 J^T)^T``.
    pull : ndarray, shape (n_c,)
        The slip accelerations that static friction can cause.
    guards : callable
        Function of a mode.
    """

    automaton: Automaton
    rows: np.ndarray
    columns: np.ndarray
    pull: np.ndarray
    guards: Callable[[np.ndarray], np.ndarray]

    def marked(self, m: np.ndarray, first: tuple[int, ...] = ()) -> np.ndarray:
        """Mark the sticking contacts that depend on those of `first`, then on the strongest; return the mode."""
        sticking, m = np.flatnonzero(m[: len(self.rows)]), m.copy()
        rows, columns = self.rows.copy(), self.columns.copy()
        sizes, own, groups = np.sum(rows * columns, axis=1), list[int](), self.automaton.parallels
        for i in sorted(sticking, key=lambda i: (i not in first, -self.pull[i])):
            for j in own * 2:  # twice is enough for orthogonality, see Parlett, The Symmetric Eigenvalue Problem, 6.9
                part = (rows[j] @ columns[i]) / (rows[j] @ columns[j])
                rows[i], columns[i] = rows[i] - part * rows[j], columns[i] - part * columns[j]
            if rows[i] @ columns[i] > REDUNDANT * sizes[i]:
                own.append(int(i))
                m[i] = HOLDS
            else:
                m[i] = SHARES if any(groups[j] == groups[i] for j in own) else FOLLOWS
        return m

    def least_difference(self, still: list[int]) -> float:
        """Return the least relative distance of a slip from the combinations of zero slips, dependent slips excepted.

        The least for any contact; infinite if there is none.
        """
        own, least = list[int](), np.inf
        rows, columns = self.rows.copy(), self.columns.copy()
        sizes = np.sum(rows * columns, axis=1)
        for i in [*still, *(i for i in range(len(rows)) if i not in still)]:
            for j in own * 2:
                part = (rows[j] @ columns[i]) / (rows[j] @ columns[j])
                rows[i], columns[i] = rows[i] - part * rows[j], columns[i] - part * columns[j]
            left = (rows[i] @ columns[i]) / sizes[i] if sizes[i] > 0 else 0.0
            if left > REDUNDANT:
                least = min(least, np.sqrt(left)) if own else least
                if i in still:
                    own.append(i)
        return least

    def distributions(self, m: np.ndarray) -> Iterator[np.ndarray]:
        """Yield the mode with all admissible marks of its sticking contacts, those far from bounds first.

        Any independent contacts may have their own constraints, while the others have zero force or their bounds.
        """
        plain, n_c = self.marked(m), len(self.rows)
        if FOLLOWS not in plain[:n_c]:
            yield plain
            return
        firsts, total, bounds = self._needed(plain)
        rank, candidates = int(np.sum(plain[:n_c] == HOLDS)), []
        for own in itertools.combinations(firsts, rank):
            marked = self.marked(m, own)
            if any(marked[i] != HOLDS for i in own):
                continue
            others = [i for i in firsts if i not in own]
            for ways in itertools.product((0, -1, 1), repeat=len(others)):
                given = np.array([-way * bounds[i] for i, way in zip(others, ways, strict=True)])
                held = np.linalg.lstsq(self.rows[list(own)].T, total - self.rows[others].T @ given, rcond=None)[0]
                most = bounds[list(own)]
                room = np.min((most - np.abs(held)) / np.maximum(most + np.abs(held), np.finfo(float).tiny))
                if room >= -_BEYOND or self.automaton.at_edges:  # at edges the bounds depend on the direction
                    candidates.append((room, self._with_given(marked, others, ways)))
        yield from (marked for _, marked in sorted(candidates, key=lambda e: -e[0]))

    def most_exceeded(
        self,
        m: np.ndarray,
        still: list[int],
        before: tuple[int, ...],
        slip_rates: Callable[[np.ndarray], np.ndarray],
        little: np.ndarray,
    ) -> Iterator[np.ndarray]:
        """Yield trial modes in which only contacts slip that must; none if all slips are independent.

        Where slips that depend on each other move apart, release those that do not follow from the ones `before`. While
        no forces hold the others, release those that slip where all bounds would have to be enlarged the most. Catch
        again what would slip against its direction.
        """
        n_c, layout, m = len(self.rows), self.automaton.layout, m.copy()
        if FOLLOWS not in self.marked(m)[:n_c]:
            return
        for _ in range(4 * n_c):
            yield m
            plain = self.marked(m, before)
            apart = np.where(plain[:n_c] == FOLLOWS, slip_rates(plain), 0.0)
            slips = np.zeros(n_c)
            if np.any(np.abs(apart) > little):
                worst = int(np.argmax(np.abs(apart) / (np.abs(apart) + self.pull)))
                slips[worst] = np.sign(apart[worst])
            elif HOLDS in plain[:n_c]:
                slips = self._must_slip(plain)
            if np.any(slips):
                m = m.copy()
                m[layout.sticking] = np.where(slips, 0, m[layout.sticking])
                m[layout.directions] = np.where(slips, slips, m[layout.directions])
                continue
            rates = [
                m[layout.direction(i)] * slip_rates(plain)[i] for i in still if not m[i] and self.automaton.sticks[i]
            ]
            wrong = [i for i in still if not m[i] and self.automaton.sticks[i]]
            if not wrong or min(rates) >= 0:
                return
            m = m.copy()
            m[wrong[int(np.argmin(rates))]] = 1.0

    def idle(self, m: np.ndarray, i: int) -> bool:
        """Whether the slip of contact i cannot start while the others stick, unless their surfaces part."""
        trial, sticking = m.copy(), np.flatnonzero(m[: len(self.rows)])
        trial[i] = FOLLOWS
        return any(self.automaton.parallels[i] == self.automaton.parallels[j] for j in sticking) or (
            bool(self.automaton.dependent[i]) and self.marked(trial, tuple(sticking))[i] == FOLLOWS
        )

    def with_followers(self, m: np.ndarray, still: list[int]) -> np.ndarray:
        """Return the mode in which contacts of `still` stick too whose slips cannot start while the others stick."""
        m = m.copy()
        for i in (i for i in still if not m[i] and self.automaton.sticks[i]):
            if self.idle(m, i):
                m[i] = 1.0
        return m

    def _needed(self, plain: np.ndarray) -> tuple[list[int], np.ndarray, np.ndarray]:
        """Return the first sticking contact of each parallel group, ``J^T lambda``, and the bounds of the groups."""
        n_c, groups = len(self.rows), self.automaton.parallels
        firsts, bounds, total = list[int](), np.zeros(n_c), np.zeros(self.rows.shape[1])
        guards = self.guards(plain)
        for i in map(int, np.flatnonzero(plain[:n_c])):
            first = next((j for j in firsts if groups[j] == groups[i]), None)
            if first is None:
                firsts.append(i)
                first = i
            if plain[i] in (HOLDS, SHARES):
                total += 0.5 * (guards[forward(i)] - guards[backward(i)]) * self.rows[i]
            alone = plain.copy()
            alone[:n_c] = 0.0
            alone[i] = HOLDS
            part = abs(self.rows[i] @ self.columns[first]) / (self.rows[first] @ self.columns[first])
            bounds[first] += 0.5 * part * np.sum(self.guards(alone)[[backward(i), forward(i)]])
        return firsts, total, bounds

    def _with_given(self, marked: np.ndarray, others: list[int], ways: tuple[int, ...]) -> np.ndarray:
        """Return the mode in which the groups of `others` have zero force, or their bounds against slip in `ways`."""
        m, n_c, groups = marked.copy(), len(self.rows), self.automaton.parallels
        for first, way in zip(others, ways, strict=True):
            for i in (i for i in range(n_c) if way and m[i] == FOLLOWS and groups[i] == groups[first]):
                m[i], m[self.automaton.layout.direction(i)] = (
                    AT_BOUND,
                    way * np.sign(self.rows[i] @ self.columns[first]),
                )
        return m

    def _must_slip(self, plain: np.ndarray) -> np.ndarray:
        """Return the directions in which sticking contacts must slip, (n_c,); zeros if forces can hold them."""
        n_c = len(self.rows)
        firsts, total, bounds = self._needed(plain)
        J, most = self.rows[firsts], bounds[firsts]
        own = self.rows[np.flatnonzero(plain[:n_c] == HOLDS)]
        basis = np.linalg.qr(own.T)[0]
        cost = np.append(np.zeros(len(firsts)), 1.0)
        limits = np.block([[np.eye(len(firsts)), -most[:, None]], [-np.eye(len(firsts)), -most[:, None]]])
        equal = np.column_stack([basis.T @ J.T, np.zeros(basis.shape[1])])
        from scipy import optimize  # slow to import, and only here needed

        optimum = optimize.linprog(
            cost, limits, np.zeros(2 * len(firsts)), equal, basis.T @ total, [(None, None)] * len(firsts) + [(0, None)]
        )
        if optimum.status != 0 or optimum.fun <= 1 - _BEYOND:
            return np.zeros(n_c)
        slips = -self.rows @ (basis @ optimum.eqlin.marginals)
        sizes = np.linalg.norm(self.rows, axis=1)
        slips[(np.abs(slips) <= _NOTHING * np.max(np.abs(slips) / sizes) * sizes) | (plain[:n_c] == 0)] = 0.0
        return np.sign(slips)
