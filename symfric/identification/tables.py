"""Records in files: columns of text, or an array of NumPy. Messages name the file, line and column, never the content.

A scene file from another source may name any file of its user as a record.
"""

import csv
import io
import itertools
import re
from array import array
from pathlib import Path
from typing import Any

import numpy as np

from symfric.array_files import array_of
from symfric.errors import SceneError
from symfric.files import read_regular

MAX_BYTES = 200_000_000
MAX_COLUMNS = 1000
_NUMBER = re.compile(r"\s*[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|inf(?:inity)?|nan)\s*", re.ASCII | re.IGNORECASE)
_STRANGE = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")

Table = dict[str, tuple[np.ndarray, np.ndarray]]


def read_table(path: str | Path) -> Table:
    """Read records from a file: an array of NumPy if it ends in .npy, text otherwise.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    dict of str to (t, y)
        One record for each column after the first, which is time; samples that are empty or NaN are left out of it.

    Raises
    ------
    SceneError
        If the file cannot be read or is no table with names.
    """
    place = Path(path)
    try:
        data = read_regular(place, MAX_BYTES)
    except OSError as error:
        raise SceneError(f"{place.name}: cannot be read ({error.strerror or error})") from None
    if len(data) > MAX_BYTES:
        raise SceneError(f"{place.name}: is larger than {MAX_BYTES // 1_000_000} MB; keep fewer samples")
    if not data.strip():
        raise SceneError(f"{place.name}: is empty; the first line must hold names, then come numbers")
    names, columns = (_of_array if place.suffix.lower() == ".npy" else _of_text)(data, place.name)
    t, series = columns[0], {}
    for name, y in zip(names[1:], columns[1:], strict=True):
        there = ~np.isnan(y)
        series[name] = t[there], y[there]
    return series


def _of_array(data: bytes, shown: str) -> tuple[list[str], list[np.ndarray]]:
    """Return the names and columns of an array with named fields, or of one of shape (n, m): t, c1, c2, ..."""
    array = array_of(data, shown)
    if array.dtype.names is not None and array.ndim == 1:
        names = list(array.dtype.names)
        parts = [array[name] for name in names]
    elif array.dtype.names is None and array.ndim == 2:
        names = ["t", *(f"c{k}" for k in range(1, array.shape[1]))]
        parts = list(array.T)
    else:
        raise SceneError(f"{shown}: has shape {array.shape}; give columns, the first of them times, shape (n, m)")
    _check_names(names, shown)
    if any(part.dtype.kind not in "fiu" for part in parts):
        raise SceneError(f"{shown}: holds other things than real numbers; save numbers alone")
    return names, [part.astype(float) for part in parts]


def _of_text(data: bytes, shown: str) -> tuple[list[str], list[np.ndarray]]:
    """Return the names and columns of a text: a line of names, then numbers."""
    strange = _STRANGE.search(data)
    if strange:
        line = data.count(b"\n", 0, strange.start()) + 1
        raise SceneError(f"{shown}: cannot be read (line {line} is binary); export the record as text")
    try:
        rows = _rows(data)
        names = [name.strip() for name in next(rows, [])]
        _check_names(names, shown)
        columns = [array("d") for _ in names]
        for number, row in enumerate(rows, 2):
            if not row:
                continue
            if len(row) != len(names):
                raise SceneError(f"{shown}: line {number} has {len(row)} fields where the first has {len(names)}")
            for k, (column, field) in enumerate(zip(columns, row, strict=True), 1):
                if not _NUMBER.fullmatch(field) and field.strip():
                    raise SceneError(f"{shown}: what line {number} holds in column {k} is not a number; mend the line")
                column.append(float(field) if field.strip() else np.nan)
    except UnicodeDecodeError:
        raise SceneError(f"{shown}: cannot be read (it is not text); save it as UTF-8") from None
    except csv.Error as error:
        raise SceneError(f"{shown}: cannot be read ({error}); mend its quotes") from None
    return names, [np.array(column) for column in columns]


def _rows(data: bytes) -> Any:
    """Yield the fields of each line; split at the comma, semicolon or tab that the first has most, else blanks."""
    stream = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8-sig", newline="")
    head = stream.readline()
    marks = [mark for mark in (",", ";", "\t") if mark in head]
    if not marks:
        yield from (row.split() for row in itertools.chain([head], stream))
        return
    split = max(marks, key=head.count)
    yield next(csv.reader([head], delimiter=split), [])
    yield from csv.reader(stream, delimiter=split)


def _check_names(names: list[str], shown: str) -> None:
    if len(names) < 2 or any(_NUMBER.fullmatch(name) for name in names):
        raise SceneError(f"{shown}: the first line must hold names, such as 't, x'; time is the first column")
    if len(names) > MAX_COLUMNS:
        raise SceneError(f"{shown}: has {len(names)} columns; keep at most {MAX_COLUMNS}")
    if len(set(names)) < len(names):
        raise SceneError(f"{shown}: two columns have the same name; rename one")
