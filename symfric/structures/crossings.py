"""Where eigenvalues cross the imaginary axis away from zero: all of a small structure, over a range of mu.

The state matrix ``A0 + mu A1`` is linear in mu. With the left and right eigenvectors at one mu the matrix
``Phi = Y^H A1 X`` gives the derivatives of all eigenvalues (its diagonal), and ``h sqrt|Phi_ij Phi_ji|`` how far two of
them can push each other over a step h (Kato, Perturbation Theory for Linear Operators, II.2). A step is halved until
every eigenvalue on it is the cubic through its ends, to a part of its distance from the axis; so growth that begins and
ends within a step of the first grid is found, unless these estimates are wrong.

Without damping eigenvalues lie on the axis, and a pair leaves it by merging. Mean and discriminant ``(v_1 - v_2)^2`` of
the pair are smooth there, while the eigenvalues have a branch point (Seyranian and Mailybaev, Multiparameter Stability
Theory, 2003, chapter 2).
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as sla
from scipy.optimize import linear_sum_assignment
from scipy.sparse.csgraph import connected_components

from symfric.search import ROUNDING, zero
from symfric.structures.structure import Structure
from symfric.structures.symmetry import can_decay, is_symmetric

_SHORT = 1e-10  # of the range: a step that is not halved any more
_MOST = 6000  # eigenvalue problems in one search
_FLOOR = 1e-13  # of the largest eigenvalue: growth that is rounding
_REAL = 1e-7  # of the largest eigenvalue: distance from the real axis that is rounding of a double one
_APART = 2.0  # of their influence on each other: distance at which two eigenvalues are smooth each for itself
_SURE = 2.0  # of the error estimate: distance from the axis
_BENT = 0.02  # of the change on a step: what may be added to the error estimate, which can vanish by accident
_TURNED = 1e-4  # of the largest eigenvalue: what a double zero changes by over the shortest step
_SMOOTH = 0.1  # of the change on a step: error up to which the path counts as that of one smooth eigenvalue
_SAME = 1e-6  # of the frequency: crossings closer than this at one mu are one
_BEYOND = 1e-3  # of the step: how far outside of it Newton's method may go, since the ends are only as good as rounding
_NEWTON = 12  # most steps of Newton's method for one crossing; it converges quadratically from the secant
_STEADY = 4e-16, 1e-15  # last step relative to the range, and growth relative to the size, that rounding leaves
_LOW = 1e-7  # of the largest frequency: what is slower is divergence


class Crossing(NamedTuple):
    """One crossing of the axis.

    Attributes
    ----------
    mu, omega : float
        omega > 0.
    begins : bool
        Whether growth begins, and does not end.
    merging : bool
        Whether two modes merge, without damping.
    """

    mu: float
    omega: float
    begins: bool
    merging: bool


class _Node(NamedTuple):
    mu: float
    values: np.ndarray
    change: np.ndarray  # derivatives by mu
    push: np.ndarray  # sqrt|Phi_ij Phi_ji|


@dataclass(frozen=True, eq=False)
class _Family:
    """Matrices ``A0 + mu A1`` whose eigenvalues are lambda, or without damping ``-lambda^2`` or ``lambda/i``."""

    A0: np.ndarray
    A1: np.ndarray
    kind: str

    def node(self, mu: float) -> _Node:
        values, left, right = sla.eig(self.A0 + mu * self.A1, left=True, right=True)
        own = np.sum(left.conj() * right, axis=0)
        own = np.where(np.abs(own) > 1e-300, own, 1e-300)
        inside = left.conj().T @ (self.A1 @ right) / own[:, None]
        push = np.sqrt(np.abs(inside * inside.T))
        np.fill_diagonal(push, 0.0)
        turn = -1j if self.kind == "gyroscopic" else 1.0
        return _Node(mu, turn * values, turn * np.diag(inside), push)

    def omega(self, value: float) -> float:
        return float(np.sqrt(max(value, 0.0))) if self.kind == "squares" else float(value)


def crossings(structure: Structure, low: float, high: float, steps: int) -> list[Crossing]:
    """Return where eigenvalues cross the imaginary axis away from zero, by increasing mu.

    Parameters
    ----------
    structure : Structure
        With a friction matrix; its eigenvalue problems are solved as dense ones.
    low, high : float
        Range of mu, its ends included.
    steps : int
        Steps to begin with.
    """
    all_crossings: list[Crossing] = []
    for part in _parts(structure):
        family = _family_of(part)
        all_crossings += [] if family is None else _Search(family, low, high).over(steps)
    return sorted(all_crossings)


def _parts(s: Structure) -> list[Structure]:
    """Return the parts of a structure that no entry of its matrices connects; those without friction are left out."""
    links = sum((abs(e) for e in (s.K, s.C, s.friction) if e is not None), abs(s.M))
    number, label = connected_components(links, directed=False)
    if number == 1:
        return [s]
    parts = []
    for k in range(number):
        rows = np.flatnonzero(label == k)
        M, K, C, F = (None if e is None else e[rows][:, rows] for e in (s.M, s.K, s.C, s.friction))
        if F is not None and F.nnz:
            parts.append(Structure(M, K, C, F))
    return parts


def _family_of(s: Structure) -> _Family | None:
    """Return the eigenvalue problem over mu; None where no pair can leave the axis: nothing but symmetric stiffness."""
    root = np.linalg.cholesky(s.M.toarray())

    def over_mass(matrix: Any) -> np.ndarray:
        return np.asarray(
            sla.solve_triangular(root, sla.solve_triangular(root, matrix.toarray(), lower=True).T, lower=True).T
        )

    K, F = over_mass(s.K), over_mass(s.friction)
    if s.C is None:
        return None if is_symmetric(s.friction) else _Family(K, F, "squares")
    C, one, n = over_mass(s.C), np.eye(s.n), s.n
    unit = float(np.sqrt(np.linalg.norm(K, 2))) or float(np.linalg.norm(C, 2))  # of velocities
    A0 = np.block([[np.zeros((n, n)), unit * one], [-K / unit, -C]])
    A1 = np.zeros((2 * n, 2 * n))
    A1[n:, :n] = -F / unit
    return _Family(A0, A1, "damped" if can_decay(s) else "gyroscopic")


class _Search:
    """Halving of steps until each holds a crossing or none."""

    def __init__(self, family: _Family, low: float, high: float):
        self.family, self.low, self.high, self.left = family, low, high, _MOST
        self.crossings: list[Crossing] = []
        self.size = 0.0
        self.step = self._damped if family.kind == "damped" else self._neutral

    def over(self, steps: int) -> list[Crossing]:
        nodes = [self._node(mu) for mu in np.linspace(self.low, self.high, steps + 1).tolist()]
        self.size = max(float(np.max(np.abs(e.values))) for e in nodes) or 1.0
        todo = list(pairwise(nodes))[::-1]
        while todo:
            a, b = todo.pop()
            known = len(self.crossings)
            if self.step(*_matched(a, b), self.left <= 0 or b.mu - a.mu <= _SHORT * (self.high - self.low)):
                continue
            del self.crossings[known:]
            middle = self._node(0.5 * (a.mu + b.mu))
            todo += [(middle, b), (a, middle)]
        return self._distinct()

    def _node(self, mu: float) -> _Node:
        self.left -= 1
        return self.family.node(mu)

    def _distinct(self) -> list[Crossing]:
        """Return the crossings, each once: two steps may both find one at their common end."""
        kept: list[Crossing] = []
        width = 2 * _SHORT * (self.high - self.low)
        slow = _LOW * self.family.omega(self.size)
        for new in sorted(self.crossings):
            if new.omega > slow and not any(
                new.begins == e.begins and new.mu - e.mu <= width and abs(new.omega - e.omega) <= _SAME * e.omega
                for e in kept
            ):
                kept.append(new)
        return kept

    # With damping: the real part of an eigenvalue

    def _damped(self, a: _Node, b: _Node, last: bool) -> bool:
        """Record the crossings on a step if their number is certain; return whether it is."""
        h, floor = b.mu - a.mu, _FLOOR * self.size
        ends = a.values.real, b.values.real
        lowest, highest, turns = _cubic(*ends, h * a.change.real, h * b.change.real)
        error = np.abs((b.values - a.values).real - 0.5 * h * (a.change + b.change).real)
        near = _close(a, b)
        push = np.max(np.where(near, h * np.maximum(a.push, b.push), 0.0), axis=1)
        quiet = (np.maximum(-lowest, highest) <= floor) & (error <= floor)
        margin = _SURE * (error + push) + _BENT * (highest - lowest)
        clear = (lowest > margin) | (-highest > margin) | quiet
        clear |= (a.values.imag < 0) | ((a.values.imag == 0) & (b.values.imag == 0))
        for i in np.flatnonzero(~clear).tolist():
            before = _sign(ends[0][i], a.change[i].real, floor, -1)
            after = _sign(ends[1][i], b.change[i].real, floor, 1)
            smooth = not np.any(near[i]) and error[i] <= _SMOOTH * abs(ends[1][i] - ends[0][i])
            if before == after and not last:
                return False
            if before != after and not ((smooth and not turns[i] and self._refined(a, b, i)) or last):
                return False
            if before != after and last and not self._refined(a, b, i):
                omega = min(abs(float(e.values[i].imag)) for e in (a, b))
                if omega > _TURNED * self.size:
                    self.crossings.append(Crossing(0.5 * (a.mu + b.mu), omega, after > 0, False))
        return True

    def _refined(self, a: _Node, b: _Node, i: int) -> bool:
        """Add the crossing of eigenvalue i, by Newton's method; return whether it lies on the step."""
        rise = (b.values[i] - a.values[i]).real
        part = min(max(-a.values[i].real / rise, 0.0), 1.0) if rise else 0.5
        # start on the secant: Newton's method then stays with this eigenvalue, which the nearest value identifies
        mu, guess = a.mu + part * (b.mu - a.mu), a.values[i] + part * (b.values[i] - a.values[i])
        width = _BEYOND * (b.mu - a.mu)
        for _ in range(_NEWTON):
            node = self.family.node(mu)
            k = int(np.argmin(np.abs(node.values - guess)))
            value, change = complex(node.values[k]), complex(node.change[k])
            if not change.real:
                return False
            move = -value.real / change.real
            if not a.mu - width <= mu + move <= b.mu + width:
                return False
            mu, guess = mu + move, value + move * change
            if (
                abs(move) <= _STEADY[0] * max(abs(self.low), abs(self.high))
                or abs(value.real) <= _STEADY[1] * self.size
            ):
                break
        if abs(value.real) > 10 * _FLOOR * self.size:
            return False
        mu = float(min(max(mu, self.low), self.high))
        self.crossings.append(Crossing(mu, abs(value.imag), change.real > 0, False))
        return True

    # Without damping: the discriminant of a pair

    def _neutral(self, a: _Node, b: _Node, last: bool) -> bool:
        """Record the pairs that merge or part on a step if they are certain; return whether they are."""
        h, floor = b.mu - a.mu, (_FLOOR * self.size) ** 2
        real = [np.abs(e.values.imag) <= _REAL * self.size for e in (a, b)]
        if last:
            self._by_count(a, b, real)
            return True
        left = int(np.sum(real[0]) - np.sum(real[1])) // 2  # pairs that leave the axis
        rows, columns = np.nonzero(np.triu(_close(a, b), 1))
        # the squared difference (discriminant) is smooth where two eigenvalues merge; the eigenvalues have a root there
        first, second = ((e.values[rows] - e.values[columns]) ** 2 for e in (a, b))
        slopes = [2 * h * (e.values[rows] - e.values[columns]) * (e.change[rows] - e.change[columns]) for e in (a, b)]
        real_valued = np.maximum(np.abs(first.imag), np.abs(second.imag)) <= _SAME * (np.abs(first) + np.abs(second))
        noise = np.maximum(np.abs(first), np.abs(second)) <= floor
        lowest, highest, turns = _cubic(first.real, second.real, *(e.real for e in slopes))
        error = np.abs(second - first - 0.5 * (slopes[0] + slopes[1]))
        lone = (a.values.imag[rows] >= -_REAL * self.size) | (b.values.imag[rows] >= -_REAL * self.size)
        for k in np.flatnonzero(~noise & lone).tolist():
            if not real_valued[k]:
                return False
            if max(lowest[k], -highest[k]) > _SURE * error[k] + _BENT * (highest[k] - lowest[k]):
                continue
            start, end = first[k].real, second[k].real
            if (start >= 0) == (end >= 0) or turns[k] or error[k] > _SMOOTH * abs(end - start):
                return False
            if not self._merged(a, b, int(rows[k]), int(columns[k])):
                return False
            left -= 1 if end < start else -1
        return left == 0

    def _merged(self, a: _Node, b: _Node, i: int, j: int) -> bool:
        """Add the zero of the discriminant of a pair; return whether it was found."""
        h, scale = b.mu - a.mu, max(abs(a.values[i] - a.values[j]), abs(b.values[i] - b.values[j]))

        def pair(mu: float) -> tuple[float, float]:
            part = (mu - a.mu) / h
            one, other = ((0.5 * (v[i] + v[j]), (v[i] - v[j]) ** 2) for v in (a.values, b.values))
            centre, square = ((1 - part) * s + part * e for s, e in zip(one, other, strict=True))
            v = self.family.node(mu).values
            middle, apart = 0.5 * np.add.outer(v, v), np.subtract.outer(v, v) ** 2
            misfit = np.abs(middle - centre) / scale + np.abs(apart - square) / scale**2
            np.fill_diagonal(misfit, np.inf)
            p, q = np.unravel_index(int(np.argmin(misfit)), misfit.shape)
            return float(apart[p, q].real), float(middle[p, q].real)

        ends = pair(a.mu)[0], pair(b.mu)[0]
        if ends[0] * ends[1] > 0:
            return False
        mu = a.mu if ends[0] == 0 else b.mu if ends[1] == 0 else zero(
            lambda e: pair(e)[0], a.mu, b.mu, xtol=1e-15 * max(abs(a.mu), abs(b.mu)), rtol=ROUNDING
        )  # fmt: skip
        self._add(float(mu), pair(float(mu))[1], ends[1] < ends[0])
        return True

    def _by_count(self, a: _Node, b: _Node, real: list[np.ndarray]) -> None:
        """Add what changes the number of complex pairs over a step too short to halve."""
        change = int(np.sum(real[0]) - np.sum(real[1])) // 2
        inside, there = (b, real[1]) if change > 0 else (a, real[0])
        if change:
            v = inside.values[~there & (inside.values.imag > 0)]
            for value in v[np.argsort(v.imag)][: abs(change)]:
                self._add(0.5 * (a.mu + b.mu), float(value.real), change > 0)

    def _add(self, mu: float, middle: float, begins: bool) -> None:
        if middle > 0:
            self.crossings.append(Crossing(mu, self.family.omega(middle), bool(begins), True))


