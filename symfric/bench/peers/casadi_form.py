"""CasADi's Runge-Kutta integrator with its own events on a written-out scene, interpreted and as compiled C."""

import contextlib
import io
import math
from collections.abc import Callable

import casadi as ca
import numpy as np
import sympy as sp

from symfric.bench.peers.casadi_erk import compiled
from symfric.bench.peers.written_out import Form, Loop, form_of
from symfric.bench.problems import Problem
from symfric.bench.result import Answer

WORKAROUNDS = ("a sampled input is a control on the grid of its samples",)


def prepare_interpreted(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Return a function that runs the integrator in CasADi's virtual machine."""
    form = form_of(problem.scene)
    return _running(_integrator(form, tolerance), form)


def prepare_compiled(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Generate C for the whole integration, compile it, and return a function that runs it."""
    form = form_of(problem.scene)
    return _running(compiled(_integrator(form, tolerance)), form)


def _integrator(form: Form, tolerance: float) -> ca.Function:
    """Return the integrator of the states, the mode and the number of events."""
    names = (*form.states, *form.signs, *form.moving)
    x = ca.SX.sym("x", len(names) + 1)
    t, index, line = ca.SX.sym("t"), ca.SX.sym("index"), ca.SX.sym("line", 2)
    arguments = [t, *ca.vertsplit(x)[:-1], *ca.vertsplit(line)]
    printed = lambda e: _as_casadi(form, e)(*arguments)  # noqa: E731
    rates, guards = printed(form.rates), printed(form.guards)
    after = x
    for k in range(len(guards)):
        after = ca.if_else(index == k, _after(form, x, k, printed), after)
    empty = [ca.SX.sym(name, size) for name, size in (("z", 0), ("p", 0))]
    transition = ca.Function(
        "transition", [index, t, x, *empty, line], [after, ca.SX(0, 1)], ca.event_in(), ca.event_out()
    )
    ode = ca.vertcat(*rates, ca.SX.zeros(len(form.signs) + len(form.moving) + 1))
    dae = {"x": x, "t": t, "u": line, "ode": ode, "zero": ca.vertcat(*guards)}
    limits = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": 10**8, "max_events": 10**6}
    grid = [segment[0] for segment in form.segments]
    with contextlib.redirect_stderr(io.StringIO()):  # "Event support is experimental"
        return ca.integrator("stick_slip", "erk", dae, 0, grid, {**limits, "transition": transition})


def _after(form: Form, x: ca.SX, k: int, printed) -> ca.SX:
    """Return the states after guard k has fallen; the same rules as `Loop.after`."""
    n, contacts = len(form.states), len(form.moving)
    result = ca.SX(x)
    if k >= contacts:
        result[n + k] = -x[n + k]
        return result
    place = n + len(form.signs) + k
    hold, limit, slip = (printed([e[k]])[0] for e in (form.holds, form.limits, form.slips))
    stuck = x[place] == 0
    result[:n] = x[:n] - ca.if_else(stuck, 0, slip) * form.shares[k]
    result[n + k] = ca.if_else(hold > 0, 1, -1)
    result[place] = ca.if_else(ca.logic_or(stuck, ca.fabs(hold) > limit), 1, 0)
    changed = ca.logic_or(stuck, ca.logic_or(result[n + k] != x[n + k], result[place] == 0))
    result[x.numel() - 1] = x[x.numel() - 1] + ca.if_else(changed, 1, 0)
    return result


def _as_casadi(form: Form, expressions):
    return sp.lambdify(form.arguments, list(expressions), [{"sin": ca.sin, "cos": ca.cos, "exp": ca.exp}, math])


def _running(function: ca.Function, form: Form) -> Callable[[], Answer]:
    start = [*form.start, *Loop(form).first(list(form.start)), 0.0]
    lines = np.array([segment[1:] for segment in form.segments]).T
    n = len(form.states)

    def run() -> Answer:
        end = np.array(function(x0=start, u=lines)["xf"])[:, -1]
        return Answer(tuple(end[:n].tolist()), int(end[-1]))

    return run
