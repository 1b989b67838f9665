"""Standard output and error that no terminal's encoding, full disk or closed pipe can turn into a traceback."""

import codecs
import contextlib
import errno
import io
import os
import sys
import unicodedata
from collections.abc import Iterator
from typing import Any, TextIO

PLAIN = {  # characters of tables and messages that ASCII or Latin-1 lack
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
    """Return a text in ASCII: signs by their likeness, Greek letters by their names, a question mark for the rest."""
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
    """Return a letter without its accents, or the name of a Greek one."""
    bare = unicodedata.normalize("NFKD", letter).encode("ascii", "ignore").decode()
    if bare:
        return bare
    family, _, name = unicodedata.name(unicodedata.normalize("NFKC", letter)[0], "").partition(" LETTER ")
    return name.split()[0].lower() if family.startswith("GREEK") and name else "?"


def _replace(error: UnicodeError) -> tuple[str, int]:
    """Stand in for what an encoding lacks."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    end = error.end
    while end < len(error.object) and error.object[end] in SUPERSCRIPTS:  # a power stays one word
        end += 1
    return plain(error.object[error.start : end]), end


codecs.register_error("symfric.plain", _replace)


class Sink(io.BufferedIOBase):
    """What a text stream writes to: after the first failure everything is let go, and the failure is kept.

    Parameters
    ----------
    buffer : binary stream or None
        None where the process was started with the stream closed.

    Attributes
    ----------
    failure : OSError or None
        Why the output is not complete.
    """

    def __init__(self, buffer: Any):
        super().__init__()
        self.name = getattr(buffer, "name", "")
        self._raw = getattr(buffer, "raw", buffer)  # what a buffer cannot write, it tries again when Python ends
        self.failure: OSError | None = None

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        if self._raw is None:
            raise io.UnsupportedOperation("fileno")
        return self._raw.fileno()

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
            except ValueError as error:  # closed from inside the process
                self.failure = OSError(errno.EBADF, str(error))
        return len(data)


@contextlib.contextmanager
def safe_streams() -> Iterator[Sink]:
    """Replace both standard streams for a while; yield what standard output writes to."""
    before = sys.stdout, sys.stderr
    sinks = []
    for name, stream in zip(("stdout", "stderr"), before, strict=True):
        if stream is not None and not hasattr(stream, "buffer"):  # such as a notebook's, which takes every text
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
    """Return a text stream like another one."""
    encoding = "utf-8" if stream is None else stream.encoding
    lines = stream is None or bool(stream.line_buffering)
    return io.TextIOWrapper(sink, encoding=encoding, errors="symfric.plain", newline=None, line_buffering=lines)


def hold_closed() -> None:
    """Open the null device in place of closed standard streams: files opened later would get their numbers."""
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
