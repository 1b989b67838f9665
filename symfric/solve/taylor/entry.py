"""The door of the compiled event loop, kept on disk.

Only the door is kept; it holds a hash of the sources of what it closes over.
"""

from pathlib import Path

from numba import njit

from symfric.solve.compiled import announce, stamp
from symfric.solve.memory import DOOR
from symfric.solve.taylor.driver import drive, reset
from symfric.solve.taylor.polynomials import FUSED
from symfric.solve.taylor.workspace import at_addresses


def _door(stamp: int):
    @njit(**DOOR, fastmath=FUSED)
    def launch(table, y, p):
        """Drive the workspace at `table` from state y at t = 0 with parameters p; go on after a pause if y is empty."""
        w = at_addresses(table)
        if y.size + 0 * stamp:  # the stamp takes part so that it belongs to the key under which the code is kept
            reset(w, y, p)
        return drive(w)

    return launch


launch = _door(stamp(Path(__file__).parent))
announce(launch, "the event loop")
