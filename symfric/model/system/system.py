"""The equations of motion of a mechanical system, apart from its contacts."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import instance, whole
from symfric.model.jumps import refuse_jumps
from symfric.model.linear_part import LinearPart, slopes_of
from symfric.model.steps import with_steps
from symfric.model.symbols import TIME, counted, expression, legible, listed, refuse_speed, shortened
from symfric.model.typed_friction import refuse_typed_friction
from symfric.spelling import spelt

_WRITTEN = 12  # coordinates up to which matrices become expressions for reading


@spelt
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
        if self.linear is not None:
            instance(self.linear, LinearPart, "linear")
        whole(self.made, "made", least=0, most=len(self.z))
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
