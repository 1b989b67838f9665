"""Where modes of a large structure, followed over mu, cross the imaginary axis away from zero.

With damping the real part of one eigenvalue passes zero; without, the discriminant of a pair does, also under
gyroscopic forces. Both are found by root finding on the full matrices, between values of mu at which the modes are
known. Two modes that nearly merge may be taken for each other there: `symfric.structures.axis_crossing` decides.
"""

from collections.abc import Callable, Iterator
from functools import cache, partial
from typing import Literal, NamedTuple

import numpy as np

from symfric.search import ROUNDING, Minimum, minimum_near, zero
from symfric.structures.axis_crossing import axis_crossing
from symfric.structures.complex_modes import eigenpairs
from symfric.structures.structure import Structure
from symfric.structures.symmetry import can_decay
from symfric.structures.tracking import Followed, assurance

_NEUTRAL = 1e-5  # of an eigenvalue: a real part, or of squares a difference, that a merging pair has by rounding
_ROUNDING = 8 * np.finfo(float).eps  # of the terms that cancel in an eigenvalue: growth, or decay, that is rounding
_EQUAL = 1e-9  # of the largest squared frequency: difference of two that is rounding
_BESIDE = 1e-6  # of a step of mu: how far beside it a crossing may be
_OFF = 1e-4  # relative distance of a shift from what may be an eigenvalue itself
_TURN = 0.5  # of its neighbours: least discriminant, or decay, that may hide a change of sign between the grid


class Critical(NamedTuple):
    """A value of mu at which a mode begins to grow.

    Attributes
    ----------
    mu, omega : float
        omega is 0 where the structure diverges without vibration.
    pair : (int, int)
        Rows of `Flutter.eigenvalues` of the mode that grows and of the one that it merges with, or comes nearest to.
        The same row twice for a divergence; (-1, -1) if its mode is not among those followed.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.structures.flutter(sf.structures.ziegler(), mu=(0, 4), count=2)
    >>> round(found.critical[0].mu, 6)
    2.085786
    """

    mu: float
    omega: float
    pair: tuple[int, int]

    @property
    def kind(self) -> Literal["flutter", "divergence"]:
        """Whether a complex pair crosses the imaginary axis ("flutter") or a real eigenvalue zero ("divergence")."""
        return "divergence" if self.omega == 0 else "flutter"