def _sign(value: float, slope: float, floor: float, side: int) -> int:
    """Return the sign of growth at an end of a step; where it is zero, the sign just outside of the step."""
    if abs(value) > floor:
        return 1 if value > 0 else -1
    return side if slope > 0 else -side


def _matched(a: _Node, b: _Node) -> tuple[_Node, _Node]:
    """Return both ends with the eigenvalues of the second in the order of the first, by values and derivatives."""
    mean = 0.5 * (b.mu - a.mu) * np.add.outer(a.change, b.change)
    misfit = np.abs(b.values[None, :] - a.values[:, None] - mean)
    order = linear_sum_assignment(misfit)[1]
    return a, _Node(b.mu, b.values[order], b.change[order], b.push[np.ix_(order, order)])


def _cubic(
    first: np.ndarray, second: np.ndarray, rise: np.ndarray, end_rise: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return least and largest value of real cubics given by values and slopes at both ends, and whether they turn."""
    whole = second - first
    cube, square = rise + end_rise - 2 * whole, 3 * whole - 2 * rise - end_rise
    root = np.sqrt(np.maximum(square**2 - 3 * cube * rise, 0.0))
    lean = -(square + np.where(square < 0, -root, root))
    with np.errstate(divide="ignore", invalid="ignore"):
        places = [lean / (3 * cube), rise / lean]
    lowest, highest, turns = np.minimum(first, second), np.maximum(first, second), np.zeros(np.shape(first), bool)
    for place in places:
        inside = (place > 0) & (place < 1) & (root > 0)
        s = np.where(inside, place, 0.0)
        value = first + s * (rise + s * (square + s * cube))
        lowest, highest, turns = np.minimum(lowest, value), np.maximum(highest, value), turns | inside
    return lowest, highest, turns


def _close(a: _Node, b: _Node) -> np.ndarray:
    """Return which pairs come so near to each other on a step that they may not be smooth each for itself."""
    start, way = np.subtract.outer(a.values, a.values), np.subtract.outer(b.values, b.values)
    way = way - start
    length = np.abs(way) ** 2
    part = np.clip(-(start.conj() * way).real / np.where(length > 0, length, 1.0), 0.0, 1.0)
    push = (b.mu - a.mu) * np.maximum(a.push, b.push)
    return np.asarray((np.abs(start + part * way) < _APART * push) & (push > 0))
