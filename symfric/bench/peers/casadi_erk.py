"""CasADi's Runge-Kutta integrator with its own events, interpreted and as compiled C; cvodes on the regularised law."""

import contextlib
import io
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np

from symfric.bench.problems import Oscillator, Problem
from symfric.bench.result import Answer

WORKAROUNDS = (
    "the mode is a state that the transition changes, and one guard serves all modes: of two guards that fall at once "
    "CasADi would handle one",
    "max_num_steps and max_events raised; the defaults stop long runs",
    "called through a buffer, which avoids the conversion of arguments",
)


def prepare_interpreted(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Return a function that runs the integrator in CasADi's virtual machine."""
    return _through_buffer(_with_events(problem.by_hand, tolerance), problem.by_hand)


def prepare_compiled(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Generate C for the whole integration, compile it, and return a function that runs it."""
    return _through_buffer(compiled(_with_events(problem.by_hand, tolerance)), problem.by_hand)


def compiled(function: ca.Function) -> ca.Function:
    """Return the function as a C compiler makes it."""
    with tempfile.TemporaryDirectory() as folder:
        code = ca.CodeGenerator("stick_slip.c")
        code.add(function)
        source, library = code.generate(f"{folder}/"), Path(folder) / "stick_slip.so"
        command = ["cc", "-O3", "-march=native", "-shared", "-fPIC", source, "-o", str(library), "-lm"]
        subprocess.run(command, check=True, capture_output=True)
        return ca.external(function.name(), str(library))


def prepare_stiff(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Return a function that runs cvodes through the kinks of the regularised law."""
    o = problem.by_hand
    y = ca.SX.sym("y", 4)  # as many states as with events, the last two idle
    x, u, _, _ = ca.vertsplit(y)
    w = u - o.v_b
    speed = ca.fabs(w) - o.v_s
    outer = ca.sign(w) * (o.mu_s + speed * (o.c1 + o.c3 * speed**2))
    mu = ca.if_else(speed < 0, o.mu_s / o.v_s * w, outer)
    dae = {"x": y, "ode": ca.vertcat(u, -2 * o.beta * u - x - mu, 0, 0)}
    options = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": 10**7}
    return _through_buffer(ca.integrator("stiff", "cvodes", dae, 0, o.horizon, options), o)


def _with_events(o: Oscillator, tolerance: float) -> ca.Function:
    """Return the integrator of states (x, u, sign of slip or 0, number of events)."""
    y, t, index, none = ca.SX.sym("y", 4), ca.SX.sym("t"), ca.SX.sym("index"), ca.SX(0, 1)
    x, u, sign, events = ca.vertsplit(y)
    w = u - o.v_b
    drive = o.drive * ca.sin(o.Omega * t) if o.drive else 0
    slipping = drive - x - 2 * o.beta * u - sign * o.mu_s - w * (o.c1 + o.c3 * w**2)
    held = drive - x + o.held
    stick = sign == 0
    guard = ca.if_else(stick, o.mu_s - ca.fabs(held), sign * w)
    keeps = ca.logic_and(ca.fabs(held) <= o.mu_s, ca.logic_not(stick))
    after = ca.vertcat(x, o.v_b, ca.if_else(keeps, 0, ca.sign(held)), events + 1)
    arguments = [index, t, y, *(ca.SX.sym(name, 0) for name in "zpu")]
    transition = ca.Function("transition", arguments, [after, none], ca.event_in(), ca.event_out())
    dae = {"x": y, "t": t, "ode": ca.vertcat(u, ca.if_else(stick, 0, slipping), 0, 0), "zero": guard}
    limits = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": 10**8, "max_events": 10**6}
    with contextlib.redirect_stderr(io.StringIO()):  # "Event support is experimental"
        return ca.integrator("stick_slip", "erk", dae, 0, o.horizon, {**limits, "transition": transition})


def _through_buffer(function: ca.Function, o: Oscillator) -> Callable[[], Answer]:
    return _Buffered(function, np.array([o.x0, 0.0, o.start, 0.0]))


class _Buffered:
    """A function called through a buffer, which refers to the function and to both arrays without owning them."""

    def __init__(self, function: ca.Function, start: np.ndarray):
        self._function, self._start, self._end = function, start, np.zeros(4)
        self._buffer, self._evaluate = function.buffer()
        self._buffer.set_arg(0, start.data)  # type: ignore[call-arg]  # the stub wants the size, which memory brings
        self._buffer.set_res(0, self._end.data)  # type: ignore[call-arg]  # likewise

    def __call__(self) -> Answer:
        self._evaluate()
        if self._buffer.ret():
            raise RuntimeError(f"{self._function.name()} ended before its horizon")
        end = self._end
        return Answer((end[0], end[1]), int(end[3]))
