"""The march through a record as machine code takes it; see `symfric.solve.taylor.loop`."""

from numba import njit

from symfric.solve.exact.record import march, reset
from symfric.solve.exact.record_room import RecordRoom
from symfric.solve.native import INNER, opener

_at_address = opener(RecordRoom)


@njit(**INNER)
def launch(address, fresh):
    """Run the room at the address of its table, from its start or again."""
    w = _at_address(address)
    if fresh:
        reset(w)
    return march(w)
