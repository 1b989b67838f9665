"""Matrix Market files: what a header claims is checked against the length of the file before it is read."""

import gzip
import inspect
import io

import numpy as np
import scipy.io
import scipy.sparse as sps

from symfric.errors import SceneError
from symfric.files import read_at_most
from symfric.structures.archives import MAX_FILE
from symfric.structures.stored_arrays import check_size

_HEAD = 1 << 16  # bytes in which the line of sizes must begin
_SHORTEST = 2  # bytes of a number with the blank or line break behind it
# newer SciPy asks which kind of sparse matrix is wanted, older does not know the argument
_KIND = {"spmatrix": False} if "spmatrix" in inspect.signature(scipy.io.mmread).parameters else {}


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
        If it is larger than allowed, or its header claims what the rest cannot hold; other faults are errors of
        `symfric.structures.archives.BROKEN`.
    """
    if name.endswith(".gz"):
        data = read_at_most(gzip.GzipFile(fileobj=io.BytesIO(data)), MAX_FILE)  # type: ignore[arg-type]
    if len(data) > MAX_FILE:
        raise SceneError(f"{name} is larger than {MAX_FILE >> 20} MiB; reduce the structure before")
    _check_claims(data, name)
    return scipy.io.mmread(io.BytesIO(data), **_KIND)


def _check_claims(data: bytes, name: str) -> None:
    """Raise if the header is none, or the entries that it announces need more than the bytes that are there."""
    lines = io.BytesIO(data[:_HEAD])
    banner = lines.readline(1000).decode("latin-1").lower().split()
    if len(banner) < 4 or banner[:2] != ["%%matrixmarket", "matrix"] or banner[2] not in ("coordinate", "array"):
        raise SceneError(
            f"{name} is no Matrix Market file: it must begin with %%MatrixMarket matrix coordinate or array"
        )
    line = next((e for e in lines if e.strip() and not e.lstrip().startswith(b"%")), b"")
    sizes = line.split()
    scattered = banner[2] == "coordinate"
    if len(sizes) != 2 + scattered or not all(e.isdigit() and len(e) < 19 for e in sizes):
        raise SceneError(f"{name} is no Matrix Market file: its line of sizes is not {2 + scattered} whole numbers")
    rows, columns, *stated = map(int, sizes)
    check_size(rows, columns, 0, name)
    entries = stated[0] if stated else rows * columns
    check_size(rows, columns, entries, name)
    stored = entries if stated or "general" in banner else rows * max(0, rows - 1) // 2
    numbers = stored * (3 if stated and "pattern" not in banner else 2 if stated else 1)
    if numbers * _SHORTEST > len(data) + 1:
        raise SceneError(f"{name} is truncated: its line of sizes announces {stored} entries; write it anew")