class FollowedSearch:
    """The search for changes of stability along followed modes."""

    def __init__(self, structure: Structure, seen: Followed):
        self.structure, self.seen, self.damped = structure, seen, can_decay(structure)
        self.size = float(np.max(np.abs(seen.values))) or 1.0

    def over(self) -> list[tuple[Critical, bool]]:
        """Return where growth begins (True) and where it ends."""
        return self._damped_changes() if self.damped else self._undamped_changes()

    # With damping: the real part of one eigenvalue

    def _damped_changes(self) -> list[tuple[Critical, bool]]:
        mu, values, changes = self.seen.mu, self.seen.values, []
        floors = np.array([self._floors(k) for k in range(mu.size)]).T
        growing = values.real > floors
        for i, row in enumerate(values):
            growth = row.real
            for k in range(mu.size - 1):
                if growing[i, k] != growing[i, k + 1]:
                    floor = max(floors[i, k], floors[i, k + 1])
                    changes += self._crossing(i, k, mu[k], mu[k + 1], growing[i, k + 1], floor)
            for k in range(1, mu.size - 1):
                a, b, c = growth[k - 1 : k + 2]
                if b < 0 and a < b > c and b > _TURN * min(a, c) and min(a, c) < -floors[i, k]:
                    changes += self._hidden(i, k, floors[i, k])
        for i, j, k in self._near_pairs(growing):
            floor = max(floors[i, k], floors[j, k])
            place = self._least(i, j, k).place
            growth_of = partial(self._growth, i, j, k)
            if growth_of(place) > floor:
                for low, high, begins in ((mu[k - 1], place, True), (place, mu[k + 1], False)):
                    root = _passage(growth_of, low, high, floor)
                    if root is not None:
                        omega = float(np.mean(np.sqrt(self._pair(i, j, k, root)).real))
                        changes += self._sharpened(root, 1j * omega, (low, high), (min(i, j), max(i, j)), begins)
        return changes

    def _floors(self, k: int) -> np.ndarray:
        """Return what growth the modes at a grid point may have by rounding alone, shape (count,)."""
        pencil, sizes = self.structure.pencil(float(self.seen.mu[k])), np.abs(self.seen.shapes[k])
        assert pencil.C is not None  # only asked for with damping
        values = np.maximum(np.abs(self.seen.values[:, k]), 1e-8 * self.size)
        strain, loss, mass = (np.sum(sizes * (abs(e) @ sizes), axis=0) for e in (pencil.A, pencil.C, pencil.M))
        return np.asarray(_ROUNDING * ((strain / values + loss) / mass + values))

    def _value(self, i: int, k: int, mu: float) -> complex:
        """Return eigenvalue i near grid point k at another mu: the one of the most similar shape among the nearest."""
        at, values = self.seen.mu, self.seen.values
        side = min(k + 1, at.size - 1) if mu >= at[k] else max(k - 1, 0)
        part = 0.0 if at[side] == at[k] else (mu - at[k]) / (at[side] - at[k])
        guess = values[i, k] + part * (values[i, side] - values[i, k])
        new, shapes = eigenpairs(self.structure.pencil(mu), min(4, self.structure.n), guess)
        known = np.column_stack([self.seen.shapes[k][:, i], self.seen.shapes[side][:, i]])
        like = np.max(assurance(self.structure.M, known, shapes), axis=0)
        spread = max(float(np.max(np.abs(new - guess))), 1e-300)
        return complex(new[np.argmax(like - 0.5 * np.abs(new - guess) / spread)])

    def _crossing(
        self, i: int, k: int, low: float, high: float, begins: bool, floor: float
    ) -> list[tuple[Critical, bool]]:
        """Return where mode i crosses the axis between two values of mu."""
        root = _passage(lambda e: self._value(i, k, e).real, low, high, floor)
        root = 0.5 * (low + high) if root is None else root
        value = self._value(i, k, root)
        if value.imag <= _NEUTRAL * self.size:
            return []  # divergence
        others = np.abs(self.seen.values[:, k].imag - value.imag)
        others[i] = np.inf
        partner = int(np.argmin(others)) if others.size > 1 else i
        return self._sharpened(root, value, (low, high), (i, partner), begins)

    def _sharpened(
        self, mu: float, value: complex, span: tuple[float, float], modes: tuple[int, int], begins: bool
    ) -> list[tuple[Critical, bool]]:
        """Return the crossing next to an eigenvalue within these values of mu, if it is of the kind that was seen."""
        shape = eigenpairs(self.structure.pencil(mu), 1, value * (1 + _OFF))[1][:, 0]
        slack = _BESIDE * (span[1] - span[0])
        low, high = max(span[0] - slack, self.seen.mu[0]), min(span[1] + slack, self.seen.mu[-1])
        found = axis_crossing(self.structure, mu, value.imag, shape, (float(low), float(high)))
        if found is None or found.begins != begins:
            return []
        return [(Critical(found.mu, found.omega, modes), begins)]

    def _hidden(self, i: int, k: int, floor: float) -> list[tuple[Critical, bool]]:
        """Return growth that begins and ends beside grid point k, where the decay of mode i is least."""
        decay = lambda e: -self._value(i, k, e).real  # noqa: E731
        place, least = minimum_near(decay, self.seen.mu, k, most=20)
        if least >= -floor:
            return []
        low, high = self.seen.mu[k - 1], self.seen.mu[k + 1]
        return self._crossing(i, k, low, place, True, floor) + self._crossing(i, k, place, high, False, floor)

    # Without damping: the discriminant of a pair

    def _undamped_changes(self) -> list[tuple[Critical, bool]]:
        mu, values, changes = self.seen.mu, self.seen.values, []
        growing = np.abs(values.real) > _NEUTRAL * self.size
        for k in range(mu.size - 1):
            for i in range(len(values)):
                if growing[i, k] == growing[i, k + 1]:
                    continue
                begins = bool(growing[i, k + 1])
                inside = k + 1 if begins else k
                if abs(values[i, inside].imag) <= _NEUTRAL * self.size:
                    continue
                j = int(np.argmin(np.abs(values[:, inside] + values[i, inside].conj())))
                changes += self._merging(i, j, k, mu[k], mu[k + 1], k if begins else k + 1, begins)
        return changes + self._short_changes(growing)

    def _pair(self, i: int, j: int, k: int, mu: float) -> np.ndarray:
        """Return the squares ``-lambda^2`` of the pair whose space at grid point k the modes i, j span, shape (2,)."""
        known = np.linalg.qr(self.seen.shapes[k][:, [i, j]])[0]
        middle = 1j * float(np.sqrt(np.mean(np.abs(self.seen.values[[i, j], k]) ** 2))) * (1 + _OFF)
        new, shapes = eigenpairs(self.structure.pencil(mu), min(5, self.structure.n), middle)
        like = np.linalg.norm(known.conj().T @ shapes, axis=0)
        apart = np.abs(np.abs(new) - middle.imag) / middle.imag
        return -(new[np.argsort(apart - like, kind="stable")[:2]] ** 2)

    def _discriminant(self, i: int, j: int, k: int, mu: float) -> float:
        a, b = self._pair(i, j, k, mu)
        return float(((a - b) ** 2).real)

    def _merging(
        self, i: int, j: int, k: int, low: float, high: float, stable: int, begins: bool
    ) -> list[tuple[Critical, bool]]:
        if i == j:
            return []
        root = _root(lambda e: self._discriminant(i, j, stable, e), low, high)
        if root is None:
            return []
        one, other = self._pair(i, j, stable, root)
        if abs(one - other) > _NEUTRAL * self.size**2:
            return []  # not a pair: the square of a difference may be imaginary as well
        mean = 0.5 * float((one + other).real)
        return [(Critical(root, float(np.sqrt(max(mean, 0.0))), (min(i, j), max(i, j))), begins)]

    def _short_changes(self, growing: np.ndarray) -> list[tuple[Critical, bool]]:
        """Return flutter that begins and ends between two grid points, where the discriminant of a pair is least."""
        mu, changes, least = self.seen.mu, [], (_EQUAL * self.size**2) ** 2
        for i, j, k in self._near_pairs(growing):
            place, value = self._least(i, j, k)
            if value < -least:
                changes += self._merging(i, j, k, mu[k - 1], place, k, True)
                changes += self._merging(i, j, k, place, mu[k + 1], k, False)
        return changes

    def _growth(self, i: int, j: int, k: int, mu: float) -> float:
        """Return the largest real part of the eigenvalues of a pair."""
        return float(np.max((1j * np.sqrt(self._pair(i, j, k, mu))).real))

    def _least(self, i: int, j: int, k: int) -> Minimum:
        """Return where the discriminant of a pair is least near a grid point."""
        return minimum_near(lambda mu: self._discriminant(i, j, k, mu), self.seen.mu, k, most=30)

    def _near_pairs(self, growing: np.ndarray) -> Iterator[tuple[int, int, int]]:
        """Yield pairs of modes and grid points where they come near to each other and neither grows."""
        squares = (self.seen.values**2).real
        for k in range(1, self.seen.mu.size - 1):
            order = np.argsort(squares[:, k])
            for i, j in zip(order[:-1].tolist(), order[1:].tolist(), strict=True):
                if growing[[i, j], k - 1 : k + 2].any():
                    continue
                a, b, c = ((squares[i, e] - squares[j, e]) ** 2 for e in (k - 1, k, k + 1))
                if a >= b <= c and max(a, c) > b and b < _TURN * min(a, c) and b > (_EQUAL * self.size**2) ** 2:
                    yield i, j, k


def _passage(growth: Callable[[float], float], low: float, high: float, floor: float) -> float | None:
    """Return where growth passes zero, or what may be rounding if it is no more than that at an end."""
    growth = cache(growth)
    clear = min(abs(growth(low)), abs(growth(high))) > floor
    return _root(growth if clear else lambda mu: growth(mu) - floor, low, high)


def _root(function: Callable[[float], float], low: float, high: float) -> float | None:
    """Return a zero between two ends of different signs, None if they are not."""
    ends = function(low), function(high)
    if ends[0] == 0:
        return float(low)
    if ends[1] == 0:
        return float(high)
    if ends[0] * ends[1] > 0:
        return None
    return zero(function, low, high, xtol=1e-14 * max(abs(low), abs(high)), rtol=ROUNDING)
