"""Rows over the degrees of freedom of a structure, however they are given."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sps

from symfric.errors import SceneError
from symfric.model.symbols import finite
from symfric.structures.checks import index_of, row_of

_DEPENDENT = 1e-9  # of a row: what is left of it without those before it

if TYPE_CHECKING:
    from symfric.structures.structure import Structure


def row_in(structure: "Structure", entries: Any, what: str = "the row") -> np.ndarray:
    """Return a row over the degrees of freedom of a structure, shape (n,).

    Parameters
    ----------
    structure : Structure
    entries : array_like, sparse, mapping of name or number to weight, name or number
        Of a reduced structure also names of the full one, and a row over all its degrees of freedom; numbers are taken
        for such a row if both have as many.
    what : str
        For messages.
    """
    n = structure.n
    if isinstance(entries, str | int | np.integer) and not isinstance(entries, bool):
        entries = {entries: 1.0}
    if isinstance(entries, Mapping):
        own = structure.basis is None or all(k in structure.names for k in entries if isinstance(k, str))
        names = structure.names if own else structure.full_names
        weights = np.zeros(len(names))
        for key, weight in entries.items():
            weights[index_of(key, names)] += finite(weight, f"the weight of {key} in {what}")
        return row_of(weights, n, what) if own else row_of(weights, len(names), what) @ structure.basis
    if structure.basis is not None and _length(entries, what) == len(structure.basis):
        return np.asarray(row_of(entries, len(structure.basis), what) @ structure.basis)
    return row_of(entries, n, what)


def _length(entries: Any, what: str) -> int:
    if sps.issparse(entries):
        return int(np.prod(entries.shape))
    try:
        return int(np.asarray(entries, dtype=float).size)
    except (TypeError, ValueError):
        raise SceneError(f"{what} is {entries!r}; give numbers, dense or sparse, or names with weights") from None


def kept_rows(structure: "Structure", keep: Any) -> tuple[list[str], np.ndarray]:
    """Return names and rows of what a reduction keeps; rows that follow from those before them are left out."""
    if keep is None:
        keep = []
    elif isinstance(keep, str | int | np.integer | Mapping) or hasattr(keep, "kept"):
        keep = [keep]
    elif not isinstance(keep, Iterable):
        raise SceneError(f"keep is {keep!r}; give a list of names, numbers, rows and contacts")
    names: list[str] = []
    rows: list[np.ndarray] = []
    basis: list[np.ndarray] = []
    for entry in _each_row(keep):
        row = row_in(structure, entry, f"kept row {len(rows) + 1}")
        left = row / np.linalg.norm(row)
        for _ in range(2):
            for known in basis:
                left = left - known * (known @ left)
        if np.linalg.norm(left) <= _DEPENDENT:
            continue
        basis.append(left / np.linalg.norm(left))
        rows.append(row)
        names.append(_label(structure, entry, len(rows)))
    doubled = {name for name in names if names.count(name) > 1}
    names = [f"row{k + 1}" if name in doubled else name for k, name in enumerate(names)]
    return names, np.array(rows).reshape(len(rows), structure.n)


def _each_row(keep: Any) -> Iterator[Any]:
    """Yield names of rows or rows; of a contact those of its slip and its load."""
    for entry in keep.toarray() if sps.issparse(keep) else keep:
        if hasattr(entry, "kept"):
            yield from entry.kept
        else:
            yield entry


def _label(structure: "Structure", entry: Any, number: int) -> str:
    if isinstance(entry, str):
        return entry
    if isinstance(entry, int | np.integer):
        return structure.names[int(entry)]
    return f"row{number}"
