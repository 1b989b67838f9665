"""Arrays in files of NumPy: every size and index that a file states is checked against its data before it is used."""

import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sps

from symfric.array_files import array_of
from symfric.errors import SceneError
from symfric.structures.archives import content, entry_called, opened

MAX_ROWS = 2_000_000  # degrees of freedom
MAX_ENTRIES = 50_000_000  # stored entries of a matrix
MAX_NAMES = 1 << 28  # bytes of the names
_PARTS = ("data", "indices", "indptr", "row", "col", "shape", "format")
_FORMATS = ("csr", "csc", "coo")


def read_arrays(place: Path, names: tuple[str, ...]) -> dict[str, Any]:
    """Return the matrices of a .npz by name, dense or as csr_array, and ``names``; other entries are not read.

    Parameters
    ----------
    place : Path
    names : tuple of str
        Of the matrices; each is absent, dense, or in sparse parts.

    Raises
    ------
    SceneError
        If the file is damaged, or what it says of a matrix disagrees with its data.
    """
    matrices: dict[str, Any] = {}
    with opened(place) as file:
        for name in names:
            what = f"{name} in {place.name}"
            parts = {p: _entry(file, f"{name}_{p}", place.name) for p in _PARTS}
            given = {p: array for p, array in parts.items() if array is not None}
            dense = _entry(file, name, place.name)
            if dense is not None and given:
                raise SceneError(f"{what} is there as a whole and in parts; keep one of them")
            if dense is not None:
                matrices[name] = dense
            elif given:
                matrices[name] = assembled(given, what)
        labels = _entry(file, "names", place.name, MAX_NAMES)
        if labels is not None:
            matrices["names"] = _labels(labels, place.name)
    return matrices


def _entry(file: zipfile.ZipFile, name: str, archive: str, most: int = 16 * MAX_ENTRIES) -> np.ndarray | None:
    """Return an array of an archive, None if it has none of this name."""
    entry = entry_called(file, (f"{name}.npy",), archive, flat=True)
    return None if entry is None else array_of(content(file, entry, most), f"{name} in {archive}")


def _labels(letters_of: np.ndarray, name: str) -> list[str]:
    """Return an array of names as strings."""
    if letters_of.dtype.kind == "S":
        return [e.decode("utf-8") for e in letters_of.ravel().tolist()]
    if letters_of.dtype.kind != "U":
        raise SceneError(f"the names in {name} are of type {letters_of.dtype}; give an array of strings")
    letters = np.frombuffer(letters_of.tobytes(), np.dtype(np.uint32).newbyteorder(letters_of.dtype.byteorder))
    if letters.max(initial=0) > sys.maxunicode:
        raise SceneError(f"the names in {name} are no text; write them anew")
    return letters_of.ravel().tolist()


def assembled(parts: dict[str, np.ndarray], what: str) -> sps.csr_array:
    """Return a sparse matrix of its stored parts.

    Parameters
    ----------
    parts : dict of str to array
        ``data``, ``shape``, and ``indices`` with ``indptr``, or ``row`` with ``col``.
    what : str
        For messages.

    Raises
    ------
    SceneError
        If a part is missing, no row of numbers, or names an entry outside the matrix.
    """
    shape = _whole(parts, "shape", what)
    if shape.size != 2 or np.min(shape) < 0:
        raise SceneError(f"{what} has the shape {shape.tolist()[:4]}; two numbers are needed")
    size = int(shape[0]), int(shape[1])
    check_size(*size, 0, what)
    data = _row(parts, "data", what)
    if data.dtype.kind not in "fiubc":
        raise SceneError(f"the data of {what} are no numbers")
    check_size(*size, data.size, what)
    stored = str(parts["format"].tolist()) if "format" in parts else "csr" if "indptr" in parts else "coo"
    stored = stored.removeprefix("b'").removesuffix("'")
    if stored not in _FORMATS:
        raise SceneError(f"{what} is stored in the format {stored[:20]!r}; store it as {', '.join(_FORMATS)}")
    if stored == "coo":
        row, column = (
            _index(parts, name, count, data.size, what) for name, count in zip(("row", "col"), size, strict=True)
        )
        return sps.csr_array(sps.coo_array((data.astype(_kind(data)), (row, column)), shape=size))
    along, across = size if stored == "csr" else size[::-1]
    inside = _index(parts, "indices", across, data.size, what)
    begins = _whole(parts, "indptr", what)
    if begins.size != along + 1 or begins[0] != 0 or begins[-1] != data.size or np.any(np.diff(begins) < 0):
        raise SceneError(
            f"{what}: indptr must be {along + 1} numbers that do not decrease, from 0 to the {data.size} of the data"
        )
    kind = sps.csr_array if stored == "csr" else sps.csc_array
    return sps.csr_array(kind((data.astype(_kind(data)), inside, begins), shape=size))


def check_size(rows: int, columns: int, entries: int, what: str) -> None:
    """Raise if a matrix is larger than structures that are read may be."""
    if max(rows, columns) > MAX_ROWS:
        raise SceneError(f"{what} has the shape ({rows}, {columns}); at most {MAX_ROWS} degrees of freedom are read")
    if entries > MAX_ENTRIES:
        raise SceneError(f"{what} has {entries} entries; at most {MAX_ENTRIES} are read; reduce the structure")


def _kind(data: np.ndarray) -> type:
    return complex if data.dtype.kind == "c" else float  # complex ones are refused later, with the cure


def _row(parts: dict[str, np.ndarray], name: str, what: str) -> np.ndarray:
    if name not in parts:
        raise SceneError(f"{what} is a sparse matrix without its part {name!r}; it holds: {', '.join(sorted(parts))}")
    if parts[name].ndim != 1:
        raise SceneError(f"the part {name!r} of {what} has shape {parts[name].shape}; one row is needed")
    return parts[name]


def _whole(parts: dict[str, np.ndarray], name: str, what: str) -> np.ndarray:
    """Return a part of whole numbers below 2**63."""
    row = _row(parts, name, what)
    if row.dtype.kind not in "iu" or not row.size:
        raise SceneError(f"the part {name!r} of {what} is of type {row.dtype}; whole numbers are needed")
    if row.size and int(row.max()) > np.iinfo(np.int64).max:
        raise SceneError(f"the part {name!r} of {what} holds {int(row.max())}, which is too large")
    return row.astype(np.int64)


def _index(parts: dict[str, np.ndarray], name: str, count: int, entries: int, what: str) -> np.ndarray:
    """Return a part of numbers of rows or columns, one for each entry."""
    row = _row(parts, name, what)
    if row.size != entries:
        raise SceneError(f"{what} has {entries} data and {row.size} {name}; one is needed for each entry")
    if not entries:
        return np.zeros(0, np.int64)
    return index_of_entries(_whole(parts, name, what), count, f"the part {name!r} of {what}")


def index_of_entries(index: np.ndarray, count: int, what: str) -> np.ndarray:
    """Return rows or columns of entries, counted from 0, as whole numbers; raise unless all are below `count`."""
    bad = np.flatnonzero(~((index >= 0) & (index < count) & (index == np.floor(index))))
    if bad.size:
        raise SceneError(
            f"{what}: entry number {bad[0] + 1} is in the row or column {index[bad[0]]:g}, counted from 0; there are "
            f"{count}"
        )
    return index.astype(np.int64)
