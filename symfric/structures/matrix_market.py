"""Matrix Market files: what a header claims is checked against the length of the file before it is read.

The body is read by `numpy.loadtxt`: `scipy.io.mmread` writes beyond its array where more numbers follow than announced.
"""

import gzip
import io

import numpy as np
import scipy.sparse as sps

from symfric.errors import SceneError
from symfric.files import read_at_most
from symfric.structures.archives import MAX_FILE
from symfric.structures.stored_arrays import check_size, index_of_entries

_HEAD = 1 << 16  # bytes in which the line of sizes must end
_SHORTEST = 2  # bytes of a number with the blank or line break behind it
_FIELDS = ("real", "double", "integer", "unsigned-integer", "pattern")
_SIGNS = {"general": 0, "symmetric": 1, "hermitian": 1, "skew-symmetric": -1}  # of the entry across the diagonal


def market(data: bytes, name: str) -> np.ndarray | sps.sparray:
    """Return the matrix in the content of a Matrix Market file.

    Parameters
    ----------
    data : bytes
    name : str
        Of the file; one that ends in .gz is unpacked.

    Raises
    ------
    SceneError
        If it is larger than allowed, or its header claims what the rest does not hold; other faults are errors of
        `symfric.structures.archives.BROKEN`.
    """
    if name.endswith(".gz"):
        data = read_at_most(gzip.GzipFile(fileobj=io.BytesIO(data)), MAX_FILE)  # type: ignore[arg-type]
    if len(data) > MAX_FILE:
        raise SceneError(f"{name} is larger than {MAX_FILE >> 20} MiB; reduce the structure before")
    lines = io.BytesIO(data)
    form, field, symmetry = _banner(lines, name)
    line = next((e for e in lines if (e.strip() and not e.lstrip().startswith(b"%")) or lines.tell() > _HEAD), b"")
    sizes = line.split()
    scattered = form == "coordinate"
    if len(sizes) != 2 + scattered or not all(e.isdigit() and len(e) < 19 for e in sizes):
        raise SceneError(f"{name} is no Matrix Market file: its line of sizes is not {2 + scattered} whole numbers")
    rows, columns, *stated = map(int, sizes)
    check_size(rows, columns, 0, name)
    if _SIGNS[symmetry] and rows != columns:
        raise SceneError(f"{name} is called {symmetry} and has the shape ({rows}, {columns}); it must be square")
    if stated:
        width = 2 if field == "pattern" else 3
        table = _numbers(lines, stated[0], width, len(data), name)
        return _scattered(table, (rows, columns), _SIGNS[symmetry], name)
    check_size(rows, columns, rows * columns, name)
    return _full(lines, (rows, columns), _SIGNS[symmetry], len(data), name)


def _banner(lines: io.BytesIO, name: str) -> tuple[str, str, str]:
    """Return the format, field and symmetry in the first line."""
    words = lines.readline(1000).decode("latin-1").lower().split()
    if words[:2] != ["%%matrixmarket", "matrix"] or len(words) != 5 or words[2] not in ("coordinate", "array"):
        raise SceneError(f"{name} is no Matrix Market file: it begins with %%MatrixMarket matrix coordinate or array")
    _, _, form, field, symmetry = words
    if field == "complex":
        raise SceneError(f"{name} is complex; give real matrices, structural damping as an equivalent C")
    if field not in _FIELDS[: 5 if form == "coordinate" else 4] or symmetry not in _SIGNS:
        raise SceneError(f"{name} is no Matrix Market file: its first line must end in real general or real symmetric")
    return form, field, symmetry


def _numbers(lines: io.BytesIO, count: int, width: int, length: int, name: str) -> np.ndarray:
    """Return the numbers of the rest of a file, shape (count, width)."""
    check_size(0, 0, count, name)
    if count * width * _SHORTEST > length + 1:
        raise SceneError(f"{name} is truncated: its line of sizes announces {count} entries; write it anew")
    if not lines.getbuffer()[lines.tell() :].tobytes().strip():
        numbers = np.zeros((0, width))
    else:
        numbers = np.loadtxt(lines, comments="%", ndmin=2, max_rows=count + 1, encoding="latin-1")
    if numbers.shape != (count, width):
        raise SceneError(
            f"{name} does not hold {count} lines of {width} numbers, as its line of sizes announces; write it anew"
        )
    return numbers


def _scattered(table: np.ndarray, shape: tuple[int, int], sign: int, name: str) -> sps.csr_array:
    """Return a matrix of lines with row, column and value, counted from 1; without value it is 1."""
    row, column = (index_of_entries(table[:, k] - 1, n, name) for k, n in enumerate(shape))
    value = table[:, 2] if table.shape[1] == 3 else np.ones(row.size)
    across = np.flatnonzero(row != column) if sign else np.zeros(0, dtype=int)
    entries = np.concatenate((value, sign * value[across]))
    places = np.concatenate((row, column[across])), np.concatenate((column, row[across]))
    return sps.csr_array(sps.coo_array((entries, places), shape=shape))


def _full(lines: io.BytesIO, shape: tuple[int, int], sign: int, length: int, name: str) -> np.ndarray:
    """Return a matrix of numbers column by column; of a symmetric one those from the diagonal on down."""
    if not sign:
        return _numbers(lines, shape[0] * shape[1], 1, length, name).reshape(shape, order="F")
    begin = 0 if sign > 0 else 1
    column, row = np.triu_indices(shape[0], begin)
    A = np.zeros(shape)
    A[row, column] = _numbers(lines, row.size, 1, length, name)[:, 0]
    A[column, row] = sign * A[row, column]
    return A
