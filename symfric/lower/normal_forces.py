"""Normal forces of contacts that open, while they are closed.

With all other forces, those of sticking contacts included, the accelerations are an affine function of the normal
forces, ``u' = a + B N``; friction that a normal force causes is part of B, which is why ``G = J B`` is not symmetric.
So ``O G O N = -O (J a + c)`` with O the contacts that are closed; J and c as in `symfric.lower.unilateral`.
"""

from collections.abc import Sequence

import casadi as ca
import sympy as sp

from symfric.errors import SceneError
from symfric.lower.constraint_forces import constraint_basis
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.lower.held_velocities import held_velocities
from symfric.lower.linear_part import applied_in
from symfric.lower.unilateral import Opening, approach, eliminated


def with_normal_forces(model: ContactDynamics, acceleration: ca.SX, out: list[ca.SX]) -> tuple[ca.SX, list[ca.SX]]:
    """Return accelerations and other graphs with the normal forces of contacts that open.

    Velocities that closed gaps and sticking contacts determine together get the acceleration of the constraints alone,
    under which a body at rest does not creep, see `symfric.lower.held_velocities`.

    Parameters
    ----------
    model : ContactDynamics
    acceleration : SX, shape (n,)
        As `ContactDynamics.accelerations` returns them.
    out : list of SX
    """
    if not model.openings:
        return acceleration, out
    forces, rate = _forces(model.openings, model.q, model.u, model.t, acceleration)
    sticking, drift, holds = model.held_by_sticking
    J, _, bend = approach(ca.vertcat(*(e.gap for e in model.openings)), model.q, model.u, model.t)
    rows, drift = ca.vertcat(model.slopes[sticking, :], J), ca.vertcat(drift, bend)
    holds = ca.vertcat(holds, *(e.closed for e in model.openings))
    basis = constraint_basis(rows, model.solve(rows.T), holds, tested=False)
    velocities = held_velocities(rows, model.mass, basis, drift, ca.vertcat(model.y, model.t), None)
    for k, flag, own_rate in zip(velocities.places, velocities.held, velocities.rates, strict=True):
        rate[k] = ca.if_else(flag, own_rate, rate[k])
    return rate, ca.substitute(out, [model.pressed], [forces])


def least_normal_forces(model: ContactDynamics) -> ca.SX:
    """Return normal forces without any forces that cancel each other, as scales; shape (n_n,)."""
    J, _, drift = approach(ca.vertcat(*(e.gap for e in model.openings)), model.q, model.u, model.t)
    spread = model.solve(J.T)
    applied = [sum(ca.fabs(model.read(term)) for term in sp.Add.make_args(e)) for e in model.system.force]
    pushed = ca.substitute(ca.vertcat(*applied), model.pressed, ca.SX.zeros(model.pressed.numel()))
    if model.system.linear is not None:
        pushed += applied_in(model.system.linear, model.read, model.q, model.u)
    return ca.densify(ca.fabs(spread).T @ pushed + ca.fabs(drift)) / ca.diag(J @ spread)


def _forces(openings: Sequence[Opening], q: ca.SX, u: ca.SX, t: ca.SX, acceleration: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the normal forces of contacts that open, zero while they are, and the accelerations with them.

    Parameters
    ----------
    openings : sequence of Opening
    q, u, t : SX
        Coordinates, velocities, time.
    acceleration : SX, shape (n,)
        u' as a function of the symbols of the normal forces.

    Raises
    ------
    SceneError
        If the accelerations are not linear in the normal forces.
    """
    forces = ca.vertcat(*(e.force for e in openings))
    J, _, drift = approach(ca.vertcat(*(e.gap for e in openings)), q, u, t)
    by_forces = ca.jacobian(acceleration, forces)
    if ca.depends_on(by_forces, forces):
        raise SceneError(
            "a force, load or law is not linear in the normal force of a contact that opens; write it as a factor "
            "times sf.normal_force(name)"
        )
    free = ca.substitute(acceleration, forces, ca.SX.zeros(forces.numel()))
    closed = ca.vertcat(*(e.closed for e in openings))
    coupling = (closed @ closed.T) * (J @ by_forces) + ca.diag(1 - closed)
    multipliers = eliminated(coupling, -closed * (J @ free + drift))
    rate = ca.SX(ca.densify(free + by_forces @ multipliers))
    for i, e in enumerate(openings):
        places = ca.sparsify(J[i, :]).sparsity().get_triplet()[1]
        if len(places) == 1 and J[i, places[0]].is_constant():  # exact, so that a body at rest stays there
            k = places[0]
            rate[k] = ca.if_else(e.mode > 0.5, rate[k], -drift[i] / J[i, k])
    return multipliers, rate
