"""Write files atomically: a file appears complete or not at all, even if the process is killed."""

import contextlib
import os
import secrets
from collections.abc import Mapping
from pathlib import Path

PART = ".part"  # suffix of a file that is still being written


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
