"""Energy and power of a scene as CasADi functions, for the balance along a run."""

import casadi as ca

from symfric.lower.automaton import Lowering, accelerations
from symfric.model.scene import Scene


def energy_functions(scene: Scene) -> tuple[ca.Function, ca.Function]:
    r"""Return the power of the forces and the kinetic energy.

    Returns
    -------
    power : casadi.Function
        ``(y, t, p, modes) -> (applied, contact)`` with modes -1, 0, +1 for each contact: ``u^T f + u^T (dM/dt) u / 2``
        and ``lambda^T J u``. The signs of kinks are taken from the state.
    kinetic : casadi.Function
        ``(y, p) -> u^T M u / 2``.
    """
    low = Lowering(scene, {})
    n, nc = len(scene.system.q), len(scene.contacts)
    q, u = low.y[:n], low.y[n : 2 * n]
    f, mass = low.vector(scene.system.force), low.mass()
    _, friction = accelerations(low, f, mass, tested=True)
    energy = 0.5 * u.T @ mass @ u
    turning = ca.jacobian(energy, q) @ u
    applied = u.T @ f + turning
    contact = friction.T @ (ca.jacobian(low.w, u) @ u) if nc else ca.SX(0)
    modes = ca.SX.sym("modes", nc)
    out = low.unswitched([applied, contact])
    if nc:
        out = ca.substitute(out, [low.s, low.d], [modes == 0, ca.if_else(modes < 0, -1, 1)])
    power = ca.Function("power", [low.y, low.t, low.p, modes], [ca.densify(e) for e in out])
    return power, ca.Function("kinetic", [low.y, low.p], [ca.densify(energy)])
