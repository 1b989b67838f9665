"""Structures in files: .npz of NumPy or SciPy, or Matrix Market files in a folder or a zip."""

import inspect
import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
import scipy.sparse as sps

from symfric.errors import SceneError
from symfric.structures.structure import Structure

_NAMES = ("M", "K", "C", "friction")
_PARTS = ("data", "indices", "indptr", "row", "col", "shape", "format")
_ENDINGS = (".mtx", ".mtx.gz")
# newer SciPy asks which kind of sparse matrix is wanted, older does not know the argument
_KIND = {"spmatrix": False} if "spmatrix" in inspect.signature(scipy.io.mmread).parameters else {}


def read(path) -> Structure:
    """Read a structure from a file or a folder.

    Parameters
    ----------
    path : str or Path
        A .npz with the arrays ``M``, ``K`` and, if there are any, ``C``, ``friction`` and ``names``, dense or sparse:
        entries ``M_data``, ``M_indices``, ``M_indptr``, ``M_shape`` (compressed rows), or ``M_data``, ``M_row``,
        ``M_col``, ``M_shape``. Or a folder or zip with ``M.mtx``, ``K.mtx``, ``C.mtx``, ``friction.mtx`` (Matrix
        Market, also gzipped) and ``names.txt``, one name a line.

    Returns
    -------
    Structure

    Raises
    ------
    SceneError
        If it cannot be read, M or K is missing, or a matrix is at fault; see `Structure`.

    Examples
    --------
    >>> import tempfile, numpy as np, symfric as sf
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.savez(folder + "/two.npz", M=np.eye(2), K=[[2.0, -1.0], [-1.0, 2.0]])
    ...     sf.structures.read(folder + "/two.npz").n
    2
    """
    place = Path(path)
    if place.is_dir():
        found = _folder(place)
    elif not place.is_file():
        raise SceneError(f"there is no file or folder {place}")
    elif place.suffix == ".npz":
        found = _numpy(place)
    elif zipfile.is_zipfile(place):
        found = _zip(place)
    else:
        raise SceneError(f"{place.name} is neither .npz nor a folder or zip of Matrix Market files")
    missing = [name for name in ("M", "K") if name not in found]
    if missing:
        have = ", ".join(sorted(found)) or "none"
        raise SceneError(f"{place.name} holds no matrix {missing[0]}; it holds: {have}")
    return Structure(**found)


def write(structure: Structure, path) -> None:
    """Write a structure as .npz, which `read` takes.

    Parameters
    ----------
    structure : Structure
    path : str or Path

    Examples
    --------
    >>> import symfric as sf
    >>> chain = sf.structures.chain(20, damping=0.02)
    >>> sf.structures.write(chain, "chain.npz")
    >>> sf.structures.read("chain.npz").n
    20
    """
    entries: dict[str, Any] = {"names": np.array(structure.names)}
    for name in _NAMES:
        part = getattr(structure, name)
        if part is not None:
            entries |= {f"{name}_{what}": getattr(part, what) for what in ("data", "indices", "indptr")}
            entries[f"{name}_shape"] = np.array(part.shape)
    np.savez_compressed(path, **entries)


def _numpy(place: Path) -> dict[str, Any]:
    try:
        with np.load(place, allow_pickle=False) as file:
            entries = {name: file[name] for name in file.files}
    except (ValueError, OSError, zipfile.BadZipFile) as error:
        raise SceneError(f"{place.name} cannot be read: {error}") from None
    found: dict[str, Any] = {name: entries[name] for name in _NAMES if name in entries}
    for name in _NAMES:
        parts = {what: entries[f"{name}_{what}"] for what in _PARTS if f"{name}_{what}" in entries}
        if parts and name not in found:
            found[name] = _assembled(parts, f"{name} in {place.name}")
    if "names" in entries:
        found["names"] = [str(e) for e in np.atleast_1d(entries["names"])]
    return found


def _assembled(parts: dict[str, np.ndarray], what: str) -> sps.csr_array:
    try:
        shape = tuple(int(e) for e in parts["shape"])
        if "indptr" in parts:
            kind = sps.csc_array if "format" in parts and parts["format"].item() in ("csc", b"csc") else sps.csr_array
            return sps.csr_array(kind((parts["data"], parts["indices"], parts["indptr"]), shape=shape))
        return sps.csr_array(sps.coo_array((parts["data"], (parts["row"], parts["col"])), shape=shape))
    except (KeyError, ValueError, IndexError) as error:
        raise SceneError(f"{what} is no sparse matrix: {error}") from None


def _folder(place: Path) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in _NAMES:
        for ending in _ENDINGS:
            if (place / (name + ending)).is_file():
                found[name] = _market(str(place / (name + ending)), name + ending)
    if (place / "names.txt").is_file():
        found["names"] = _lines((place / "names.txt").read_text(encoding="utf-8"))
    return found


def _zip(place: Path) -> dict[str, Any]:
    found: dict[str, Any] = {}
    with zipfile.ZipFile(place) as file:
        for entry in file.namelist():
            base = entry.rsplit("/", 1)[-1]
            name = base.split(".", 1)[0]
            if name in _NAMES and base == f"{name}.mtx":
                found[name] = _market(io.BytesIO(file.read(entry)), base)
            elif base == "names.txt":
                found["names"] = _lines(file.read(entry).decode("utf-8"))
    return found


def _market(source, name: str):
    try:
        return scipy.io.mmread(source, **_KIND)
    except (ValueError, OverflowError, OSError, EOFError) as error:
        raise SceneError(f"{name} is no Matrix Market file: {error}") from None


def _lines(text: str) -> list[str]:
    return [line.strip() for line in text.splitlines() if line.strip()]
