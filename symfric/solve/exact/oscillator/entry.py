"""Compiled entry point of the oscillator loop; see `symfric.solve.loop.entry`."""

from symfric.codegen.numba_types import compiled, opener
from symfric.solve.exact.oscillator.event_loop import drive, reset
from symfric.solve.exact.oscillator.workspace import OscillatorArrays

_at_address = opener(OscillatorArrays)


@compiled(ieee_division=True)
def launch(address: int, fresh: int) -> int:
    """Run the workspace at the address of its table, from its start or from a pause."""
    w = _at_address(address)
    if fresh:
        reset(w)
    return drive(w)
