"""Checks of matrices that come from elsewhere: each fault is one line that names the matrix, the place and the cure."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sps

from symfric.errors import SceneError
from symfric.model.arguments import items
from symfric.model.symbols import legible, nearest, shortened
from symfric.structures.factors import indefinite_at

_SYMMETRIC = 1e-8  # of the largest entry: what a file with few digits leaves of symmetry


def matrix(value: Any, name: str, n: int | None = None) -> sps.csr_array:
    """Return a real square matrix in sparse form.

    Parameters
    ----------
    value : array_like or sparse, shape (n, n)
    name : str
        For messages.
    n : int, optional
        The size that it must have.

    Raises
    ------
    SceneError
        If it is not a matrix of finite real numbers, not square, or of another size.
    """
    try:
        given = value if sps.issparse(value) else np.atleast_2d(np.asarray(value))
    except (TypeError, ValueError) as error:
        raise SceneError(f"{name} cannot be read as a matrix ({error}); give numbers, dense or sparse") from None
    if given.dtype.kind == "c":
        raise SceneError(f"{name} is complex; give real matrices, structural damping as an equivalent C")
    if given.dtype.kind not in "fiub" or given.ndim != 2:
        raise SceneError(f"{name} is no matrix of numbers; give numbers, dense or sparse, shape (n, n)")
    A = sps.csr_array(given)
    A = A.astype(float)
    rows, columns = A.shape
    if rows != columns:
        raise SceneError(f"{name} has shape {A.shape}; it must be square")
    if n is not None and rows != n:
        raise SceneError(f"{name} has shape {A.shape}, and M has ({n}, {n}); give matrices of one size")
    if not rows:
        raise SceneError(f"{name} is empty")
    A.sum_duplicates()
    bad = np.flatnonzero(~np.isfinite(A.data))
    if bad.size:
        row = int(np.searchsorted(A.indptr, bad[0], side="right") - 1)
        place = f"({row}, {int(A.indices[bad[0]])})"
        raise SceneError(f"{name} has {bad.size} entries that are not finite, the first at {place}")
    A.eliminate_zeros()
    return A


def symmetric(A: sps.csr_array, name: str, cure: str) -> sps.csr_array:
    """Return the symmetric part of a matrix that is symmetric up to the digits of a file; raise otherwise."""
    apart = abs(A - A.T).tocoo()
    largest = abs(A.data).max(initial=0.0)
    if apart.nnz and apart.data.max() > _SYMMETRIC * largest:
        k = int(np.argmax(apart.data))
        i, j = int(apart.row[k]), int(apart.col[k])
        i, j = min(i, j), max(i, j)
        raise SceneError(
            f"{name} is not symmetric: its entries ({i}, {j}) and ({j}, {i}) are {A[i, j]:.6g} and "
            f"{A[j, i]:.6g}; {cure}"
        )
    return sps.csr_array(0.5 * (A + A.T))


def positive_definite(mass: sps.csr_array, names: Sequence[str]) -> None:
    """Raise unless a symmetric mass matrix is positive definite; name a row where it fails."""
    diagonal = mass.diagonal()
    if np.min(diagonal) <= 0:
        k = int(np.argmin(diagonal))
        raise SceneError(
            f"M is not positive definite: its diagonal entry of {names[k]!r} (row {k}) is {diagonal[k]:.6g}; "
            "condense degrees of freedom without mass, or give them some"
        )
    bad = indefinite_at(mass)
    if bad is not None:
        raise SceneError(
            f"M is not positive definite: no kinetic energy, or less, in a motion of {names[bad]!r} (row {bad})"
        )


def names_of(names: Sequence[str] | None, n: int) -> tuple[str, ...]:
    """Return the names of the degrees of freedom, ``q1, q2, ...`` unless given."""
    if names is None:
        return tuple(f"q{i + 1}" for i in range(n))
    labels = tuple(items(names, "names")) if not isinstance(names, str) else (names,)
    if len(labels) != n:
        raise SceneError(f"{len(labels)} names for {n} degrees of freedom; give one for each row of M")
    for name in labels:
        if not isinstance(name, str) or not name:
            raise SceneError(f"the name {name!r} of a degree of freedom is no string")
        legible(name, "a degree of freedom")
    if len(set(labels)) < n:
        double = next(name for i, name in enumerate(labels) if name in labels[:i])
        raise SceneError(f"two degrees of freedom are called {double!r}; give each its own name")
    rates = {f"d_{name}" for name in labels}
    if taken := next((name for name in labels if name in rates), None):
        raise SceneError(f"a degree of freedom is called {taken!r}, as the velocity of {taken[2:]!r} is; rename it")
    return labels


def index_of(key: int | str, names: Sequence[str]) -> int:
    """Return the row of a degree of freedom given by its number, counted from 0, or its name."""
    if isinstance(key, str):
        if key not in names:
            raise SceneError(f"no degree of freedom {shortened(key)}{nearest(key, names)}")
        return names.index(key)
    if isinstance(key, bool) or not isinstance(key, int | np.integer):
        raise SceneError(f"{shortened(key)} is no degree of freedom; give its name or its number, counted from 0")
    if not 0 <= key < len(names):
        raise SceneError(f"no degree of freedom {int(key)}; there are {len(names)}, counted from 0")
    return int(key)


def row_of(value: Any, n: int, what: str) -> np.ndarray:
    """Return a row of n numbers, given dense or sparse, in any orientation.

    Raises
    ------
    SceneError
        If it has another length, is not finite, or is zero throughout.
    """
    if value is None:
        raise SceneError(f"{what} is None; give {n} numbers, dense or sparse, or names with weights")
    try:
        dense = value.toarray() if sps.issparse(value) else np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise SceneError(f"{what} cannot be read ({error}); give {n} numbers, dense or sparse") from None
    row = np.array(dense, dtype=float)
    if row.size != max(row.shape, default=1):
        raise SceneError(f"{what} has shape {row.shape}; give one row")
    row = row.ravel()
    if row.size != n:
        raise SceneError(f"{what} has {row.size} entries; the structure has {n} degrees of freedom")
    if not np.all(np.isfinite(row)):
        raise SceneError(f"{what} holds an entry that is not finite, number {int(np.argmax(~np.isfinite(row)))}")
    if not np.any(row):
        raise SceneError(f"{what} is zero throughout; it names no motion")
    return row


def positive_count(count: int, most: int, what: str, least: int = 1) -> int:
    """Return a number of modes that can be asked for."""
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or not least <= count <= most:
        raise SceneError(f"{what} is {shortened(count)}; give a whole number from {least} to {most}")
    return int(count)
