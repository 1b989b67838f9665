"""Internal states of a friction law with memory: their rates, and the force they give.

With the slip velocity w, its direction d = +-1 (so that ``|w| = d w``) and the states z_k of the contact,

    z_k' = rates[k](z, w),    friction on the body = -normal * profile * force(z, w).

Everything is smooth while w keeps its direction, which the event loop watches like that of any other contact. With
`limits` the states are elongations of springs with a slider in series: z_k' is the rate while the slider sticks, and 0
while it slides at ``|z_k| = limits[k]``, until w turns.
"""

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from symfric.model.symbols import SPEED

SLIP = sp.Symbol("slip velocity w", real=True)  # of the contact, with its sign; reserved
SIDE = sp.Symbol("direction of slip d", real=True)  # sign of the slip, +-1; reserved


def state_symbols(count: int) -> tuple[sp.Symbol, ...]:
    """Return the symbols that stand for the states of a contact inside its law."""
    return tuple(sp.Symbol(f"state {k + 1} of the contact", real=True) for k in range(count))


@dataclass(frozen=True)
class Memory:
    """States of a friction law.

    Attributes
    ----------
    rates : tuple of Expr
        Rate of every state, in `state_symbols`, SLIP, ``SPEED`` = |w| and SIDE.
    force : Expr
        The coefficient of friction, dimensionless: friction over normal load, against the slip if positive.
    stiffness : Expr
        Its slope over a small displacement from rest, 1/length.
    stored : Expr
        Energy stored per normal load, length.
    passive : Expr
        Not negative if the contact dissipates whatever the motion.
    limits : tuple of Expr
        Largest magnitude of every state, if the states belong to sliders; empty if not.
    slowest : Expr or None
        Speed above which the law depends on the logarithm of the speed, in the unit of the slip velocity; None for
        other laws.
    """

    rates: tuple[sp.Expr, ...]
    force: sp.Expr
    stiffness: sp.Expr
    stored: sp.Expr
    passive: sp.Expr = sp.S.Zero
    limits: tuple[sp.Expr, ...] = ()
    slowest: sp.Expr | None = None

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """The symbols of the states inside the law."""
        return state_symbols(len(self.rates))

    @property
    def reserved(self) -> set[sp.Symbol]:
        """Symbols that are no parameters."""
        return {SLIP, SIDE, SPEED, *self.symbols}

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """Every expression."""
        slowest = () if self.slowest is None else (self.slowest,)
        return (*self.rates, self.force, self.stiffness, self.stored, self.passive, *self.limits, *slowest)

    @property
    def dissipation(self) -> sp.Expr:
        """Power that becomes heat per normal load, ``force w - d stored/dt``, length/time; for laws without sliders."""
        gained = sum((self.stored.diff(z) * rate for z, rate in zip(self.symbols, self.rates, strict=True)), sp.S.Zero)
        return self.force * SLIP - gained

    def mapped(self, change: Callable[[sp.Expr], sp.Expr]) -> "Memory":
        """Return the memory with every expression changed."""
        rates, limits = (tuple(map(change, e)) for e in (self.rates, self.limits))
        force, stiffness, stored, passive = map(change, (self.force, self.stiffness, self.stored, self.passive))
        slowest = None if self.slowest is None else change(self.slowest)
        return Memory(rates, force, stiffness, stored, passive, limits, slowest)
