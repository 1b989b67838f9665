"""Standard streams that do not raise on unsupported characters, a full disk or a closed pipe."""

import codecs
import contextlib
import errno
import io
import os
import sys
import unicodedata
from collections.abc import Iterator
from typing import Any, TextIO

PLAIN = {  # replacements of characters that ASCII or Latin-1 lack
    "−": "-",
    "–": "-",
    "—": "-",
    "·": "*",
    "×": "x",
    "±": "+-",
    "≤": "<=",
    "≥": ">=",
    "≠": "!=",
    "≈": "~",
    "→": "->",
    "′": "'",
    "″": "''",
    "‘": "'",
    "’": "'",
    "“": '"',
    "”": '"',
    "…": "...",
    "∞": "inf",
    "µ": "u",
    "ß": "ss",
}
SUPERSCRIPTS = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+", strict=True))


def plain(text: str) -> str:
    """Return a text in ASCII: similar signs, names of Greek letters, and question marks for the rest."""
    shown = []
    raised = False
    for letter in text:
        if letter in SUPERSCRIPTS:
            shown.append(("" if raised else "^") + SUPERSCRIPTS[letter])
        elif letter in PLAIN:
            shown.append(PLAIN[letter])
        else:
            shown.append(_named(letter))
        raised = letter in SUPERSCRIPTS
    return "".join(shown)


def _named(letter: str) -> str:
    """Return a letter without accents, or the name of a Greek letter."""
    bare = unicodedata.normalize("NFKD", letter).encode("ascii", "ignore").decode()
    if bare:
        return bare
    family, _, name = unicodedata.name(unicodedata.normalize("NFKC", letter)[0], "").partition(" LETTER ")
    return name.split()[0].lower() if family.startswith("GREEK") and name else "?"


def _replace(error: UnicodeError) -> tuple[str, int]:
    """Codec error handler that replaces characters an encoding lacks."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    end = error.end
    while end < len(error.object) and error.object[end] in SUPERSCRIPTS:  # a power is one word
        end += 1
    return plain(error.object[error.start : end]), end


codecs.register_error("symfric.plain", _replace)


class Sink(io.BufferedIOBase):
    """Binary stream that discards all output after the first failure, and stores that failure.

    Parameters
    ----------
    buffer : binary stream or None
        None where the process was started with the stream closed.

    Attributes
    ----------
    failure : OSError or None
        The first error, after which output is incomplete.
    """

    def __init__(self, buffer: Any):
        super().__init__()
        self.name = getattr(buffer, "name", "")
        self._raw = getattr(buffer, "raw", buffer)  # unbuffered, since a buffer repeats a failed write when Python ends
        self.failure: OSError | None = None

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        if self._raw is None:
            raise io.UnsupportedOperation("fileno")
        return int(self._raw.fileno())

    def isatty(self) -> bool:
        return self._raw is not None and self._raw.isatty()

    def write(self, data: Any) -> int:
        rest = memoryview(data)
        while rest and self.failure is None:
            try:
                if self._raw is None:
                    raise OSError(errno.EBADF, "it is closed")
                written = self._raw.write(rest)
                if written is None:
                    raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))
                rest = rest[written:]
            except OSError as error:
                self.failure = error
            except ValueError as error:  # closed by the process itself
                self.failure = OSError(errno.EBADF, str(error))
        return len(data)


@contextlib.contextmanager
def safe_streams() -> Iterator[Sink]:
    """Replace both standard streams within a context; yield the stream behind standard output."""
    before = sys.stdout, sys.stderr
    sinks = []
    for name, stream in zip(("stdout", "stderr"), before, strict=True):
        # such as the stream of a notebook, which accepts every text
        if stream is not None and not hasattr(stream, "buffer"):
            sinks.append(Sink(io.BytesIO()))
            continue
        if stream is not None:
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
        sinks.append(Sink(None if stream is None else stream.buffer))
        setattr(sys, name, _text(stream, sinks[-1]))
    try:
        yield sinks[0]
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        sys.stdout, sys.stderr = before


def _text(stream: TextIO | None, sink: Sink) -> TextIO:
    """Return a text stream with the settings of another one."""
    encoding = "utf-8" if stream is None else stream.encoding
    lines = stream is None or bool(stream.line_buffering)
    return io.TextIOWrapper(sink, encoding=encoding, errors="symfric.plain", newline=None, line_buffering=lines)


def hold_closed() -> None:
    """Open the null device in place of closed standard streams, so that no later file gets their descriptors."""
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
