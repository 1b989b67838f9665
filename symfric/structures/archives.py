"""Zip archives from elsewhere: only the entries that are looked for are read, and not more than a given size."""

import contextlib
import lzma
import stat
import struct
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from symfric.errors import SceneError
from symfric.files import open_regular, read_at_most
from symfric.model.symbols import shorten

MAX_FILE = 1 << 30  # bytes of a file, and of what is unpacked from one entry
_MAX_DIRECTORY = 1 << 20  # bytes of the list of entries, which is read as a whole
_MAX_DEPTH = 8  # folders in the path of an entry
_END = struct.Struct("<4s4H2LH")  # the record at the end of an archive
_MAX_COMMENT = 1 << 16
BROKEN = (
    ValueError,
    OSError,
    EOFError,
    KeyError,
    IndexError,
    OverflowError,
    NotImplementedError,
    RuntimeError,
    MemoryError,
    struct.error,
    zlib.error,
    lzma.LZMAError,
    zipfile.BadZipFile,
)


@contextlib.contextmanager
def reported(name: str) -> Iterator[None]:
    """Raise whatever a damaged file leads to as a SceneError that names the file."""
    try:
        yield
    except BROKEN as error:
        if isinstance(error, SceneError):
            raise
        reason = "not enough memory" if isinstance(error, MemoryError) else getattr(error, "strerror", None) or error
        said = " ".join(str(reason).split())[:120] or type(error).__name__
        raise SceneError(f"{name} cannot be read: {said}; write it anew") from None


@contextlib.contextmanager
def opened(place: Path) -> Iterator[zipfile.ZipFile]:
    """Open an archive whose list of entries is of limited size.

    Raises
    ------
    SceneError
        If it cannot be read, is no zip archive, or is too large.
    """
    with reported(place.name), open_regular(place) as stream:
        _check_size(stream, place.name)
        with zipfile.ZipFile(stream) as file:
            yield file


def _check_size(stream: BinaryIO, name: str) -> None:
    """Raise unless a file is a zip archive with a short list of entries."""
    size = stream.seek(0, 2)
    if size > MAX_FILE:
        raise SceneError(f"{name} is larger than {MAX_FILE >> 20} MiB; reduce the structure before")
    stream.seek(max(0, size - _MAX_COMMENT - _END.size))
    tail = stream.read()
    at = len(tail) - _END.size
    if at < 0 or tail[at : at + 4] != b"PK\5\6" or tail[-2:] != b"\0\0":
        at = tail.rfind(b"PK\5\6")
    if at < 0 or at + _END.size > len(tail):
        raise SceneError(f"{name} cannot be read: it is no zip archive; write it anew")
    entries = _END.unpack_from(tail, at)
    if tail[max(0, at - 20) : at].startswith(b"PK\6\7") or entries[5] > _MAX_DIRECTORY:
        raise SceneError(f"{name} holds too many entries; leave in it what belongs to the structure")
    stream.seek(0)


def entry_called(file: zipfile.ZipFile, names: tuple[str, ...], archive: str, flat: bool) -> zipfile.ZipInfo | None:
    """Return the entry of one of some names, None if there is none.

    Parameters
    ----------
    file : ZipFile
    names : tuple of str
        Of which one may be there, without folders.
    archive : str
        Name of the archive, for messages.
    flat : bool
        Whether entries in folders do not count.

    Raises
    ------
    SceneError
        If several entries are called so, or it is a link or lies outside the archive.
    """
    entries = [
        e
        for e in file.infolist()
        if (e.filename if flat else e.filename.replace("\\", "/").rsplit("/", 1)[-1]) in names
    ]
    if len(entries) > 1:
        raise SceneError(f"{archive} holds {shorten(entries[0].filename)} and another of its name; keep one of them")
    for entry in entries:
        parts = entry.filename.replace("\\", "/").split("/")
        if ".." in parts or parts[0] == "" or len(parts) > _MAX_DEPTH:
            raise SceneError(f"{archive} holds {names[0]} under a path that leaves it or is too deep; pack it anew")
        if stat.S_ISLNK(entry.external_attr >> 16):
            raise SceneError(f"{archive} holds {names[0]} as a link; pack the file itself")
    return entries[0] if entries else None


def content(file: zipfile.ZipFile, entry: zipfile.ZipInfo, most: int = MAX_FILE) -> bytes:
    """Return the content of an entry; raise if it says that it is larger than `most` bytes.

    Raises
    ------
    SceneError
        If it is too large; errors of damaged data are those of `BROKEN`.
    """
    if entry.file_size > most:
        raise SceneError(f"{shorten(entry.filename)} is larger than {most >> 20} MiB; reduce the structure before")
    if entry.flag_bits & 1:
        raise SceneError(f"{shorten(entry.filename)} is encrypted; pack it without a password")
    with file.open(entry) as stream:
        return read_at_most(stream, most)  # type: ignore[arg-type]
