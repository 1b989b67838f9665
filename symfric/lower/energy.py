"""Energy and power of a scene as CasADi functions, for the energy balance of a run."""

import casadi as ca

from symfric.lower.clocks import Clocks
from symfric.lower.constraint_forces import FOLLOWS, HOLDS, constraint_basis
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.lower.mode_layout import OPEN
from symfric.lower.normal_forces import with_normal_forces
from symfric.model.scene import Scene

_LARGEST = 1e300


def energy_functions(scene: Scene) -> tuple[ca.Function, ca.Function]:
    r"""Return CasADi functions of the power of the forces and of the kinetic energy.

    Returns
    -------
    power : casadi.Function
        ``(y, t, p, modes) -> (applied, contact)`` with modes -1, 0, +1 for each contact, 2 where it is open, those
        behind springs and stops last, whose forces count as applied, as normal forces do: ``u^T f + u^T (dM/dt) u / 2``
        and ``lambda^T J u``. The signs of kinks are taken from the state.
    kinetic : casadi.Function
        ``(y, p) -> u^T M u / 2``.
    """
    model = ContactDynamics.of(scene)
    f, mass, u, slip = model.force, model.mass, model.u, model.slip
    defined = _zero_where_undefined if not model.openings else _as_it_is  # linear in the normal forces
    acceleration, friction = model.accelerations(True, defined)
    energy = 0.5 * u.T @ mass @ u
    turning = ca.jacobian(energy, model.q) @ u
    applied = u.T @ f + turning
    lines, springs = ca.SX.sym("modes", slip.numel()), [s.shown for s in model.springs if not isinstance(s, Clocks)]
    springs = [s for s, spring in zip(springs, model.springs, strict=False) if spring not in model.openings]
    stops = ca.SX.sym("stops", sum(e.line < 0 for e in model.openings))
    contact = friction.T @ (model.slopes @ u) if slip.numel() else ca.SX(0)
    modes = ca.vertcat(lines, *springs, stops)
    out = model.unswitched(with_normal_forces(model, acceleration, [applied, contact])[1])
    if slip.numel():
        holds = _holding(model, lines) if model.openings else lines == 0
        out = ca.substitute(out, [model.s, model.d], [holds, ca.if_else(lines < 0, -1, 1)])
    for plane in model.planes:  # its direction is that of its slip
        out = ca.substitute(out, [plane.variables], [ca.SX.zeros(plane.variables.numel())])
    if model.openings:
        shown = iter(ca.vertsplit(stops))
        is_open = [(lines[e.line] if e.line >= 0 else next(shown)) == OPEN for e in model.openings]
        out = ca.substitute(out, [e.mode for e in model.openings], is_open)
    power = ca.Function("power", [model.y, model.t, model.p, modes], [ca.densify(e) for e in out])
    return power, ca.Function("kinetic", [model.y, model.p], [ca.densify(energy)])


def _holding(model: ContactDynamics, lines: ca.SX) -> ca.SX:
    """Return the marks of contacts that stick: a slip that follows from closed gaps and others has none."""
    sticking, _, _ = model.held_by_sticking
    rows = ca.vertcat(ca.jacobian(ca.vertcat(*(e.gap for e in model.openings)), model.q), model.slopes[sticking, :])
    closed = ca.vertcat(*(e.closed for e in model.openings), lines[sticking] == 0)
    own = constraint_basis(rows, model.solve(rows.T), closed, tested=True).own[len(model.openings) :]
    marks = ca.SX(lines == 0)
    for i, holds in zip(sticking, own, strict=True):
        marks[i] = ca.if_else(lines[i] == 0, ca.if_else(holds, HOLDS, FOLLOWS), 0)
    return model.unswitched([marks])[0]


def _as_it_is(values: ca.SX) -> ca.SX:
    """Return expressions as they are."""
    return values


def resets_functions(scene: Scene) -> tuple[ca.Function, ca.Function]:
    """Return CasADi functions of the states after every reset, and of the guards of resets.

    Returns
    -------
    after : casadi.Function
        ``(y, t, p) -> y+`` with a column for every reset, or for every time of one whose values differ, in their order.
    guards : casadi.Function
        ``(y, t, p) -> guards`` of the resets that have one, in their order.
    """
    model = ContactDynamics.of(scene)
    clocks = next(s for s in model.springs if isinstance(s, Clocks))
    columns = []
    for reset in scene.resets:
        for entry in range(max(len(values) for values in reset.set.values())):
            after = ca.SX(model.y)
            for place, value in clocks.after_reset(reset, entry).items():
                after[place] = value
            columns.append(after)
    guards = [clocks.guard_of(r) for r in scene.resets if r.guard is not None]
    at = [model.y, model.t, model.p]
    found = ca.horzcat(*columns), ca.vertcat(*guards)
    return ca.Function("resets", at, [ca.densify(found[0])]), ca.Function("guards", at, [ca.densify(found[1])])


def _zero_where_undefined(values: ca.SX) -> ca.SX:
    """Return expressions with zero for NaN, which a mode that multiplies them by zero would not remove.

    The rate of a belt that jerks is infinity over infinity far from the jerk; the root of a speed that rounding made
    negative has no value. ``fmax`` and ``fmin`` ignore a NaN.
    """
    return 0.5 * (ca.fmax(values, -_LARGEST) + ca.fmin(values, _LARGEST))
