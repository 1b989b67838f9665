"""The store of a sweep: a folder that keeps every finished case even if the process is killed.

``sweep.json`` identifies the sweep. Every run of the sweep appends its finished cases to a file of its own,
``cases-<n>.bin``, one record each; an incomplete record fails its checksum and is ignored. When all are there,
``result.nc`` (netCDF 3) replaces these files. Whole files appear by renaming. The checksums of the records and of the
result cover the identity of the sweep too, so that files of another sweep are not taken for its own.
"""

import contextlib
import hashlib
import io
import json
import os
import re
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.errors import RunFailed, SceneError
from symfric.files import PART, read_regular, remove_abandoned, write_new, write_whole

if TYPE_CHECKING:
    import xarray as xr

_FORMAT = 2
_MAX_ABOUT = 10_000_000  # bytes of the description
_MAX_DATA = 1 << 33  # bytes of the cases of one run, and of the result
_SEAL = "sha256:"  # begin of the attribute with the checksum of the result, which counts as zeros in it
_OPEN_SEAL = _SEAL.encode() + b"0" * 64
_FOUND_SEAL = re.compile(_SEAL.encode() + rb"([0-9a-f]{64})")
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

    def __init__(self, path: str | Path, about: dict[str, Any], width: int):
        self.path = Path(path)
        self._record = np.dtype([("case", "<i8"), ("status", "<i8"), ("values", "<f8", (width,)), ("sum", "<u8")])
        self._file: int | None = None
        self._identity = f"{about['sweep']} {about['code']} {width}".encode()
        self._seed = zlib.crc32(self._identity)
        try:
            self._claim({"format": _FORMAT, "numbers": width, **about})
        except (OSError, ValueError) as error:
            if isinstance(error, SceneError):
                raise
            reason = getattr(error, "strerror", None) or error
            raise SceneError(f"cannot write to {self.path} ({reason}); name another folder as the store") from None

    def _claim(self, about: dict[str, Any]) -> None:
        """Create the folder for this sweep, or check that it belongs to it."""
        if self.path.exists() and not self.path.is_dir():
            raise SceneError(f"{self.path} is a file; the store of a sweep is a folder")
        self.path.mkdir(parents=True, exist_ok=True)
        place = self.path / ABOUT
        if not place.exists():
            others = [p.name for p in self.path.iterdir() if not p.name.endswith(PART)]
            if set(others) - {ABOUT}:  # which another process may have written meanwhile
                raise SceneError(f"{self.path} holds other files but no sweep; name another folder as the store")
            if write_new(place, json.dumps(about, indent=2).encode()):
                return
        present = read_about(self.path)
        if present.get("format") != _FORMAT or present.get("code") != about["code"]:
            raise SceneError(
                f"{self.path} holds a sweep made by another version of symfric, whose last digits may differ; "
                "name another store, or remove it"
            )
        if present.get("sweep") != about["sweep"]:
            raise SceneError(
                f"{self.path} holds another sweep, over {str(present.get('axes', '?'))[:200]}; name another store, or "
                "remove it"
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
            data = self._content(place)
            rows = np.frombuffer(data, self._record, len(data) // self._record.itemsize)
            step = self._record.itemsize - 8
            for k, row in enumerate(rows):
                begin = k * self._record.itemsize
                whole = zlib.crc32(data[begin : begin + step], self._seed) == row["sum"]
                if whole and 0 <= row["case"] < size:
                    case = row["case"]
                    done[case], status[case], values[case] = True, row["status"], row["values"]
        return done, status, values

    def _content(self, place: Path) -> bytes:
        """Return a file of the store; empty if another process that finished the sweep has removed it."""
        try:
            data = read_regular(place, _MAX_DATA)
        except FileNotFoundError:
            return b""
        except OSError as error:
            raise SceneError(f"{place} cannot be read ({error.strerror}); remove it, or name another store") from None
        if len(data) > _MAX_DATA:
            raise SceneError(f"{place} is larger than {_MAX_DATA >> 30} GiB; remove it, or name another store")
        return data

    def append(self, cases: np.ndarray, status: np.ndarray, values: np.ndarray) -> None:
        """Write finished cases (n,), with numbers (n, width), to the file that `open` made."""
        assert self._file is not None
        records = np.zeros(cases.size, self._record)
        records["case"], records["status"], records["values"] = cases, status, values
        data, size = records.tobytes(), self._record.itemsize
        records["sum"] = [zlib.crc32(data[k : k + size - 8], self._seed) for k in range(0, len(data), size)]
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

    def finish(self, result: "xr.Dataset") -> None:
        """Write the result, and remove the files of single cases."""
        self.close()
        data = bytes(result.assign_attrs(checksum=_OPEN_SEAL.decode()).to_netcdf(engine="scipy"))
        seal = _SEAL.encode() + self._seal(data).encode()
        try:
            write_whole(self.path / RESULT, data.replace(_OPEN_SEAL, seal))
            for place in self.path.glob("cases-*.bin"):
                place.unlink(missing_ok=True)
            remove_abandoned(self.path)
        except OSError as error:
            raise RunFailed(f"cannot write to {self.path} ({error.strerror}); make room and run it again") from None

    def _seal(self, data: bytes) -> str:
        return hashlib.sha256(self._identity + b"\n" + data).hexdigest()

    def result(self) -> "xr.Dataset":
        """Return the stored result.

        Raises
        ------
        SceneError
            If it is damaged, or that of another sweep.
        """
        import xarray as xr

        place = self.path / RESULT
        data = self._content(place)
        seals = _FOUND_SEAL.findall(data)
        if not seals or seals[-1].decode() != self._seal(_FOUND_SEAL.sub(_OPEN_SEAL, data)):
            raise SceneError(
                f"{place} is damaged or of another sweep: its checksum does not agree; remove it to compute the sweep "
                "again"
            )
        with xr.open_dataset(io.BytesIO(data), engine="scipy") as opened:
            return opened.load()


def read_about(path: Path) -> dict[str, Any]:
    """Return the contents of ``sweep.json``."""
    place = Path(path) / ABOUT
    try:
        about = json.loads(read_regular(place, _MAX_ABOUT)[:_MAX_ABOUT].decode("utf-8"))
    except (OSError, ValueError, RecursionError):
        about = None
    if not isinstance(about, dict):
        raise SceneError(f"{place} cannot be read; remove the folder, or name another store")
    return about


def records_in(path: Path) -> int | None:
    """Return about how many cases an unfinished store holds; None if it is finished or not a store."""
    path = Path(path)
    if not (path / ABOUT).exists() or (path / RESULT).exists():
        return None
    numbers = read_about(path).get("numbers")
    size = 0
    for place in path.glob("cases-*.bin"):
        with contextlib.suppress(FileNotFoundError):  # removed by a process that finishes the sweep
            size += place.stat().st_size
    return size // (8 * (3 + numbers)) if isinstance(numbers, int) and numbers > 0 else None


def clear(path: Path) -> None:
    """Remove the files of a store and no others."""
    path = Path(path)
    if (path / ABOUT).exists():
        for place in (*path.glob("cases-*.bin"), *path.glob(f"*{PART}"), path / RESULT, path / ABOUT):
            place.unlink(missing_ok=True)
