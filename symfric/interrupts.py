"""Interrupts of the command: exit status 130 and no traceback, also while its modules are loaded and while it ends."""

import contextlib
import itertools
import os
import signal
import sys

STATUS = 130  # of a process that an interrupt ended
_SCRIPTS = ("symfric", "symfric.exe", "symfric-script.py")


def _is_command() -> bool:
    """Whether this process is ``symfric`` or ``python -m symfric``, and not a program that imports the package."""
    begin = next(iter(getattr(sys, "argv", [])), "")
    if begin == "-m":  # while the package of a module is imported that Python runs
        words = sys.orig_argv
        return ("-m", "symfric") in itertools.pairwise(words)
    return os.path.basename(begin) in _SCRIPTS


COMMAND = _is_command()


def leave(_signal: object, _frame: object) -> None:
    """End the process at once: there is nothing to keep, and an exception may be lost inside an import."""
    with contextlib.suppress(OSError):
        os.write(2, b"interrupted\n")
    os._exit(STATUS)


def leave_at_interrupt() -> None:
    """End the command at an interrupt without an exception; other programs keep their way."""
    if COMMAND and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        with contextlib.suppress(ValueError):  # not the main thread
            signal.signal(signal.SIGINT, leave)


def raise_at_interrupt() -> None:
    """Let an interrupt raise `KeyboardInterrupt` again, so that files are not left half written."""
    if signal.getsignal(signal.SIGINT) is leave:
        signal.signal(signal.SIGINT, signal.default_int_handler)
