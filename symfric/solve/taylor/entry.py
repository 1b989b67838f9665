"""The door of the compiled event loop, kept on disk.

numba keeps a compiled function as long as its own source file is unchanged, and does not look at the files of the
functions it calls. So only the door is kept, and what it closes over holds a hash of all their sources.

Compiling takes some twenty seconds without a sign of life, so the logger "symfric" says so first.
"""

import hashlib
import logging
from pathlib import Path

from numba import njit
from numba.core import event

from symfric.solve.taylor.driver import drive, reset
from symfric.solve.taylor.workspace import at_addresses


def _stamp() -> int:
    """Return a positive number that changes with any source file of this folder."""
    sources = sorted(Path(__file__).parent.glob("*.py"))
    return int.from_bytes(hashlib.sha256(b"".join(f.read_bytes() for f in sources)).digest()[:7], "little") + 1


def _door(stamp: int):
    @njit(cache=True, nogil=True)
    def launch(table, y, p):
        """Drive the workspace at `table` from state y at t = 0 with parameters p; go on after a pause if y is empty."""
        w = at_addresses(table)
        if y.size + 0 * stamp:  # the stamp takes part so that it belongs to the key under which the code is kept
            reset(w, y, p)
        return drive(w)

    return launch


launch = _door(_stamp())


class _Announcement(event.Listener):
    """Says that the door is being compiled, which numba does only if it is not on disk."""

    def on_start(self, event: event.Event) -> None:
        """Log; numba calls this for every function it compiles."""
        if event.data["dispatcher"] is launch:
            logging.getLogger("symfric").info("compiling the event loop, once for this machine")

    def on_end(self, event: event.Event) -> None:
        """Do nothing."""


event.register("numba:compile", _Announcement())
