"""Structures in files: .npz of NumPy or SciPy, or Matrix Market files in a folder or a zip."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from symfric.errors import SceneError
from symfric.files import open_regular, read_regular
from symfric.model.arguments import instance, path_of
from symfric.spelling import spelt
from symfric.structures.archives import MAX_FILE, content, entry_called, opened, reported
from symfric.structures.matrix_market import market
from symfric.structures.stored_arrays import read_arrays
from symfric.structures.structure import Structure

_NAMES = ("M", "K", "C", "friction")
_ENDINGS = (".mtx", ".mtx.gz")
_LABELS = "names.txt"


@spelt
def read(path: str | os.PathLike[str]) -> Structure:
    """Read a structure from a file or a folder.

    Parameters
    ----------
    path : str or Path
        A .npz with the arrays ``M``, ``K`` and, if there are any, ``C``, ``friction`` and ``names``, dense or sparse:
        entries ``M_data``, ``M_indices``, ``M_indptr``, ``M_shape`` (compressed rows), or ``M_data``, ``M_row``,
        ``M_col``, ``M_shape``. Or a folder or zip with ``M.mtx``, ``K.mtx``, ``C.mtx``, ``friction.mtx`` (Matrix
        Market, also gzipped) and ``names.txt``, one name a line. Nothing else in it is read. At most 2 million degrees
        of freedom, 50 million stored entries a matrix and 1 GiB a file.

    Returns
    -------
    Structure

    Raises
    ------
    SceneError
        If it cannot be read, M or K is missing, what it states disagrees with its data, it is larger than that, or a
        matrix is at fault; see `Structure`.

    Examples
    --------
    >>> import tempfile, numpy as np, symfric as sf
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     np.savez(folder + "/two.npz", M=np.eye(2), K=[[2.0, -1.0], [-1.0, 2.0]])
    ...     sf.structures.read(folder + "/two.npz").n
    2
    """
    place = path_of(path)
    if place.is_dir():
        parts = _folder(place)
    elif not place.exists():
        raise SceneError(f"there is no file or folder {place}")
    elif place.suffix == ".npz":
        parts = read_arrays(place, _NAMES)
    elif _is_zip(place):
        parts = _zip(place)
    else:
        raise SceneError(f"{place.name} is neither .npz nor a folder or zip of Matrix Market files")
    missing = [name for name in ("M", "K") if name not in parts]
    if missing:
        have = ", ".join(sorted(parts)) or "none"
        raise SceneError(f"{place.name} holds no matrix {missing[0]}; it holds: {have}")
    return Structure(**parts)


@spelt
def write(structure: Structure, path: str | os.PathLike[str]) -> None:
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
    instance(structure, Structure, "structure")
    entries: dict[str, Any] = {"names": np.array(structure.names)}
    for name in _NAMES:
        part = getattr(structure, name)
        if part is not None:
            entries |= {f"{name}_{what}": getattr(part, what) for what in ("data", "indices", "indptr")}
            entries[f"{name}_shape"] = np.array(part.shape)
    np.savez_compressed(path_of(path), **entries)


def _is_zip(place: Path) -> bool:
    with reported(place.name), open_regular(place) as file:
        return file.read(2) == b"PK"


def _folder(place: Path) -> dict[str, Any]:
    def load(names: tuple[str, ...]) -> tuple[str, bytes] | None:
        present = [name for name in names if (place / name).exists()]
        if len(present) > 1:
            raise SceneError(f"{place.name} holds {present[0]} and {present[1]}; keep one of them")
        return (present[0], read_regular(place / present[0], MAX_FILE)) if present else None

    return _parts(place.name, load)


def _zip(place: Path) -> dict[str, Any]:
    with opened(place) as file:

        def load(names: tuple[str, ...]) -> tuple[str, bytes] | None:
            entry = entry_called(file, names, place.name, flat=False)
            return None if entry is None else (entry.filename, content(file, entry))

        return _parts(place.name, load)


def _parts(source: str, load: Callable[[tuple[str, ...]], tuple[str, bytes] | None]) -> dict[str, Any]:
    """Return the matrices and names of a folder or archive; `load` returns the content of one of some files."""
    parts: dict[str, Any] = {}
    for name in _NAMES:
        with reported(f"{name}.mtx in {source}"):
            loaded = load(tuple(name + ending for ending in _ENDINGS))
            if loaded is not None:
                parts[name] = market(loaded[1], loaded[0])
    with reported(f"{_LABELS} in {source}"):
        loaded = load((_LABELS,))
        if loaded is not None:
            parts["names"] = [e.strip() for e in loaded[1].decode("utf-8-sig").splitlines() if e.strip()]
    return parts
