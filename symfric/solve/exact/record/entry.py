"""Compiled entry point of the loop over a record; see `symfric.solve.loop.entry`."""

from symfric.codegen.numba_types import compiled, opener
from symfric.solve.exact.record.march import march, reset
from symfric.solve.exact.record.workspace import RecordArrays

_at_address = opener(RecordArrays)


@compiled
def launch(address: int, fresh: int) -> int:
    """Run the workspace at the address of its table, from its start or again."""
    w = _at_address(address)
    if fresh:
        reset(w)
    return march(w)
