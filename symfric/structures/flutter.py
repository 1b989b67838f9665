"""Flutter and divergence of structures with friction: eigenvalues over mu, and where a mode begins to grow.

Divergence, a real eigenvalue through zero, is a zero of the determinant of ``K + mu F``. Flutter, a complex pair
through the imaginary axis, is sought among all eigenvalues of a small structure, and along the modes followed of a
large one. Either is located on the full matrices, not read from a grid.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.axes import Axes
from symfric.errors import SceneError
from symfric.long_calls import logged
from symfric.model.results import Drawable, Result, plain
from symfric.model.symbols import finite, pair, shortened
from symfric.structures.complex_modes import eigenpairs, shift_of
from symfric.structures.crossings import Crossing, crossings
from symfric.structures.divergence import Divergence, divergences
from symfric.structures.followed_crossings import Critical, FollowedSearch
from symfric.structures.structure import Structure
from symfric.structures.tracking import Followed, follow

if TYPE_CHECKING:
    import xarray as xr

_GRID = 33  # values of mu to begin with
_WHOLE = 60  # degrees of freedom up to which all eigenvalues are searched
_STEPS = 16  # of that search to begin with
_ON = 1e-4  # of the largest eigenvalue: distance of a followed mode from a point that it belongs to
_SAME = 1e-9  # of the range of mu: points that are one


@dataclass(frozen=True, eq=False, repr=False)
class Flutter(Result, Drawable):
    """Eigenvalues of a structure over the coefficient of friction.

    `plot` draws imaginary parts against mu, with a panel of the real parts under them.

    Attributes
    ----------
    mu : ndarray, shape (n_mu,)
        Finer where modes change quickly.
    eigenvalues : ndarray of complex, shape (count, n_mu)
        Each row one mode, followed by its shape.
    critical : tuple of Critical
        Where growth begins, by increasing mu; each unpacks as (mu, omega, pair) and has a `kind`.
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

    def to_dict(self) -> dict[str, Any]:
        points = {"critical": plain(self.critical), "regained": plain(self.regained)}
        return {"mu": [float(self.mu[0]), float(self.mu[-1])], "modes": len(self.eigenvalues), **points}

    def to_xarray(self) -> "xr.DataArray":
        """Return an `xarray.DataArray` of the eigenvalues over modes and mu.

        Returns
        -------
        xarray.Dataset
        """
        import xarray as xr

        return xr.DataArray(self.eigenvalues, dims=("mode", "mu"), coords={"mu": self.mu}, name="eigenvalues")

    def _draw(self, ax: Axes | None) -> Axes:
        from symfric.structures.pictures import plot_flutter

        return plot_flutter(self, ax)

    def __repr__(self) -> str:
        first = self.critical[0] if self.critical else None
        words = f"first at mu = {first.mu:.9g}, omega = {first.omega:.9g}" if first else "no mode begins to grow"
        return f"Flutter({len(self.eigenvalues)} modes, mu from {self.mu[0]:g} to {self.mu[-1]:g}; {words})"


