"""Compiled entry point of the event loop: takes a table of addresses, and whether a run starts."""

from symfric.codegen.numba_types import compiled, opener
from symfric.solve.loop.event_loop import drive, reset
from symfric.solve.loop.workspace import LoopArrays

_at_address = opener(LoopArrays)


@compiled(fused=True)
def launch(address: int, fresh: int) -> int:
    """Run the workspace at the address of its table, from its start or from a pause."""
    w = _at_address(address)
    if fresh:
        reset(w)
    return drive(w)
