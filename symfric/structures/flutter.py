"""Flutter of structures with friction: eigenvalues over mu, and where a mode begins to grow.

Without damping two modes merge: their squares ``theta = -lambda^2`` meet as a double root. ``(theta_1 - theta_2)^2`` is
the discriminant of the pair, a smooth function of mu that changes its sign there, while the eigenvalues themselves have
a branch point (Seyranian and Mailybaev, Multiparameter Stability Theory, 2003, chapter 2). With damping the real part
of one eigenvalue passes zero. Either is found by root finding on the full matrices, not read from a grid.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from symfric.errors import SceneError
from symfric.model.notebook import html_table
from symfric.model.symbols import finite
from symfric.structures.complex_modes import eigenpairs, shift_of
from symfric.structures.structure import Structure
from symfric.structures.tracking import Followed, assurance, follow

_GRID = 33  # values of mu to begin with
_NEUTRAL = 1e-5  # of an eigenvalue: a real part that a merging pair may have through rounding
_TURN = 0.5  # of its neighbours: least discriminant, or decay, that may hide a change of sign between the grid


class Critical(NamedTuple):
    """A value of mu at which a mode begins to grow.

    Attributes
    ----------
    mu, omega : float
        omega is 0 where the structure diverges without vibration.
    pair : (int, int)
        Rows of `Flutter.eigenvalues` of the mode that grows and of the one that it merges with, or comes nearest to.

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


@dataclass(frozen=True, eq=False, repr=False)
class Flutter:
    """Eigenvalues of a structure over the coefficient of friction.

    Attributes
    ----------
    mu : ndarray, shape (n_mu,)
        Finer where modes change quickly.
    eigenvalues : ndarray of complex, shape (count, n_mu)
        Each row one mode, followed by its shape.
    critical : tuple of Critical
        Where growth begins, by increasing mu; each unpacks as (mu, omega, pair).
    regained : tuple of Critical
        Where growth ends.
    shapes : ndarray of complex, shape (len(critical), n)
        Of the mode that begins to grow, the largest entry of each real and positive.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.structures.flutter(sf.structures.ziegler(), mu=(0, 4), count=2)
    >>> len(found.critical)
    1
    >>> sorted(found.to_dict())[:2]
    ['critical', 'modes']
    >>> found.to_xarray().dims
    ('mode', 'mu')
    >>> ax = found.plot()
    """

    mu: np.ndarray
    eigenvalues: np.ndarray
    critical: tuple[Critical, ...]
    regained: tuple[Critical, ...]
    shapes: np.ndarray
    names: tuple[str, ...] = field(repr=False, default=())

    def to_dict(self) -> dict[str, object]:
        """Return plain numbers and lists.

        Returns
        -------
        dict
            Plain numbers, strings and lists.
        """
        points = {
            name: [{"mu": p.mu, "omega": p.omega, "pair": list(p.pair)} for p in getattr(self, name)]
            for name in ("critical", "regained")
        }
        return {"mu": [float(self.mu[0]), float(self.mu[-1])], "modes": len(self.eigenvalues), **points}

    def to_xarray(self):
        """Return an `xarray.DataArray` of the eigenvalues over modes and mu.

        Returns
        -------
        xarray.Dataset
        """
        import xarray as xr

        return xr.DataArray(self.eigenvalues, dims=("mode", "mu"), coords={"mu": self.mu}, name="eigenvalues")

    def plot(self, ax=None):
        """Draw imaginary parts against mu, with a panel of the real parts under them; return the Axes.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw; a new figure unless given.

        Returns
        -------
        matplotlib Axes
        """
        from symfric.structures.pictures import plot_flutter

        return plot_flutter(self, ax)

    def _repr_html_(self) -> str:
        return html_table("Flutter", self.to_dict())

    def __repr__(self) -> str:
        first = self.critical[0] if self.critical else None
        words = f"first at mu = {first.mu:.9g}, omega = {first.omega:.9g}" if first else "no mode begins to grow"
        return f"Flutter({len(self.eigenvalues)} modes, mu from {self.mu[0]:g} to {self.mu[-1]:g}; {words})"


