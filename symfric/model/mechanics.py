"""Equations of motion from energies by Lagrange's method of SymPy; gap and slip of bodies that move in a plane."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import sympy as sp
from sympy.physics.mechanics import LagrangesMethod

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.jumps import refuse_jumps
from symfric.model.kinks import CURES, gradient, simplified, with_magnitudes, without_signs
from symfric.model.planar import Body, Point, Touch, against_circle, against_line
from symfric.model.public_names import names_of
from symfric.model.steps import with_steps
from symfric.model.symbols import TIME, listed, mapped, scalar
from symfric.model.system import System

__all__ = ["Body", "Point", "Touch", "against_circle", "against_line", "lagrange"]


@alone(SYMBOLIC)
def lagrange(
    *,
    kinetic: sp.Expr,
    potential: sp.Expr | float = 0,
    dissipation: sp.Expr | float = 0,
    loads: Mapping[Any, sp.Expr | float] | None = None,
    q: Sequence[sp.Expr],
    u: Sequence[sp.Symbol] | None = None,
) -> System:
    """Derive a `System` from its energies by Lagrange's equations.

    Parameters
    ----------
    kinetic, potential, dissipation : Expr
        T(q, u), V(q) and Rayleigh's function R(u), which takes ``-dR/du`` from the generalised forces.
    loads : mapping of coordinate to Expr
        Generalised forces by coordinate.
    q : sequence
        Coordinates: either symbols (then give `u`) or functions of time such as those of
        ``sympy.physics.mechanics.dynamicsymbols``, whose derivatives are then the velocities.
    u : sequence of Symbol, optional
        Velocities ``u = q'``; for functions of time ``q`` they are called ``q_dot`` unless given.

    Returns
    -------
    System
        In plain symbols; coordinates that came as functions ``x(t)`` become symbols ``x``.

    Raises
    ------
    SceneError
        If the energies are not functions of q, u and parameters, or a force jumps.

    Notes
    -----
    Energies may have kinks (Abs, Max, Min, Piecewise) where the force that stems from them has none or a kink itself:
    ``k Abs(x)**3`` and ``k Max(0, x - g)**2`` are fine, ``c Abs(u)`` is dry friction and belongs in a Contact.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u, m, k = sp.symbols("x u m k", real=True)
    >>> system = sf.mechanics.lagrange(kinetic=m * u**2 / 2, potential=k * x**2 / 2, q=[x], u=[u])
    >>> system.mass, system.force
    (Matrix([[m]]), (-k*x,))
    """
    q, loads = listed(q, "q"), mapped({} if loads is None else loads, "loads", "loads={x: force}")
    u = None if u is None else listed(u, "u")
    q = tuple(scalar(c, "a coordinate in q") for c in q)
    unknown = [c for c in loads if c not in list(q)]
    if unknown:
        raise SceneError(f"a load acts on {unknown[0]}, which is no coordinate in q")
    still, u, to_states = _states(list(q), u)
    given = {"kinetic": kinetic, "potential": potential, "dissipation": dissipation}
    given.update({f"the load on {c}": loads.get(c, 0) for c in q})
    for name, e in given.items():
        given[name] = with_steps(to_states(scalar(e, name), name), name)
        refuse_jumps(given[name], name)
    kinetic, potential, dissipation, *applied = given.values()
    real = [s if s.is_real else sp.Symbol(s.name, real=True) for s in (*still, *u)]
    x, v = real[: len(still)], real[len(still) :]
    mass, force = _inertia(kinetic, x, v)
    for i, load in enumerate(applied):
        force[i] += (
            load
            - gradient(potential, x[i], "potential", CURES["potential"])
            - gradient(dissipation, v[i], "dissipation", CURES["dissipation"])
        )
    back = dict(zip(real, (*still, *u), strict=True))
    mass, force = mass.applyfunc(simplified).xreplace(back), [simplified(e).xreplace(back) for e in force]
    return System(q=still, u=u, mass=mass, force=force)


def _states(
    q: list[sp.Expr], u: Sequence[sp.Symbol] | None
) -> tuple[list[sp.Symbol], list[sp.Symbol], Callable[[sp.Expr, str], sp.Expr]]:
    """Return coordinates and velocities as symbols, and a function that rewrites an expression in these."""
    if u is None:
        if any(not c.args for c in q):
            raise SceneError("give the velocities u of the coordinates, or coordinates that are functions of time")
        u = [sp.Symbol(f"{c.func.__name__}_dot", real=True) for c in q]
    if len(u) != len(q):
        raise SceneError(f"{len(q)} coordinates in q and {len(u)} velocities in u; give one velocity for each")
    still = [sp.Symbol(c.func.__name__, real=True) if c.args else c for c in q]
    rates = {c.diff(TIME): r for c, r in zip(q, u, strict=True) if c.args}
    real = {s: sp.Symbol(s.name, real=True) for s in (*still, *u) if not s.is_real}

    def to_states(e: sp.Expr, name: str) -> sp.Expr:
        strange = next((d for d in e.atoms(sp.Derivative) if d not in rates), None)
        if strange is not None:
            raise SceneError(f"{name} contains {strange}; it may depend on q, q' and time only")
        if double := e.free_symbols & set(real.values()):
            raise SceneError(f"{name} uses {double.pop()} as two different symbols; create it once, and use that")
        return e.subs(rates).subs(dict(zip(q, still, strict=True))).xreplace(real)

    return still, list(u), to_states


def _inertia(kinetic: sp.Expr, q: list[sp.Symbol], u: list[sp.Symbol]) -> tuple[sp.Matrix, list[sp.Expr]]:
    """Return the mass matrix and the inertial forces of a kinetic energy, by Lagrange's method of SymPy."""
    plain, extremes = with_magnitudes(kinetic)
    moving = [sp.Function(c.name, real=True)(TIME) for c in q]
    rates = [c.diff(TIME) for c in moving]
    method = LagrangesMethod(plain.subs(dict(zip((*u, *q), (*rates, *moving), strict=True))), moving)
    method.form_lagranges_equations()

    def back(e: Any) -> Any:
        return e.doit().subs(dict(zip(rates, u, strict=True))).subs(dict(zip(moving, q, strict=True)))

    forces = [without_signs(back(e), "the force from the kinetic energy", CURES["kinetic"]) for e in method.forcing]
    return back(method.mass_matrix).xreplace(extremes), [e.xreplace(extremes) for e in forces]


if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
