"""The door of the compiled march through a record, kept on disk; see `symfric.solve.taylor.entry`."""

from pathlib import Path

from numba import njit

from symfric.solve.compiled import announce, stamp
from symfric.solve.exact.record import march, reset
from symfric.solve.exact.record_room import at_addresses
from symfric.solve.memory import DOOR


def _door(stamp: int):
    @njit(**DOOR)
    def launch_record(table, y, p):
        """Run the room at `table` from state y with parameters p; run again if y is empty."""
        w = at_addresses(table)
        if y.size + 0 * stamp:  # as in the other doors
            reset(w, y, p)
        return march(w)

    return launch_record


launch_record = _door(stamp(Path(__file__).parent, Path(__file__).parents[1] / "taylor"))
announce(launch_record, "the march through a sampled input")
