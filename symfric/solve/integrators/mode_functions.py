"""CasADi functions of the route `integrators`: integrator and dense output of one mode."""

import math

import casadi as ca
import numpy as np

from symfric.lower.automaton import Automaton
from symfric.solve.integrators.mode_selection import along

ONE_STEP = ("erk", "rosenbrock")  # cheap to restart, so that modes are integrated in short pieces
CONTINUOUS = ("cvodes", "idas", "collocation")


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
    n_x, n_p, n_m = field.nnz_in(0), field.nnz_in(2), field.nnz_in(3)
    n = n_x + n_integrals
    state, time = ca.SX.sym("state", n), ca.SX.sym("time")
    p, m, size = ca.SX.sym("p", n_p), ca.SX.sym("m", n_m), ca.SX.sym("size", n)
    begin, length = ca.SX.sym("begin"), ca.SX.sym("length")
    inside = (state * size)[:n_x]
    rate, _, rows = field(inside, begin + length * time, p, m)
    integrals = rows[:n_integrals] if n_integrals else ca.SX(0, 1)  # [:0] of a single row is 1-by-0, not 0-by-1
    data = ca.vertcat(p, m, size, begin, length)
    dae = {"x": state, "t": time, "p": data, "ode": length * ca.vertcat(rate, integrals) / size}
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
    y, t, p = ca.SX.sym("y", field.nnz_in(0)), ca.SX.sym("t"), ca.SX.sym("p", field.nnz_in(2))
    n_m = field.nnz_in(3)
    m = ca.SX.sym("m", n_m)
    sign = lambda e: ca.if_else(e < 0, -1, 1)  # noqa: E731
    mode = ca.vertsplit(m) if n_m else []
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
    y, t = ca.SX.sym("y", field.nnz_in(0)), ca.SX.sym("t")
    p, m, size = ca.SX.sym("p", field.nnz_in(2)), ca.SX.sym("m", field.nnz_in(3)), ca.SX.sym("size", y.numel())
    rate, guards, rows = field(y, t, p, m)
    rows = ca.vertcat(guards, rows[n_integrals:])
    first = along(rows, rate, y, t)
    blur = ca.densify(ca.fabs(ca.jacobian(rows, y)) @ (size + ca.fabs(y)))
    out = [rate, along(rate, rate, y, t), rows, first, along(first, rate, y, t), blur]
    return ca.Function("nodes", [y, t, p, m, size], out)
