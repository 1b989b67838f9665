"""Tables as lookups: the segment in which a quantity lies is held by few switches, and its numbers are data.

Of 2^n segments, n switches tell which one holds, as in a binary search: the first compares the quantity with the break
in the middle, the next with the middle of the half that is left, and so on. The break of a switch is data like the
signs of those before it. Signs are those of a reflected Gray code (Gray, US patent 2632058, 1953): with the side
``b_l = +-1`` of the break on level l on which the quantity x lies,

    sigma_l = b_(l-1) b_l,   guard_l = sigma_l b_(l-1) (x - break_l),   b_0 = -1,

so that a motion which passes a break changes one sign only, that of the switch whose guard fell, and every guard is
linear in x. All signs are 1 on the first segment, where contacts at rest are. A Piecewise with a switch for each break
instead has as many guards as breaks, and all of its branches are computed at all times.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca

from symfric.scalars import binary

LEAST = 8  # breaks from which a Piecewise is looked up; with fewer, a switch for each costs less


@dataclass(frozen=True)
class Lookup:
    """The switches of a table.

    Attributes
    ----------
    sides : tuple of (SX, SX)
        Whether the quantity lies above the break of every level, and whether below.
    count : int
        Number of segments.
    """

    sides: tuple[tuple[ca.SX, ca.SX], ...]
    count: int

    def __call__(self, entries: Sequence[ca.SX]) -> ca.SX:
        """Return the entry of the segment."""
        return _chosen(self.sides, [*entries, *[entries[-1]] * (2 ** len(self.sides) - self.count)])


def looked_up(x: ca.SX, breaks: Sequence[float], switch: Callable[[ca.SX, int], ca.SX]) -> Lookup:
    """Return the lookup of a quantity among increasing numbers.

    Parameters
    ----------
    x : SX
    breaks : sequence of float
    switch : callable
        ``(quantity, level) -> sign`` makes a switch.
    """
    levels = len(breaks).bit_length()
    places = 2**levels - 1  # of breaks in a complete tree; those beyond the last are never reached
    beyond = breaks[0] - breaks[-1]  # any negative number of the same size as the quantities
    sides: list[tuple[ca.SX, ca.SX]] = []
    turned = ca.SX(-1)
    for level in range(levels):
        at = range(2 ** (levels - level - 1) - 1, places, 2 ** (levels - level))
        slopes = [ca.SX(k < len(breaks)) for k in at]
        rests = [ca.SX(-breaks[k] if k < len(breaks) else beyond) for k in at]
        distance = _chosen(sides, slopes) * x + _chosen(sides, rests)
        side = turned * switch(turned * distance, level)
        sides.append((side > 0, side < 0))
        turned = side
    return Lookup(tuple(sides), len(breaks) + 1)


def _chosen(sides: Sequence[tuple[ca.SX, ca.SX]], entries: Sequence[ca.SX]) -> ca.SX:
    """Return one of 2^n entries by n sides, the first of which halves them."""
    if len(entries) == 1 or all(ca.is_equal(entries[0], e) for e in entries[1:]):
        return entries[0]
    half, (above, below) = len(entries) // 2, sides[0]
    low, high = _chosen(sides[1:], entries[:half]), _chosen(sides[1:], entries[half:])
    return binary(ca.OP_IF_ELSE_ZERO, above, high) + binary(ca.OP_IF_ELSE_ZERO, below, low)
