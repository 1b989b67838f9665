"""A mechanical system, its dry contacts and its sampled inputs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.friction_ellipse import read_ellipse
from symfric.model.jumps import refuse_jumps
from symfric.model.laws import Law
from symfric.model.linear_part import LinearPart, slopes_of
from symfric.model.outputs import normal_force
from symfric.model.springs import read_stiffness, spring_of
from symfric.model.steps import jumps_in_time, with_steps
from symfric.model.symbols import (
    TIME,
    counted,
    expression,
    finite,
    legible,
    listed,
    numbers_of,
    refuse_speed,
    shortened,
)
from symfric.model.typed_friction import refuse_typed_friction
from symfric.model.unilateral import FRICTIONLESS, Unilateral

_WRITTEN = 12  # coordinates up to which matrices become expressions for reading


@dataclass(frozen=True)
class System:
    """Equations of motion ``q' = u``, ``mass(q) u' = force(q, u, z, t) + contact forces``, ``z' = z_rate(q, u, z, t)``.

    Attributes
    ----------
    q, u : sequences of Symbol, length n
        Coordinates and their velocities.
    mass : matrix of Expr, shape (n, n)
        Symmetric and positive definite; may depend on q and parameters.
    force : sequence of Expr, length n
        Right-hand side without the contact forces; may have kinks (Abs, Max, Min, a continuous Piecewise).
    z, z_rate : sequences, same length
        First-order states and their rates: controllers, dynamic friction.
    linear : LinearPart, optional
        Matrices that are added; then `mass` and `force` are what expressions add to them, and may be None. See
        `symfric.structures`.
    made : int
        How many of the last z are states of contacts with memory, which a scene adds itself.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> k = sp.Symbol("k", positive=True)
    >>> system = sf.System(q=[x], u=[u], mass=[[1]], force=[-k * x])
    >>> system.states
    (x, u)
    >>> system.slopes(3 * u)
    [3]
    >>> system.written_out() is system, system.row_values()
    (True, {})
    """

    q: Sequence[sp.Symbol]
    u: Sequence[sp.Symbol]
    mass: sp.ImmutableMatrix
    force: Sequence[sp.Expr]
    z: Sequence[sp.Symbol] = ()
    z_rate: Sequence[sp.Expr] = ()
    linear: LinearPart | None = field(default=None, repr=False)
    made: int = field(default=0, repr=False)

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        for name in ("q", "u", "z"):
            states = listed(getattr(self, name), name)
            for s in states:
                if not isinstance(s, sp.Symbol):
                    raise SceneError(f"{s!r} in {name} is not a symbol; states are SymPy symbols")
                refuse_speed(s, name)
            object.__setattr__(self, name, states)
        n = len(self.q)
        if not n:
            raise SceneError("a system needs at least one coordinate in q")
        if len(self.u) != n:
            raise SceneError(f"{n} coordinates in q and {len(self.u)} velocities in u; give one velocity for each")
        if self.mass is not None or self.linear is None:
            self._read_mass(n)
        if self.force is None and self.linear is not None:
            object.__setattr__(self, "force", (sp.S.Zero,) * n)
        for name, length in (("force", n), ("z_rate", len(self.z))):
            entries = listed(getattr(self, name), name)
            if len(entries) != length:
                raise SceneError(f"{name} has {len(entries)} entries; it needs {length}")
            entries = tuple(expression(e, f"{name}[{i}]") for i, e in enumerate(entries))
            own = entries[: len(entries) - self.made] if name == "z_rate" else entries
            for i, e in enumerate(own):
                refuse_speed(e, f"{name}[{i}]")
            own = tuple(with_steps(e, f"{name}[{i}]") for i, e in enumerate(own))
            object.__setattr__(self, name, (*own, *entries[len(own) :]))
        self._check_symbols()

    def _read_mass(self, n: int) -> None:
        cure = "mass=[[m]]" if n == 1 else f"{n} rows of {n} expressions"
        try:
            mass = sp.ImmutableMatrix(self.mass)
        except (TypeError, ValueError):
            raise SceneError(f"mass is {shortened(self.mass)}, not a matrix; give {cure}") from None
        if mass.shape != (n, n):
            need = f"{counted(n, 'coordinate')} {'needs' if n == 1 else 'need'} ({n}, {n})"
            raise SceneError(f"the mass matrix has shape {mass.shape}; {need}")
        object.__setattr__(self, "mass", mass)

    def _check_symbols(self) -> None:
        names = [legible(s.name, "a state") for s in self.states]
        double = next((name for i, name in enumerate(names) if name in names[:i]), None)
        if double:
            raise SceneError(f"two states are called {double}; give each its own symbol")
        if TIME.name in names:
            raise SceneError("a state is called t, which is reserved for time; rename it")
        mass = () if self.mass is None else tuple(self.mass)
        loads = () if self.linear is None else self.linear.expressions
        own_rates = self.z_rate[: len(self.z_rate) - self.made]
        for what, entries in (("force", self.force), ("z_rate", own_rates), ("mass", mass), ("load", loads)):
            for i, e in enumerate(entries):
                refuse_jumps(e, f"{what}[{i}]")
        refuse_typed_friction(self.force, self.u)
        if self.mass is None:
            return
        for i, e in enumerate(mass):
            refuse_speed(expression(e, entry := f"mass[{i // len(self.q)}][{i % len(self.q)}]"), entry)
            if e.free_symbols & ({*self.u, *self.z, TIME}):
                raise SceneError(f"{entry} is {e}; it may depend on q only")
        if not (self.mass - self.mass.T).applyfunc(sp.expand).is_zero_matrix:
            raise SceneError("the mass matrix is not symmetric")

    @cached_property
    def states(self) -> tuple[sp.Symbol, ...]:
        """All states in the order of ``x = [q; u; z]``."""
        return (*self.q, *self.u, *self.z)

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """Every expression of the system."""
        mass = () if self.mass is None else self.mass
        if self.linear is None:
            return (*mass, *self.force, *self.z_rate)
        return (*mass, *(e for e in self.force if e != 0), *self.z_rate, *self.linear.expressions)

    @property
    def rows(self) -> tuple[sp.Symbol, ...]:
        """Symbols that stand for combinations of the states."""
        return () if self.linear is None else tuple(self.linear.rows)

    def slopes(self, slip: sp.Expr) -> list[sp.Expr] | np.ndarray:
        """Return the derivatives of a slip by the velocities: an array if they come from rows of numbers.

        Parameters
        ----------
        slip : Expr

        Returns
        -------
        list or ndarray
        """
        return slopes_of(slip, self.u, self.linear)

    def written_out(self) -> "System":
        """Return the same with all entries as expressions, for reading and for closed forms of small systems.

        Returns
        -------
        System

        Raises
        ------
        SceneError
            If it has matrices of more than `_WRITTEN` coordinates.
        """
        part = self.linear
        if part is None:
            return self
        n = len(self.q)
        if n > _WRITTEN:
            raise SceneError(
                f"equations of {n} coordinates given by matrices are not written out; reduce the structure"
            )
        q, u = sp.Matrix(self.q), sp.Matrix(self.u)

        def dense(A: Any) -> sp.Matrix:
            return sp.Matrix(A.toarray().tolist()).applyfunc(_whole)

        force = sp.Matrix(list(self.force)) - dense(part.K) * q
        force -= dense(part.C) * u if part.C is not None else sp.zeros(n, 1)
        for factor, A in part.scaled:
            force -= factor * dense(A) * q
        for load, row in part.loads:
            force += load * sp.Matrix(row.tolist()).applyfunc(_whole)
        mass = dense(part.M) + (sp.zeros(n, n) if self.mass is None else sp.Matrix(self.mass))
        rows = self.row_values()
        return System(
            self.q,
            self.u,
            mass.xreplace(rows),
            [e.xreplace(rows) for e in force],
            self.z,
            [e.xreplace(rows) for e in self.z_rate],
            made=self.made,
        )

    def row_values(self) -> dict[sp.Symbol, sp.Expr]:
        """Return the rows as expressions of the states.

        Returns
        -------
        dict of Symbol to Expr
        """
        if self.linear is None:
            return {}
        return {
            s: sp.Add(
                *(
                    _whole(sp.Float(w)) * e
                    for w, e in zip(r.weights, self.q if r.of == "q" else self.u, strict=True)
                    if w
                )
            )
            for s, r in self.linear.rows.items()
        }


def _whole(e: sp.Expr) -> sp.Expr:
    """Return a small whole number without its decimal point, as one writes it."""
    return sp.Integer(int(e)) if e.is_Float and abs(e) < 1000 and float(e).is_integer() else e


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
            raise SceneError(f"the name of a contact is {self.name!r}; it must be a string")
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


@dataclass(frozen=True, eq=False)
class Signal:
    """A sampled input, linear between its samples, or held from each to the next; zero outside them.

    Attributes
    ----------
    samples : ndarray, shape (n,)
        At least two.
    dt : float
        Sampling interval, > 0.
    t0 : float
        Time of the first sample.
    unit : str or None
        For display only.
    hold : bool
        Whether a sample is held until the next (zero-order hold), the last one for dt, instead of joined by lines.

    Examples
    --------
    >>> import symfric as sf
    >>> signal = sf.Signal([0.0, 1.0, 0.0], dt=0.5, unit="m/s^2")
    >>> round(signal.t_end, 6)
    1.0
    >>> round(float(signal(0.25)), 6)
    0.5
    >>> sf.Signal([2.0, 3.0], dt=0.5, hold=True)([0.0, 0.4, 0.5, 0.9, 1.0]).tolist()
    [2.0, 2.0, 3.0, 3.0, 0.0]
    """

    samples: np.ndarray
    dt: float
    t0: float = 0.0
    unit: str | None = None
    hold: bool = False

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        samples = numbers_of(self.samples, "samples")
        if samples.ndim != 1 or samples.size < 2:
            raise SceneError(f"a signal has shape {samples.shape}; give an array of two or more samples")
        if not np.all(np.isfinite(samples)):
            raise SceneError(f"sample {int(np.flatnonzero(~np.isfinite(samples))[0])} of a signal is not finite")
        samples.setflags(write=False)
        object.__setattr__(self, "samples", samples)
        object.__setattr__(self, "dt", finite(self.dt, "the sampling interval dt"))
        object.__setattr__(self, "t0", finite(self.t0, "the start t0 of a signal"))
        if self.dt <= 0:
            raise SceneError(f"the sampling interval dt is {self.dt}; it must be positive")

    @property
    def t_end(self) -> float:
        """Time of the last sample, or to which it is held."""
        return self.t0 + self.dt * (self.samples.size - (not self.hold))

    def __call__(self, t: float | np.ndarray) -> np.ndarray:
        """Evaluate at times t, any shape."""
        if self.hold:
            place = np.floor((np.asarray(t, dtype=float) - self.t0) / self.dt + 1e-9)
            inside = (place >= 0) & (place < self.samples.size)
            return np.where(inside, self.samples[np.where(inside, place, 0).astype(int)], 0.0)
        grid = self.t0 + self.dt * np.arange(self.samples.size)
        return np.asarray(np.interp(t, grid, self.samples, left=0.0, right=0.0))
