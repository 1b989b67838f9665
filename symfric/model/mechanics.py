"""Equations of motion from energies, through SymPy's Lagrange's method."""

from collections.abc import Mapping, Sequence

import sympy as sp
from sympy.physics.mechanics import LagrangesMethod

from symfric.errors import SceneError
from symfric.model.names import TIME, expression
from symfric.model.system import System


def lagrange(
    *, kinetic, potential=0, dissipation=0, loads: Mapping | None = None, q: Sequence, u: Sequence | None = None
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
        If the energies are not functions of q, u and parameters.
    """
    q = list(q)
    kinetic, potential, dissipation = (
        expression(e, name)
        for e, name in ((kinetic, "kinetic"), (potential, "potential"), (dissipation, "dissipation"))
    )
    moving = [c if c.args else sp.Function(c.name)(TIME) for c in q]
    rates = [c.diff(TIME) for c in moving]
    if u is None:
        if any(not c.args for c in q):
            raise SceneError("give the velocities u of the coordinates, or coordinates that are functions of time")
        u = [sp.Symbol(f"{c.func.__name__}_dot", real=True) for c in q]
    if len(u) != len(q):
        raise SceneError(f"{len(q)} coordinates in q and {len(u)} velocities in u; give one velocity for each")
    still = [sp.Symbol(c.func.__name__, real=True) if c.args else c for c in q]
    to_moving = {**dict(zip(u, rates, strict=True)), **{c: m for c, m in zip(q, moving, strict=True) if not c.args}}
    forward = lambda e: sp.sympify(e).subs(to_moving)  # noqa: E731
    unknown = [c for c in (loads or {}) if c not in q]
    if unknown:
        raise SceneError(f"a load acts on {unknown[0]}, which is no coordinate in q")
    T, V, R = forward(kinetic), forward(potential), forward(dissipation)
    method = LagrangesMethod(T - V, moving)
    method.form_lagranges_equations()
    back = lambda e: e.subs(dict(zip(rates, u, strict=True))).subs(dict(zip(moving, still, strict=True)))  # noqa: E731
    force = []
    for i, c in enumerate(q):
        applied = forward((loads or {}).get(c, 0)) - R.diff(rates[i])
        force.append(sp.simplify(back(method.forcing[i] + applied)))
    return System(q=still, u=list(u), mass=back(method.mass_matrix).applyfunc(sp.simplify), force=force)
