"""Layout of the mode and guard vectors for compiled code, see `symfric.lower.mode_layout`."""

from typing import Any

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower import mode_layout
from symfric.solve.loop.workspace import LoopArrays

backward = compiled(inline=True)(mode_layout.backward)
contact_of = compiled(inline=True)(mode_layout.contact_of)
direction = compiled(inline=True)(mode_layout.direction)
forward = compiled(inline=True)(mode_layout.forward)
is_slip = compiled(inline=True)(mode_layout.is_slip)
sign = compiled(inline=True)(mode_layout.sign)
switch = compiled(inline=True)(mode_layout.switch)


@compiled(inline=True)
def way(w: LoopArrays, i: int) -> float:
    """Return the direction of the slip of contact i, also while it sticks."""
    return w.m[direction(i, w.contacts.sticks.size)]


@compiled(inline=True)
def turn(w: LoopArrays, i: int, to: float) -> None:
    """Set the direction of contact i."""
    w.m[direction(i, w.contacts.sticks.size)] = to


@compiled(inline=True)
def mode(w: LoopArrays, i: int) -> Any:
    """Return -1, 0 or +1 for a contact that slips backwards, sticks, or slips forwards."""
    return 0 if w.m[i] > 0.5 else np.int64(way(w, i))


@compiled(inline=True)
def is_along_line(w: LoopArrays, g: int) -> bool:
    """Whether a guard is one of a contact along a line."""
    return g < backward(w.contacts.sticks.size)


@compiled(inline=True)
def is_switch(w: LoopArrays, g: int) -> bool:
    """Whether a guard is that of a switch."""
    return switch(0, w.contacts.sticks.size) <= g < w.limits.first_load


@compiled(inline=True)
def is_load(w: LoopArrays, g: int) -> bool:
    """Whether a guard is that of a load."""
    return w.limits.first_load <= g < w.limits.first_other
