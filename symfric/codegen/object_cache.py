"""Disk cache of machine code, of limited size; loads only files that no other user could have written."""

import contextlib
import hashlib
import logging
import os
import stat
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from symfric.files import PART, write_whole

CODE = ".o"  # suffix of an object file
LIMIT = 512.0  # default size limit, MiB; see SYMFRIC_CACHE_SIZE
_AFTER = 0.9  # size after removing old objects, relative to the limit
_LOOK = 1 / 64  # bytes stored between two checks of the folder's size, relative to the limit
_FRESH = 3600.0  # s; age after which the time of use is updated, and after which unfinished files are removed
_stored: dict[Path, float] = {}  # bytes stored by this process since its last check of each folder


def load(key: str) -> bytes | None:
    """Return an object, None if it is missing, damaged or not trusted.

    Its last 32 bytes are the hash of its key and the rest, which detects damage and the object of another key, not
    forgery. Therefore the folder and the file must belong to the user of this process and be writable by no other;
    where the system has no such owners, the folder below the user's profile is trusted.
    """
    with _trusted(_folder()) as folder:
        if folder is None:
            return None
        try:
            data = _read(folder, key + CODE)
        except OSError:
            return None
    body, seal = data[:-32], data[-32:]
    return body if _seal(key, body) == seal else None


def store(key: str, code: bytes) -> None:
    """Write an object to the cache atomically; failure to write is not an error."""
    place, limit = _folder(), _limit()
    if place is None or len(code) > limit:
        return
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        with _trusted(place) as folder:
            if folder is None:
                return
        write_whole(place / (key + CODE), code + _seal(key, code), mode=0o600, durable=False)
        _stored[place] = _stored.get(place, limit) + len(code)
        if _stored[place] > _LOOK * limit:
            _stored[place] = 0.0
            _make_room(place, limit)
    except OSError:
        return


def _seal(key: str, code: bytes) -> bytes:
    return hashlib.sha256(key.encode() + b"\n" + code).digest()


def _folder() -> Path | None:
    """Return ``SYMFRIC_CACHE_DIR`` if it is set and not empty, else the user's cache folder; None without a home."""
    given = os.environ.get("SYMFRIC_CACHE_DIR")
    return Path(given) if given else _default_folder()


def _default_folder() -> Path | None:
    from platformdirs import user_cache_path

    folder = user_cache_path("symfric", appauthor=False)
    return folder if folder.is_absolute() else None


def _limit() -> float:
    """Return the most bytes that the cache may hold: ``SYMFRIC_CACHE_SIZE`` in MiB."""
    given = os.environ.get("SYMFRIC_CACHE_SIZE") or LIMIT
    try:
        size = float(given)
    except ValueError:
        size = -1.0
    if not size >= 0:
        _say_once(f"SYMFRIC_CACHE_SIZE is {given!r}; it must be a number of MiB, and {LIMIT:g} is taken")
        size = LIMIT
    return 2**20 * size


@contextlib.contextmanager
def _trusted(place: Path | None) -> Iterator[int | Path | None]:
    """Yield the folder as a directory descriptor or path, None if it is missing or not trusted.

    On POSIX a descriptor is used, so that the folder that was checked is the one that is read.
    """
    if place is None or os.name != "posix":
        yield place if place is not None and place.is_dir() else None
        return
    try:
        link = place.lstat()
        folder = os.open(place, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        yield None
        return
    try:
        doubt = _doubt(os.fstat(folder))
        if not doubt and stat.S_ISLNK(link.st_mode) and link.st_uid != os.geteuid():
            doubt = "is a link of another user"
        if doubt:
            _say_once(
                f"compiled code is neither loaded nor kept: {place} {doubt}; "
                "make it yours alone (chmod 700), or name another in SYMFRIC_CACHE_DIR"
            )
        yield None if doubt else folder
    finally:
        os.close(folder)


def _doubt(state: os.stat_result) -> str:
    """Return why a file or folder is not trusted; empty if it is."""
    if state.st_uid != os.geteuid():
        return "belongs to another user"
    return "can be written by other users" if state.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else ""


def _read(folder: int | Path, name: str) -> bytes:
    """Return the content of a file, and update its time of use.

    Raises
    ------
    OSError
        If it cannot be read or is not trusted.
    """
    if not isinstance(folder, int):
        place = folder / name
        data = place.read_bytes()
        if time.time() - place.stat().st_mtime > _FRESH:
            with contextlib.suppress(OSError):
                os.utime(place)
        return data
    with os.fdopen(os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=folder), "rb") as file:
        state = os.fstat(file.fileno())
        if not stat.S_ISREG(state.st_mode) or _doubt(state):
            raise PermissionError(name)
        if time.time() - state.st_mtime > _FRESH:
            with contextlib.suppress(OSError):
                os.utime(file.fileno())
        return file.read()


def _make_room(place: Path, limit: float) -> None:
    """Remove the least recently used objects until the size is below the limit.

    Other processes may use the folder at the same time: open files stay readable, and missing objects are compiled
    again.
    """
    objects = []
    with os.scandir(place) as entries:
        for entry in entries:
            with contextlib.suppress(OSError):  # removed by another process
                state = entry.stat(follow_symlinks=False)
                if entry.name.endswith(CODE):
                    objects.append((state.st_mtime, state.st_size, entry.path))
                elif entry.name.endswith(PART) and time.time() - state.st_mtime > _FRESH:
                    os.unlink(entry.path)  # left by a process that was killed while writing
    total = sum(size for _, size, _ in objects)
    if total <= limit:
        return
    for _, size, path in sorted(objects):
        if total <= _AFTER * limit:
            return
        total -= size
        with contextlib.suppress(OSError):
            os.unlink(path)


@cache
def _say_once(line: str) -> None:
    logging.getLogger("symfric").warning(line)
