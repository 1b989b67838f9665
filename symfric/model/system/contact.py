"""A dry contact: where two bodies slide on each other, their load, and the law of friction."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.friction_ellipse import read_ellipse
from symfric.model.jumps import refuse_jumps
from symfric.model.laws import Law
from symfric.model.outputs import normal_force
from symfric.model.springs import read_stiffness, spring_of
from symfric.model.steps import jumps_in_time, with_steps
from symfric.model.symbols import expression, legible, refuse_speed, shortened
from symfric.model.unilateral import FRICTIONLESS, Unilateral
from symfric.spelling import spelt


@spelt
@dataclass(frozen=True)
class Contact:
    """One dry contact; friction on the body is ``-sign(slip) * normal * profile * mu(|slip|)``.

    With a pair of slips, the components of a slip vector, it slides in a plane: friction has the magnitude
    ``normal * profile * mu(|slip|)`` and opposes the vector; at rest it is any force within a disc. The normal load is
    given or, for contacts that open, computed, along a line and in the plane. A law with memory
    brings states of its own, see `states`.

    Attributes
    ----------
    name : str
    slip : Expr, pair of Expr, or None
        Relative velocity, linear in the velocities u; may depend on q and time. Two components of a contact in the
        plane, of which this attribute is the first one, and `across` the second. None, which becomes zero, for a stop
        without friction.
    normal : Expr or Unilateral
        Normal load, >= 0; may depend on state and time, and be the normal force of another contact. A
        `symfric.Unilateral` for a contact that opens and strikes: then this attribute is the symbol
        ``symfric.normal_force(name)``, and `unilateral` what was given.
    law : Law
        Not needed without slip.
    profile : Expr
        Factor of the coefficient, may depend on q: position-dependent friction.
    stiffness : Expr or None
        Of a spring in series, in force per displacement; its elongation is the state ``<name>.z``, zero at the start
        unless given. The law must be Coulomb's with one coefficient. See `symfric.model.springs`.
    unilateral : Unilateral or None
        Gap and restitution of a contact that opens; given as `normal`.
    across : Expr or None
        Second component of the slip of a contact in the plane; given with `slip`.
    ellipse : pair of Expr or None
        Of a contact in the plane whose friction differs along its two slips: factors of the coefficient along the first
        and along the second, positive, of parameters. The force at rest lies within the ellipse with these axes. While
        the contact slips the force is the point of the ellipse at which the slip is normal to it, that of largest
        dissipation (the associated sliding rule), ``f_k = -N mu(|w|) e_k**2 w_k/sqrt(e_0**2 w_0**2 + e_1**2 w_1**2)``;
        it opposes the slip along the axes only. Goyal, Ruina and Papadopoulos, Wear 143 (1991) 307.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> v_b = sp.Symbol("v_b", positive=True)
    >>> belt = sf.Contact("belt", slip=u - v_b, normal=1, law=sf.laws.coulomb(0.4, 0.3))
    >>> sorted(s.name for s in belt.free_symbols)
    ['u', 'v_b']
    >>> w = sp.Symbol("w", real=True)
    >>> table = sf.Contact("table", slip=(u, w), normal=1, law=sf.laws.coulomb(0.3))
    >>> table.in_plane, table.slips
    (True, (u, w))
    >>> wood = sf.Contact("wood", slip=(u, w), normal=1, law=sf.laws.coulomb(0.4), ellipse=(1, 1.5))  # along, across
    """

    name: str
    slip: sp.Expr
    normal: sp.Expr
    law: Law = FRICTIONLESS
    profile: sp.Expr = field(default=sp.Integer(1))
    stiffness: sp.Expr | None = None
    unilateral: Unilateral | None = None
    across: sp.Expr | None = None
    ellipse: tuple[sp.Expr, sp.Expr] | None = None

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise SceneError(f"the name of a contact is {shortened(self.name)}; it must be a string")
        legible(self.name, "a contact")
        if isinstance(self.slip, Sequence | np.ndarray | sp.MatrixBase) and not isinstance(self.slip, str):
            self._read_pair(list(self.slip))
        self._read_unilateral()
        if self.ellipse is not None:
            object.__setattr__(self, "ellipse", read_ellipse(self.ellipse, self.name, self.in_plane))
        for what in ("slip", "normal", "profile", *(("across",) if self.in_plane else ())):
            where = f"{what} of contact {self.name!r}"
            value = with_steps(expression(getattr(self, what), where), where)
            refuse_jumps(value, where)
            refuse_speed(value, where)
            object.__setattr__(self, what, value)
        if not isinstance(self.law, Law):
            name = getattr(self.law, "__name__", "")
            cure = f"call it: sf.laws.{name}(...)" if callable(self.law) and name else "use one of sf.laws"
            raise SceneError(f"the law of contact {self.name!r} is {name or shortened(self.law)}; {cure}")
        for e in (self.law.kinetic, self.law.stick, *self.law.breaks):  # a law alone may stand for any function
            expression(e, f"law of contact {self.name!r}")
        refuse_jumps(self.law.kinetic, f"law of contact {self.name!r}")
        for e in self.law.memory.expressions if self.law.memory else ():
            refuse_jumps(e, f"law of contact {self.name!r}")
        if self.normal.is_number and self.normal < 0:
            raise SceneError(f"normal of contact {self.name!r} is {self.normal}; a normal load is not negative")
        if self.stiffness is not None:
            object.__setattr__(self, "stiffness", read_stiffness(self.stiffness, self.law, self.name))
        limits = self.law.memory.limits if self.law.memory else ()
        if self.stiffness is not None:
            limits = (self.normal, self.law.stick)
        if any(map(jumps_in_time, limits)):
            raise SceneError(
                f"the load or the law of contact {self.name!r} steps in time, and the contact is behind a spring, "
                "whose force would jump with it; let it change over a short time"
            )

    def _read_pair(self, slips: list[sp.Expr]) -> None:
        """Take the two components of the slip of a contact in the plane, and check what goes with them."""
        if len(slips) != 2:
            raise SceneError(
                f"slip of contact {self.name!r} has {len(slips)} entries; give one expression, or "
                "a pair for a contact in the plane"
            )
        object.__setattr__(self, "slip", slips[0])
        object.__setattr__(self, "across", slips[1])
        wrong = isinstance(self.law, Law) and (self.law.memory is not None or self.law.smooth)
        if wrong and isinstance(self.normal, Unilateral):
            wrong = not self.law.kinetic == self.law.stick == 0  # without friction it is a stop
        if self.stiffness is not None or wrong:
            what = "a stiffness" if self.stiffness is not None else "a law with memory or a regularised one"
            raise SceneError(f"contact {self.name!r} slides in the plane and has {what}; in the plane use a dry law")

    def _read_unilateral(self) -> None:
        """Put the symbol of the normal force in place of a unilateral normal direction, and check what goes with it."""
        if isinstance(self.normal, Unilateral):
            object.__setattr__(self, "unilateral", self.normal)
            object.__setattr__(self, "normal", normal_force(self.name))
        if self.slip is None:
            if self.unilateral is None:
                raise SceneError(
                    f"contact {self.name!r} has no slip; only one with normal=sf.Unilateral(...) needs none"
                )
            if self.law is not FRICTIONLESS:
                raise SceneError(f"contact {self.name!r} has a law and no slip; give the slip of its friction")
            object.__setattr__(self, "slip", sp.S.Zero)
        elif self.unilateral is not None and isinstance(self.law, Law) and self.law.kinetic == self.law.stick == 0:
            object.__setattr__(self, "slip", sp.S.Zero)
            object.__setattr__(self, "across", None)
            object.__setattr__(self, "ellipse", None)
            object.__setattr__(self, "law", FRICTIONLESS)
        elif self.law is FRICTIONLESS and not self.frictionless:
            raise SceneError(f"contact {self.name!r} has no law; use one of sf.laws, such as sf.laws.coulomb(0.3)")
        if self.unilateral is None:
            return
        if self.stiffness is not None:
            raise SceneError(
                f"contact {self.name!r} opens and has a stiffness; a spring in series is not offered there"
            )
        if isinstance(self.law, Law) and self.law.memory is not None:
            raise SceneError(
                f"contact {self.name!r} opens and has a law with memory, which does not define friction in an impact; "
                "use a dry law"
            )

    @property
    def in_plane(self) -> bool:
        """Whether it slides in a plane: its slip is a vector."""
        return self.across is not None

    @property
    def slips(self) -> tuple[sp.Expr, ...]:
        """The slip, or its two components."""
        return (self.slip,) if self.across is None else (self.slip, self.across)

    @property
    def frictionless(self) -> bool:
        """Whether it has no friction: a stop."""
        return self.unilateral is not None and self.slip == 0

    @property
    def along_line(self) -> bool:
        """Whether friction is between the two surfaces themselves; no spring stands between."""
        behind = self.stiffness is not None or bool(self.law.memory and self.law.memory.limits)
        return not behind and not self.frictionless

    @property
    def states(self) -> tuple[sp.Symbol, ...]:
        """Symbols of the states of the contact: ``<name>.z`` of a spring or a law with memory, ``<name>.z1``, ... of
        several."""
        if self.stiffness is not None:
            return (spring_of(self.name),)
        count = 0 if self.law.memory is None else len(self.law.memory.rates)
        ends = [""] if count == 1 else [str(k + 1) for k in range(count)]
        return tuple(sp.Symbol(f"{self.name}.z{end}", real=True) for end in ends)

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """Every expression of the contact and of its law."""
        own = () if self.stiffness is None else (self.stiffness,)
        own = own if self.unilateral is None else (*own, self.unilateral.gap, self.unilateral.restitution)
        own = own if self.ellipse is None else (*own, *self.ellipse)
        return (*self.slips, self.normal, self.profile, *own, *self.law.expressions)

    def rewritten(self, change: Callable[[sp.Expr], sp.Expr]) -> "Contact":
        """Return the contact with its expressions changed, those of its law apart.

        Parameters
        ----------
        change : callable ``Expr -> Expr``

        Returns
        -------
        Contact

        Examples
        --------
        >>> import sympy as sp
        >>> import symfric as sf
        >>> u, v_b = sp.symbols("u v_b", real=True)
        >>> belt = sf.Contact("belt", u - v_b, 1, sf.laws.coulomb(0.3))
        >>> belt.rewritten(lambda e: e.subs(v_b, 2)).slip
        u - 2
        """
        u = self.unilateral
        return replace(
            self,
            slip=change(self.slip),
            normal=change(self.normal),
            profile=change(self.profile),
            stiffness=None if self.stiffness is None else change(self.stiffness),
            unilateral=None if u is None else replace(u, gap=change(u.gap), restitution=change(u.restitution)),
            across=None if self.across is None else change(self.across),
            ellipse=None if self.ellipse is None else (change(self.ellipse[0]), change(self.ellipse[1])),
        )

    @property
    def free_symbols(self) -> set[sp.Symbol]:
        """Every symbol of the contact except the speed in its law."""
        own = set() if self.stiffness is None else self.stiffness.free_symbols
        own = own if self.unilateral is None else own | self.unilateral.free_symbols
        own = own.union(*(e.free_symbols for e in self.ellipse or ()))
        return own | set().union(*(e.free_symbols for e in (*self.slips, self.normal, self.profile, self.law)))
