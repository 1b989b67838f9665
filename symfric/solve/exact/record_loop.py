"""The march through a record as machine code takes it; see `symfric.solve.taylor.loop`."""

from symfric.solve.exact.record import march, reset
from symfric.solve.exact.record_room import RecordRoom
from symfric.solve.native import compiled, opener

_at_address = opener(RecordRoom)


@compiled
def launch(address, fresh):
    """Run the room at the address of its table, from its start or again."""
    w = _at_address(address)
    if fresh:
        reset(w)
    return march(w)
