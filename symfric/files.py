"""Write files atomically, so that a file appears complete or not at all; read only regular files of limited size."""

import contextlib
import errno
import os
import secrets
import stat
import time
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

PART = ".part"  # suffix of a file that is still being written
_CHUNK = 1 << 20  # bytes read at a time
_ABANDONED = 3600.0  # s; age after which an unfinished file belongs to no living process


def open_regular(place: str | Path) -> BinaryIO:
    """Open a regular file for reading, without waiting for a writer as a named pipe would.

    Parameters
    ----------
    place : str or Path

    Returns
    -------
    binary stream

    Raises
    ------
    OSError
        If it is missing, cannot be read, or is a folder, a pipe, a socket or a device.
    """
    flags = os.O_RDONLY | sum(getattr(os, name, 0) for name in ("O_NONBLOCK", "O_NOCTTY", "O_BINARY", "O_CLOEXEC"))
    try:
        _demand_regular(os.stat(place))  # before it is opened, which alone changes some devices
        number = os.open(place, flags)
    except ValueError as error:  # a null byte in the path
        raise OSError(errno.EINVAL, str(error)) from None
    try:
        _demand_regular(os.fstat(number))
        return os.fdopen(number, "rb")
    except BaseException:
        os.close(number)
        raise


def _demand_regular(state: os.stat_result) -> None:
    if stat.S_ISDIR(state.st_mode):
        raise IsADirectoryError(errno.EISDIR, "it is a folder")
    if not stat.S_ISREG(state.st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file")


def read_regular(place: str | Path, most: int) -> bytes:
    """Return the content of a regular file; of one larger than `most` bytes somewhat more than `most` of them.

    Parameters
    ----------
    place : str or Path
    most : int

    Returns
    -------
    bytes

    Raises
    ------
    OSError
        As `open_regular`.
    """
    with open_regular(place) as stream:
        return read_at_most(stream, most)


def read_at_most(stream: BinaryIO, most: int) -> bytes:
    """Return the rest of a stream; of one longer than `most` bytes somewhat more than `most` of them.

    Parameters
    ----------
    stream : binary stream
    most : int

    Returns
    -------
    bytes
    """
    parts, size = [], 0
    while size <= most and (part := stream.read(_CHUNK)):
        parts.append(part)
        size += len(part)
    return b"".join(parts)


def remove_abandoned(folder: Path) -> None:
    """Remove unfinished files that a killed process left; those of living processes are younger."""
    for place in folder.glob(f"*{PART}"):
        with contextlib.suppress(OSError):
            if time.time() - place.stat().st_mtime > _ABANDONED:
                place.unlink()


def write_new(place: Path, data: bytes) -> bool:
    """Write a file that does not exist yet, complete or not at all; of several processes one succeeds.

    Parameters
    ----------
    place : Path
    data : bytes

    Returns
    -------
    bool
        False if the file exists already.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    part = place.with_name(f".{secrets.token_hex(8)}{PART}")
    try:
        with open(part, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        try:
            os.rename(part, place) if os.name == "nt" else os.link(part, place)
        except FileExistsError:
            return False
        except OSError:  # a file system without links
            if place.exists():
                return False
            os.replace(part, place)
        return True
    finally:
        with contextlib.suppress(OSError):
            part.unlink()


def write_whole(place: Path, data: bytes | str, mode: int = 0o666, durable: bool = True) -> None:
    """Write one file atomically; see `write_together`."""
    write_together({place: data}, mode, durable)


def write_together(files: Mapping[Path, bytes | str], mode: int = 0o666, durable: bool = True) -> None:
    """Write several files atomically: to temporary names first, renamed when all are complete.

    Parameters
    ----------
    files : mapping of Path to bytes or str
        Text is written as UTF-8; what UTF-8 lacks, such as undecodable bytes of a file's name, becomes a question mark.
    mode : int
        Permissions of the new files, before the process's mask.
    durable : bool
        Whether the data reach the disk before the old files are replaced, so that a power cut loses neither.

    Raises
    ------
    OSError
        If one of them cannot be written. Then the old files are as they were, and no part is left.
    """
    parts: dict[Path, Path] = {}
    try:
        for place, data in files.items():
            if not place.parent.is_dir():
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(place.parent))
            part = place.with_name(f".{secrets.token_hex(8)}{PART}")
            content = data.encode("utf-8", "replace") if isinstance(data, str) else data
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
            parts[part] = place
            with os.fdopen(os.open(part, flags, mode), "wb") as file:
                file.write(content)
                if durable:
                    file.flush()
                    os.fsync(file.fileno())
        for part, place in parts.items():
            os.replace(part, place)
    finally:
        for part in parts:
            with contextlib.suppress(OSError):
                part.unlink()
