"""The store of a sweep: a folder that keeps every finished case even if the process is killed.

``sweep.json`` identifies the sweep. Every run of the sweep appends its finished cases to a file of its own,
``cases-<n>.bin``, one record each; an incomplete record fails its checksum and is ignored. When all are there,
``result.nc`` (netCDF 3) replaces these files. Whole files appear by renaming.
"""

import contextlib
import json
import os
import zlib
from pathlib import Path

import numpy as np

from symfric.errors import RunFailed, SceneError
from symfric.files import PART, write_whole

_FORMAT = 1
ABOUT, RESULT = "sweep.json", "result.nc"


class Store:
    """Store of finished cases on disk; appending is thread-safe.

    Parameters
    ----------
    path : str or Path
        A folder, made if it is missing.
    about : dict
        'sweep' and 'code', hashes that must agree with those on disk, and further information for readers.
    width : int
        Number of output values of a case.

    Raises
    ------
    SceneError
        If the folder holds anything else, another sweep, or cannot be written.
    """

    def __init__(self, path: str | Path, about: dict, width: int):
        self.path = Path(path)
        self._record = np.dtype([("case", "<i8"), ("status", "<i8"), ("values", "<f8", (width,)), ("sum", "<u8")])
        self._file: int | None = None
        try:
            self._claim({"format": _FORMAT, "numbers": width, **about})
        except (OSError, ValueError) as error:
            if isinstance(error, SceneError):
                raise
            reason = getattr(error, "strerror", None) or error
            raise SceneError(f"cannot write to {self.path} ({reason}); name another folder as the store") from None

    def _claim(self, about: dict) -> None:
        """Create the folder for this sweep, or check that it belongs to it."""
        if self.path.exists() and not self.path.is_dir():
            raise SceneError(f"{self.path} is a file; the store of a sweep is a folder")
        self.path.mkdir(parents=True, exist_ok=True)
        place = self.path / ABOUT
        if not place.exists():
            if any(not p.name.endswith(PART) for p in self.path.iterdir()):
                raise SceneError(f"{self.path} holds other files but no sweep; name another folder as the store")
            write_whole(place, json.dumps(about, indent=2).encode())
            return
        present = read_about(self.path)
        if present.get("format") != _FORMAT or present.get("code") != about["code"]:
            raise SceneError(
                f"{self.path} holds a sweep made by another version of symfric, whose last digits may differ; "
                "name another store, or remove it"
            )
        if present.get("sweep") != about["sweep"]:
            raise SceneError(
                f"{self.path} holds another sweep, over {present.get('axes', '?')}; name another store, or remove it"
            )

    @property
    def complete(self) -> bool:
        """Whether the final result exists."""
        return (self.path / RESULT).exists()

    def read(self, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return which of `size` cases are finished, their status, and their values, shape (size, width)."""
        done = np.zeros(size, dtype=bool)
        status = np.zeros(size, dtype=np.int32)
        values = np.full((size, self._record["values"].shape[0]), np.nan)
        for place in sorted(self.path.glob("cases-*.bin")):
            data = place.read_bytes()
            rows = np.frombuffer(data, self._record, len(data) // self._record.itemsize)
            step = self._record.itemsize - 8
            for k, row in enumerate(rows):
                begin = k * self._record.itemsize
                whole = zlib.crc32(data[begin : begin + step]) == row["sum"]
                if whole and 0 <= row["case"] < size:
                    case = row["case"]
                    done[case], status[case], values[case] = True, row["status"], row["values"]
        return done, status, values

    def append(self, cases: np.ndarray, status: np.ndarray, values: np.ndarray) -> None:
        """Write finished cases (n,), with numbers (n, width), to the file that `open` made."""
        assert self._file is not None
        records = np.zeros(cases.size, self._record)
        records["case"], records["status"], records["values"] = cases, status, values
        data, size = records.tobytes(), self._record.itemsize
        records["sum"] = [zlib.crc32(data[k : k + size - 8]) for k in range(0, len(data), size)]
        data = records.tobytes()
        try:
            written = os.write(self._file, data)
        except OSError as error:
            raise RunFailed(f"cannot write to {self.path} ({error.strerror}); make room and run it again") from None
        if written != len(data):
            raise RunFailed(f"{self.path} is full; make room and run it again")

    def open(self) -> None:
        """Open this run's own file, before threads append."""
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | getattr(os, "O_BINARY", 0)
        number = 0
        while self._file is None:
            with contextlib.suppress(FileExistsError):
                self._file = os.open(self.path / f"cases-{number:04d}.bin", flags, 0o666)
            number += 1

    def close(self) -> None:
        """Close this run's file."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def finish(self, result) -> None:
        """Write the result, an xarray.Dataset, and remove the files of single cases."""
        self.close()
        try:
            write_whole(self.path / RESULT, bytes(result.to_netcdf(engine="scipy")))
            for place in (*self.path.glob("cases-*.bin"), *self.path.glob(f"*{PART}")):
                place.unlink(missing_ok=True)
        except OSError as error:
            raise RunFailed(f"cannot write to {self.path} ({error.strerror}); make room and run it again") from None

    def result(self):
        """Return the stored result, an xarray.Dataset."""
        import xarray as xr

        place = self.path / RESULT
        try:
            with xr.open_dataset(place, engine="scipy") as found:
                return found.load()
        except (OSError, ValueError, TypeError, KeyError, IndexError) as error:
            raise SceneError(f"{place} cannot be read ({error}); remove it to compute the sweep again") from None


def read_about(path: Path) -> dict:
    """Return the contents of ``sweep.json``."""
    place = Path(path) / ABOUT
    try:
        found = json.loads(place.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        found = None
    if not isinstance(found, dict):
        raise SceneError(f"{place} cannot be read; remove the folder, or name another store")
    return found


def records_in(path: Path) -> int | None:
    """Return about how many cases an unfinished store holds; None if it is finished or not a store."""
    path = Path(path)
    if not (path / ABOUT).exists() or (path / RESULT).exists():
        return None
    numbers = read_about(path).get("numbers")
    size = sum(p.stat().st_size for p in path.glob("cases-*.bin"))
    return size // (8 * (3 + numbers)) if isinstance(numbers, int) and numbers > 0 else None


def clear(path: Path) -> None:
    """Remove the files of a store and no others."""
    path = Path(path)
    if (path / ABOUT).exists():
        for place in (*path.glob("cases-*.bin"), *path.glob(f"*{PART}"), path / RESULT, path / ABOUT):
            place.unlink(missing_ok=True)