def flutter(
    structure: Structure, mu: tuple[float, float], count: int = 8, near: complex | float = 0.0, grid: int = _GRID
) -> Flutter:
    """Follow the modes of a structure over mu and locate where they begin to grow.

    Parameters
    ----------
    structure : Structure
        With a friction matrix.
    mu : (float, float)
        Range.
    count : int
        Modes followed: those nearest to `near` at the lower end; all of a structure with fewer degrees of freedom.
    near : float or complex
        A frequency in rad/time.
    grid : int
        Values of mu to begin with; more are added where shapes change quickly.

    Returns
    -------
    Flutter

    Raises
    ------
    SceneError
        If the structure has no friction matrix, or the range is empty.
    NotFound
        If an iteration does not converge.

    Notes
    -----
    A change that begins and ends between two values of the grid is looked for where the discriminant of a pair, or the
    decay of a mode, has a small minimum.

    Examples
    --------
    Ziegler's double pendulum (1952), where ``P l/k = 7/2 - sqrt(2)``:

    >>> import symfric as sf
    >>> found = sf.structures.flutter(sf.structures.ziegler(), mu=(0.0, 3.0), count=2)
    >>> round(found.critical[0].mu, 10)
    2.0857864376
    """
    if not isinstance(structure, Structure):
        raise SceneError(f"{structure!r} is no sf.structures.Structure")
    if structure.friction is None:
        raise SceneError("the structure has no friction matrix; give it as `friction`, or flutter has nothing to vary")
    try:
        low, high = (finite(e, "an end of the range of mu") for e in mu)
    except (TypeError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(f"mu is {mu!r}; give a pair (low, high)") from None
    if not low < high:
        raise SceneError(f"the range of mu is ({low:g}, {high:g}); give the lower end first")
    if isinstance(grid, bool) or not isinstance(grid, int) or grid < 2:
        raise SceneError(f"grid is {grid!r}; give a whole number from 2")
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise SceneError(f"count is {count!r}; give a whole number from 1")
    seen = follow(structure, np.linspace(low, high, grid), min(count, structure.n), shift_of(near))
    search = _Search(structure, seen)
    onsets, ends = search.changes()
    shapes = [search.shape_at(point) for point in onsets]
    array = np.array(shapes) if shapes else np.zeros((0, structure.n), complex)
    return Flutter(seen.mu, seen.values, tuple(onsets), tuple(ends), array, structure.names)


class _Search:
    """The search for changes of stability along followed modes."""

    def __init__(self, structure: Structure, seen: Followed):
        self.structure, self.seen, self.damped = structure, seen, structure.C is not None
        self.size = float(np.max(np.abs(seen.values))) or 1.0

    def changes(self) -> tuple[list[Critical], list[Critical]]:
        """Return where growth begins and where it ends."""
        points = self._damped_changes() if self.damped else self._undamped_changes()
        onsets: list[Critical] = []
        ends: list[Critical] = []
        for point, begins in sorted(points, key=lambda e: e[0].mu):
            known = onsets if begins else ends
            if not any(abs(p.mu - point.mu) <= 1e-9 * max(1.0, abs(p.mu)) and {*p.pair} & {*point.pair} for p in known):
                known.append(point)
        return onsets, ends

    def shape_at(self, point: Critical) -> np.ndarray:
        """Return the shape that begins to grow."""
        return eigenpairs(self.structure.pencil(point.mu), 1, 1j * point.omega)[1][:, 0]

    # With damping: the real part of one eigenvalue

    def _damped_changes(self) -> list[tuple[Critical, bool]]:
        mu, values, found = self.seen.mu, self.seen.values, []
        for i, row in enumerate(values):
            growth = row.real
            for k in range(mu.size - 1):
                if (growth[k] > 0) != (growth[k + 1] > 0):
                    found += self._crossing(i, k, mu[k], mu[k + 1], growth[k + 1] > 0)
            for k in range(1, mu.size - 1):
                a, b, c = growth[k - 1 : k + 2]
                if b < 0 and a < b > c and b > _TURN * min(a, c):
                    found += self._hidden(i, k)
        for i, j, k in self._near_pairs(values.real > 0):
            test = lambda e, i=i, j=j, k=k: self._discriminant(i, j, k, e)  # noqa: E731
            best = minimize_scalar(test, bounds=(mu[k - 1], mu[k + 1]), method="bounded", options={"maxiter": 30})
            growth_of = lambda e, i=i, j=j, k=k: float(np.max((1j * np.sqrt(self._pair(i, j, k, e))).real))  # noqa: E731
            if growth_of(best.x) > 0:
                for low, high, begins in ((mu[k - 1], best.x, True), (best.x, mu[k + 1], False)):
                    root = _root(growth_of, low, high)
                    if root is not None:
                        omega = float(np.mean(np.sqrt(self._pair(i, j, k, root)).real))
                        found.append((Critical(root, omega, (min(i, j), max(i, j))), begins))
        return found

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

    def _crossing(self, i: int, k: int, low: float, high: float, begins: bool) -> list[tuple[Critical, bool]]:
        root = _root(lambda e: self._value(i, k, e).real, low, high)
        if root is None:
            return []
        value = self._value(i, k, root)
        others = np.abs(self.seen.values[:, k].imag - value.imag)
        others[i] = np.inf
        partner = int(np.argmin(others)) if others.size > 1 else i
        return [(Critical(root, abs(value.imag), (i, partner)), begins)]

    def _hidden(self, i: int, k: int) -> list[tuple[Critical, bool]]:
        """Return growth that begins and ends beside grid point k, where the decay of mode i is least."""
        decay = lambda e: -self._value(i, k, e).real  # noqa: E731
        low, high = self.seen.mu[k - 1], self.seen.mu[k + 1]
        best = minimize_scalar(decay, bounds=(low, high), method="bounded", options={"maxiter": 20})
        if best.fun >= 0:
            return []
        return self._crossing(i, k, low, best.x, True) + self._crossing(i, k, best.x, high, False)

    # Without damping: the discriminant of a pair

    def _undamped_changes(self) -> list[tuple[Critical, bool]]:
        mu, values, found = self.seen.mu, self.seen.values, []
        growing = np.abs(values.real) > _NEUTRAL * self.size
        for k in range(mu.size - 1):
            for i in range(len(values)):
                if growing[i, k] == growing[i, k + 1]:
                    continue
                begins = bool(growing[i, k + 1])
                inside = k + 1 if begins else k
                if abs(values[i, inside].imag) <= _NEUTRAL * self.size:
                    found += self._divergence(i, k, begins)
                    continue
                j = int(np.argmin(np.abs(values[:, inside] + values[i, inside].conj())))
                found += self._merging(i, j, k, mu[k], mu[k + 1], k if begins else k + 1, begins)
        return found + self._short_changes(growing)

    def _pair(self, i: int, j: int, k: int, mu: float) -> np.ndarray:
        """Return the squares ``-lambda^2`` of the pair whose space at grid point k the modes i, j span, shape (2,)."""
        known = np.linalg.qr(self.seen.shapes[k][:, [i, j]])[0]
        middle = 1j * float(np.sqrt(np.mean(np.abs(self.seen.values[[i, j], k]) ** 2))) * (1 + 1e-4)
        new, shapes = eigenpairs(self.structure.pencil(mu), min(5, self.structure.n), middle)
        like = np.linalg.norm(known.conj().T @ shapes, axis=0)
        apart = np.abs(np.abs(new) - middle.imag) / middle.imag
        return -(new[np.argsort(apart - like, kind="stable")[:2]] ** 2)

    def _discriminant(self, i: int, j: int, k: int, mu: float) -> float:
        a, b = self._pair(i, j, k, mu)
        return float(((a - b) ** 2).real)

    def _merging(self, i, j, k, low, high, stable, begins) -> list[tuple[Critical, bool]]:
        if i == j:
            return []
        root = _root(lambda e: self._discriminant(i, j, stable, e), low, high)
        if root is None:
            return []
        mean = float(np.mean(self._pair(i, j, stable, root).real))
        return [(Critical(root, float(np.sqrt(max(mean, 0.0))), (min(i, j), max(i, j))), begins)]

    def _divergence(self, i: int, k: int, begins: bool) -> list[tuple[Critical, bool]]:
        """Return where the least square passes zero."""

        def least(mu: float) -> float:
            new, _ = eigenpairs(self.structure.pencil(mu), 1, 0j)
            return float(-(new[0] ** 2).real)

        root = _root(least, self.seen.mu[k], self.seen.mu[k + 1])
        return [] if root is None else [(Critical(root, 0.0, (i, i)), begins)]

    def _short_changes(self, growing: np.ndarray) -> list[tuple[Critical, bool]]:
        """Return flutter that begins and ends between two grid points, where the discriminant of a pair is least."""
        mu, found, least = self.seen.mu, [], (1e-9 * self.size**2) ** 2
        for i, j, k in self._near_pairs(growing):
            test = lambda e, i=i, j=j, k=k: self._discriminant(i, j, k, e)  # noqa: E731
            best = minimize_scalar(test, bounds=(mu[k - 1], mu[k + 1]), method="bounded", options={"maxiter": 30})
            if best.fun < -least:
                found += self._merging(i, j, k, mu[k - 1], best.x, k, True)
                found += self._merging(i, j, k, best.x, mu[k + 1], k, False)
        return found

    def _near_pairs(self, growing: np.ndarray) -> Iterator[tuple[int, int, int]]:
        """Yield pairs of modes and grid points where they come near to each other and neither grows."""
        squares = (self.seen.values**2).real
        for k in range(1, self.seen.mu.size - 1):
            order = np.argsort(squares[:, k])
            for i, j in zip(order[:-1].tolist(), order[1:].tolist(), strict=True):
                if growing[[i, j], k - 1 : k + 2].any():
                    continue
                a, b, c = ((squares[i, e] - squares[j, e]) ** 2 for e in (k - 1, k, k + 1))
                if a >= b <= c and max(a, c) > b and b < _TURN * min(a, c) and b > (1e-9 * self.size**2) ** 2:
                    yield i, j, k


def _root(function: Callable[[float], float], low: float, high: float) -> float | None:
    """Return a zero between two ends of different signs, None if they are not."""
    ends = function(low), function(high)
    if ends[0] == 0:
        return float(low)
    if ends[1] == 0:
        return float(high)
    if ends[0] * ends[1] > 0:
        return None
    return float(brentq(function, low, high, xtol=1e-14 * max(abs(low), abs(high)), rtol=4 * np.finfo(float).eps))
