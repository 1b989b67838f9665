"""Rows over the degrees of freedom of a structure, however they are given."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sps

from symfric.errors import SceneError
from symfric.model.symbols import finite
from symfric.structures.checks import index_of, row_of

if TYPE_CHECKING:
    from symfric.structures.structure import Structure


def row_in(structure: "Structure", entries, what: str = "the row") -> np.ndarray:
    """Return a row over the degrees of freedom of a structure, shape (n,).

    Parameters
    ----------
    structure : Structure
    entries : array_like, sparse, mapping of name or number to weight, name or number
        A row over all degrees of freedom of which the structure is a reduction is taken, too.
    what : str
        For messages.
    """
    n = structure.n
    if isinstance(entries, str | int | np.integer) and not isinstance(entries, bool):
        entries = {entries: 1.0}
    if isinstance(entries, Mapping):
        found = np.zeros(n)
        for key, weight in entries.items():
            found[index_of(key, structure.names)] += finite(weight, f"the weight of {key} in {what}")
        return row_of(found, n, what)
    if structure.basis is not None and _length(entries, what) == len(structure.basis) != n:
        return row_of(entries, len(structure.basis), what) @ structure.basis
    return row_of(entries, n, what)


def _length(entries, what: str) -> int:
    if sps.issparse(entries):
        return int(np.prod(entries.shape))
    try:
        return int(np.asarray(entries, dtype=float).size)
    except (TypeError, ValueError):
        raise SceneError(f"{what} is {entries!r}; give numbers, dense or sparse, or names with weights") from None