@logged
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
    Divergence is found whatever modes are followed, from the determinant of ``K + mu F``.

    Of a structure of up to 60 degrees of freedom all eigenvalues are searched for flutter, with steps halved until each
    is resolved; if `count` is smaller than the structure, flutter farther from `near` than the modes followed is left
    out. Of a larger structure only these modes are known. Flutter of any other is not seen, and flutter that begins and
    ends between two values of the grid only where the discriminant of a pair, or the decay of a mode, has a small
    minimum. Divergence of a larger structure (more than 300) with a motion that meets no stiffness is not seen.

    Examples
    --------
    Ziegler's double pendulum (1952), where ``P l/k = 7/2 - sqrt(2)``:

    >>> import symfric as sf
    >>> found = sf.structures.flutter(sf.structures.ziegler(), mu=(0.0, 3.0), count=2)
    >>> round(found.critical[0].mu, 10)
    2.0857864376
    """
    if not isinstance(structure, Structure):
        raise SceneError(f"{shortened(structure)} is no sf.structures.Structure")
    if structure.friction is None:
        raise SceneError("the structure has no friction matrix; give it as `friction`, or flutter has nothing to vary")
    low, high = (finite(e, "an end of the range of mu") for e in pair(mu, "mu"))
    if not low < high:
        raise SceneError(f"the range of mu is ({low:g}, {high:g}); give the lower end first")
    if isinstance(grid, bool) or not isinstance(grid, int) or grid < 2:
        raise SceneError(f"grid is {shortened(grid)}; give a whole number from 2")
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise SceneError(f"count is {shortened(count)}; give a whole number from 1")
    modes, point = min(count, structure.n), shift_of(near)
    static = divergences(structure, low, high)
    whole = structure.n <= _WHOLE
    vibrating = crossings(structure, low, high, max(_STEPS, grid - 1)) if whole else []
    mus = _with(np.linspace(low, high, grid), [e.mu for e in static] + [e.mu for e in vibrating])
    seen = follow(structure, mus, modes, point)
    changes = [(_static(e, seen), e.begins) for e in static]
    if whole:
        chosen = [e for e in vibrating if modes == structure.n or _belongs(e, seen, point)]
        changes += [(_vibrating(e, seen), e.begins) for e in chosen]
    else:
        changes += FollowedSearch(structure, seen).over()
    onsets, ends = _distinct(changes, _SAME * (high - low))
    still = {e.mu: e.shape for e in static}
    shapes = [_shape(structure, p, still) for p in onsets]
    array = np.array(shapes) if shapes else np.zeros((0, structure.n), complex)
    return Flutter(seen.mu, seen.values, tuple(onsets), tuple(ends), array, structure.names)


def _with(grid: np.ndarray, points: list[float]) -> np.ndarray:
    """Return a grid with additional points, which replace the grid points beside them."""
    width = _SAME * (grid[-1] - grid[0])
    inner = [mu for mu in sorted(set(points)) if np.min(np.abs(grid - mu)) > width]
    return np.sort(np.concatenate([grid, inner]))


def _column(seen: Followed, mu: float) -> np.ndarray:
    """Return the eigenvalues followed at the value of mu nearest to one."""
    return seen.values[:, int(np.argmin(np.abs(seen.mu - mu)))]


def _belongs(crossing: Crossing, seen: Followed, near: complex) -> bool:
    """Return whether a crossing is no farther from `near` than the modes followed."""
    values = _column(seen, crossing.mu)
    reach = np.max(np.abs(values - near)) + _ON * np.max(np.abs(seen.values))
    return bool(abs(1j * crossing.omega - near) <= reach)


def _vibrating(crossing: Crossing, seen: Followed) -> Critical:
    values = _column(seen, crossing.mu)
    first = int(np.argmin(np.abs(values - 1j * crossing.omega)))
    apart = np.abs(values - 1j * crossing.omega) if crossing.merging else np.abs(values.imag - crossing.omega)
    apart[first] = np.inf
    second = int(np.argmin(apart)) if values.size > 1 else first
    pair = (min(first, second), max(first, second)) if crossing.merging else (first, second)
    return Critical(crossing.mu, crossing.omega, pair)


def _static(passage: Divergence, seen: Followed) -> Critical:
    values = np.abs(_column(seen, passage.mu))
    row = int(np.argmin(values))
    if values[row] > _ON * np.max(np.abs(seen.values)):
        row = -1
    return Critical(passage.mu, 0.0, (row, row))


def _distinct(changes: list[tuple[Critical, bool]], width: float) -> tuple[list[Critical], list[Critical]]:
    """Return where growth begins and where it ends, each once, by increasing mu."""
    onsets: list[Critical] = []
    ends: list[Critical] = []
    for point, begins in sorted(changes, key=lambda e: e[0].mu):
        known = onsets if begins else ends
        if not any(abs(p.mu - point.mu) <= width and abs(p.omega - point.omega) <= _ON * p.omega for p in known):
            known.append(point)
    return onsets, ends


def _shape(structure: Structure, point: Critical, still: dict[float, np.ndarray]) -> np.ndarray:
    """Return the shape that begins to grow."""
    if point.kind == "divergence":
        shape = still[point.mu]
        return np.asarray(shape.astype(complex) * np.sign(shape[np.argmax(np.abs(shape))]))
    return eigenpairs(structure.pencil(point.mu), 1, 1j * point.omega)[1][:, 0]
