"""CasADi functions of the route `integrators`: integrator and dense output of one mode."""

import math
from typing import TYPE_CHECKING, NamedTuple

import casadi as ca
import numpy as np

from symfric.lower.automaton import Automaton, arguments_of
from symfric.solve.integrators.implicit.stretch import Stretch
from symfric.solve.integrators.modes.mode_selection import along

if TYPE_CHECKING:
    from symfric.solve.integrators.route import Integrators

ONE_STEP = ("erk", "rosenbrock")  # cheap to restart, so that modes are integrated in short pieces
CONTINUOUS = ("cvodes", "idas", "collocation")


class ModeEquations(NamedTuple):
    """Equations of the modes of one automaton, and how they are integrated.

    Attributes
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``, with what is not held in a mode computed from the state.
    automaton : Automaton
    n_integrals : int
        How many of the first rows are integrated too.
    settings : Integrators
    tolerance, horizon : float
    stretch : Stretch or None
        A change of variables.
    """

    field: ca.Function
    automaton: Automaton
    n_integrals: int
    settings: "Integrators"
    tolerance: float
    horizon: float
    stretch: Stretch | None


def mode_integrator(
    field: ca.Function,
    n_integrals: int,
    plugin: str,
    max_step: float,
    tolerance: float,
    span: float,
    elements: int,
    nodes: int | np.ndarray,
    steps: int,
) -> ca.Function:
    """Return the integrator of one mode over the scaled time 0 to 1, without events.

    Parameters
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``; the first rows are integrated too.
    n_integrals : int
    plugin : str
        Of `casadi.integrator`.
    max_step : float
        Longest step, infinite if there is none.
    tolerance : float
    span : float
        Longest unscaled time that will be integrated; scales `max_step`.
    elements : int
        Number of steps of "collocation".
    nodes : int or ndarray
        Number of equidistant outputs, the last at the end; or their scaled times.
    steps : int
        Most steps between two outputs.

    Returns
    -------
    casadi.Function
        Its states are y and the integrals over their sizes; its parameters p, m, the sizes, start and length of the
        interval.
    """
    y, _, p, m = arguments_of(field)
    n_x, n = y.numel(), y.numel() + n_integrals
    state, time, size = ca.SX.sym("state", n), ca.SX.sym("time"), ca.SX.sym("size", n)
    begin, length = ca.SX.sym("begin"), ca.SX.sym("length")
    inside = (state * size)[:n_x]
    rate, _, rows = field(inside, begin + length * time, p, m)
    integrals = rows[:n_integrals] if n_integrals else ca.SX(0, 1)  # [:0] of a single row is 1-by-0, not 0-by-1
    data = ca.vertcat(p, m, size, begin, length)
    dae = {"x": state, "t": time, "p": data, "ode": length * ca.vertcat(rate, integrals) / size}
    # one tolerance for both, since the states are scaled by their sizes
    options = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": steps, "show_eval_warnings": False}
    if plugin in ("cvodes", "idas"):
        options["disable_internal_warnings"] = True  # of failures, which are answered by shorter parts
    if plugin == "collocation":
        options = {"number_of_finite_elements": math.ceil(elements / np.size(nodes))}
    elif math.isfinite(max_step):
        options["max_step_size"] = max_step / span
    grid = nodes if isinstance(nodes, np.ndarray) else np.linspace(0, 1, nodes + 1)[1:]
    return ca.integrator("mode", plugin, dae, 0.0, grid.tolist(), options)


def signs_evaluated(automaton: Automaton) -> ca.Function:
    """Return the field with directions and switches computed from the state, but for contacts that can stick."""
    field = automaton.field
    layout, n_c = automaton.layout, len(automaton.contacts)
    y, t, p, m = arguments_of(field)
    sign = lambda e: ca.if_else(e < 0, -1, 1)  # noqa: E731
    mode = ca.vertsplit(m) if m.numel() else []
    for i, w in enumerate(ca.vertsplit(automaton.gauge(y, t, p)[0]) if n_c else []):
        if not automaton.sticks[i]:
            mode[i], mode[layout.direction(i)] = ca.SX(0), sign(w)
    mode[layout.signs] = [ca.SX(1)] * layout.switches
    for j in range(layout.switches):  # a switch may depend on earlier ones
        mode[layout.sign(j)] = sign(field(y, t, p, ca.vertcat(*mode))[1][layout.switch(j)])
    return ca.Function("field", [y, t, p, m], list(field(y, t, p, ca.vertcat(*mode))))


def node_function(field: ca.Function, n_integrals: int) -> ca.Function:
    """Return ``(y, t, p, m, size) -> (y', y'', r, r', r'', b)`` for dense output.

    r holds guards and the rows not integrated, b how much they change at most if every state changes by ``size + |y|``.
    """
    y, t, p, m = arguments_of(field)
    size = ca.SX.sym("size", y.numel())
    rate, guards, rows = field(y, t, p, m)
    rows = ca.vertcat(guards, rows[n_integrals:])
    first = along(rows, rate, y, t)
    blur = ca.densify(ca.fabs(ca.jacobian(rows, y)) @ (size + ca.fabs(y)))
    out = [rate, along(rate, rate, y, t), rows, first, along(first, rate, y, t), blur]
    return ca.Function("nodes", [y, t, p, m, size], out)
