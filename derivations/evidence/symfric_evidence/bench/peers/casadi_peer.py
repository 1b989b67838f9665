"""CasADi's Runge-Kutta integrator with its own events on a written-out scene, interpreted and as compiled C."""

import contextlib
import io
import math
import subprocess
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path

import casadi as ca
import numpy as np
import sympy as sp

from symfric_evidence.bench.peers.written_out import PeerLoop, WrittenForm, form_of
from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer

WORKAROUNDS = (
    "the mode is a state that the transition changes: of each contact 1 or -1, and 0 where it sticks",
    "a sampled input is a control on the grid of its samples",
    "max_num_steps and max_events raised; the defaults stop long runs",
    "called through a buffer, which avoids the conversion of arguments",
)


def prepare_interpreted(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that runs the integrator in CasADi's virtual machine."""
    form = form_of(problem.scene)
    return _running(_integrator(form, tolerance), form)


def prepare_compiled(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Generate C for the whole integration, compile it, and return a function that runs it."""
    form = form_of(problem.scene)
    return _running(_compiled(_integrator(form, tolerance)), form)


def prepare_stiff(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that runs cvodes through the branches of a law without events."""
    form = form_of(problem.scene, through=True)
    x, t = ca.SX.sym("x", len(form.states) + 1), ca.SX.sym("t")
    rates = _as_casadi(form, form.rates)(t, *ca.vertsplit(x)[:-1])
    dae = {"x": x, "t": t, "ode": ca.cse(ca.vertcat(*rates, 0))}  # the last state is the number of events
    options = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": 10**7}
    return _running(ca.integrator("stiff", "cvodes", dae, 0, form.horizon, options), form)


def _compiled(function: ca.Function) -> ca.Function:
    """Return the function compiled by a C compiler."""
    with tempfile.TemporaryDirectory() as folder:
        code = ca.CodeGenerator("stick_slip.c")
        code.add(function)
        source, library = code.generate(f"{folder}/"), Path(folder) / "stick_slip.so"
        command = ["cc", "-O3", "-march=native", "-shared", "-fPIC", source, "-o", str(library), "-lm"]
        subprocess.run(command, check=True, capture_output=True)
        return ca.external(function.name(), str(library))


def _integrator(form: WrittenForm, tolerance: float) -> ca.Function:
    """Return the integrator of the states, the mode and the number of events."""
    n, contacts, lines = len(form.states), len(form.moving), len(form.line)
    x = ca.SX.sym("x", n + len(form.signs) + 1)
    t, index, line = ca.SX.sym("t"), ca.SX.sym("index"), ca.SX.sym("line", lines)
    mode = ca.vertsplit(x[n:-1])
    moving = [m**2 for m in mode[:contacts]]
    arguments = [t, *ca.vertsplit(x[:n]), *mode, *moving, *(line[k] for k in range(lines))]

    def printed(e: Iterable[sp.Expr]) -> list[ca.SX]:
        return _as_casadi(form, e)(*arguments)

    holds, limits, slips = printed(form.holds), printed(form.limits), printed(form.slips)
    guards, after = [], x
    for k, m in enumerate(mode[:contacts]):
        guards.append(ca.if_else(m == 0, limits[k] - ca.fabs(holds[k]), m * slips[k]))
        after = ca.if_else(index == k, _after(form, x, k, holds[k], limits[k], slips[k]), after)
    for k, e in enumerate(printed(form.kinks), contacts):
        guards.append(mode[k] * e)
        turned = ca.SX(x)
        turned[n + k] = -x[n + k]
        after = ca.if_else(index == k, turned, after)
    empty = [ca.SX.sym(name, size) for name, size in (("z", 0), ("p", 0))]
    transition = ca.Function(
        "transition", [index, t, x, *empty, line], [after, ca.SX(0, 1)], ca.event_in(), ca.event_out()
    )
    ode = ca.vertcat(*printed(form.rates), ca.SX.zeros(len(form.signs) + 1))
    dae = {"x": x, "t": t, "u": line, "ode": ode, "zero": ca.vertcat(*guards)}
    options = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": 10**8, "max_events": 10**6}
    grid = [segment[0] for segment in form.segments]
    with contextlib.redirect_stderr(io.StringIO()):  # "Event support is experimental"
        return ca.integrator("stick_slip", "erk", dae, 0, grid, {**options, "transition": transition})


def _after(form: WrittenForm, x: ca.SX, k: int, hold: ca.SX, limit: ca.SX, slip: ca.SX) -> ca.SX:
    """Return the states after the guard of contact k has fallen; the same rules as `Loop.after`."""
    n, result = len(form.states), ca.SX(x)
    stuck = x[n + k] == 0
    for i in np.flatnonzero(form.shares[k]).tolist():
        result[i] = x[i] - ca.if_else(stuck, 0, slip) * form.shares[k, i]
    keeps = ca.logic_and(ca.logic_not(stuck), ca.fabs(hold) <= limit)
    result[n + k] = ca.if_else(keeps, 0, ca.if_else(hold > 0, 1, -1))
    result[x.numel() - 1] = x[x.numel() - 1] + (result[n + k] != x[n + k])
    return result


def _as_casadi(form: WrittenForm, expressions: Iterable[sp.Expr]) -> Callable[..., list[ca.SX]]:
    own: dict[str, Callable[..., ca.SX]] = {"sin": ca.sin, "cos": ca.cos, "exp": ca.exp, "abs": ca.fabs, "Abs": ca.fabs}
    own |= {"side": ca.sign, "branch": lambda side, above, below: ca.if_else(side > 0, above, below)}
    side = sp.Function("side")  # the printer writes the sign as a Python condition
    written = [sp.sympify(e).replace(sp.sign, side) for e in expressions]
    made: Callable[..., list[ca.SX]] = sp.lambdify(form.arguments, written, [own, math])
    return made


def _running(function: ca.Function, form: WrittenForm) -> Callable[[], BenchAnswer]:
    mode, contacts = PeerLoop(form).first(list(form.start)), len(form.moving)
    moving = mode[len(form.signs) :]
    signs = [*(s * m for s, m in zip(mode, moving, strict=False)), *mode[contacts : len(form.signs)]]
    return _Buffered(function, np.array([*form.start, *signs, 0.0]), form)


class _Buffered:
    """A function called through a buffer, which refers to the function and to the arrays without owning them."""

    def __init__(self, function: ca.Function, start: np.ndarray, form: WrittenForm):
        self._function, self._start, self._n = function, start, len(form.states)
        self._lines = np.array([segment[1:] for segment in form.segments])
        self._end = np.zeros((len(form.segments), start.size))
        self._buffer, self._evaluate = function.buffer()
        places = {name: function.index_in(name) for name in ("x0", "u")}
        self._buffer.set_arg(places["x0"], self._start.data)  # type: ignore[call-arg]  # the stub wants the size
        if form.line:
            self._buffer.set_arg(places["u"], self._lines.data)  # type: ignore[call-arg]  # likewise
        self._buffer.set_res(function.index_out("xf"), self._end.data)  # type: ignore[call-arg]  # likewise

    def __call__(self) -> BenchAnswer:
        self._evaluate()
        if self._buffer.ret():
            raise RuntimeError(f"{self._function.name()} ended before its horizon")
        *states, events = self._end[-1].tolist()
        return BenchAnswer(tuple(states[: self._n]), int(events))
