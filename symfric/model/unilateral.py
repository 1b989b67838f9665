"""Contacts that open: a gap that is never negative, a normal force that is never negative, and impacts between."""

from dataclasses import dataclass

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.laws import Law
from symfric.model.steps import with_steps
from symfric.model.symbols import expression, refuse_speed
from symfric.spelling import spelt

# law of a contact that has no friction, because it has no slip
FRICTIONLESS = Law(sp.S.Zero, sp.S.Zero, source="definition")


@spelt
@dataclass(frozen=True)
class Unilateral:
    """The normal direction of a contact that opens and closes: ``0 <= gap``, ``0 <= normal force``, one of them zero.

    An impact follows Newton's rule: with the rate of the gap before (-) and after (+) it,

        gap'+ = -restitution gap'-.

    Friction acts in the impulse as in a force, against the slip, with the coefficient of the slip before the impact; a
    slip that ends during the impact sticks or, if friction cannot hold it, turns round (Routh). Where Newton's rule
    would add energy, restitution is taken of the work of the normal force instead (Stronge), for several contacts at
    once as far as the energy allows.

    Of a contact in the plane, with a pair of slips, the impulse Q of friction lies in the disc ``|Q| <= mu P`` of the
    normal impulse P: the slip after the impact is zero, or Q opposes it, ``Q = -mu P w+/|w+|`` (Moreau, Glocker). For a
    ball, whose slip keeps its direction in the impact, this is the same. Where it would add energy, restitution is
    taken in part, as far as the energy allows.

    Attributes
    ----------
    gap : Expr
        Distance, >= 0, of coordinates, time and parameters; with the orientation of a length.
    restitution : float or Expr
        From 0, a plastic impact, to 1, an elastic one.

    Notes
    -----
    Brogliato, Nonsmooth Mechanics, 3rd edition, chapter 4; Routh, Advanced Dynamics of a System of Rigid Bodies,
    section 194; Stronge, Impact Mechanics, chapter 3; Moreau, Unilateral contact and dry friction in finite freedom
    dynamics (1988); Glocker, Set-Valued Force Laws (2001), chapter 12.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> y, v = sp.symbols("y v", real=True)
    >>> ball = sf.Scene(
    ...     system=sf.System(q=[y], u=[v], mass=[[1]], force=[-9.81]),
    ...     contacts=[sf.Contact("floor", slip=None, normal=sf.Unilateral(y, restitution=0.8))],
    ...     initial={y: 1.0, v: 0.0},
    ...     horizon=1.0,
    ... )
    >>> [(round(e.t, 6), e.kind) for e in sf.simulate(ball).events]
    [(0.451524, 'impact')]
    """

    gap: sp.Expr
    restitution: sp.Expr = sp.S.Zero

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        for what in ("gap", "restitution"):
            value = with_steps(expression(getattr(self, what), f"{what} of a unilateral contact"), what)
            refuse_speed(value, f"{what} of a unilateral contact")
            object.__setattr__(self, what, value)
        e = self.restitution
        if e.is_number and not (e.is_real and 0 <= e <= 1):
            shown = f"{float(e):g}" if e.is_real else str(e)
            raise SceneError(f"the restitution of a unilateral contact is {shown}; it must lie between 0 and 1")

    @property
    def free_symbols(self) -> set[sp.Symbol]:
        """Symbols of gap and restitution."""
        return set(self.gap.free_symbols) | set(self.restitution.free_symbols)
