"""SciPy on a written-out scene: DOP853 restarted at terminal events, LSODA where nothing sticks."""

from collections.abc import Callable
from math import inf

import sympy as sp

from symfric.bench.peers.written_out import Form, Loop, form_of
from symfric.bench.problems import Problem
from symfric.bench.result import Answer

WORKAROUNDS = (
    "a sampled input is integrated from sample to sample, so that no step meets a kink of it, in steps of an eighth of "
    "them: a step that leaves the guard's zero and returns across it puts the event at the start of the step",
)


def prepare_events(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Return a function that runs ``solve_ivp(method="DOP853")`` from event to event."""
    return _prepared(problem, tolerance, "DOP853")


def prepare_stiff(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Return a function that runs ``solve_ivp(method="LSODA")`` from event to event."""
    return _prepared(problem, tolerance, "LSODA")


def _prepared(problem: Problem, tolerance: float, method: str) -> Callable[[], Answer]:
    from scipy.integrate import solve_ivp

    form = form_of(problem.scene)
    rates = sp.lambdify(form.arguments, list(form.rates), "math", cse=True)
    events = [_event(form, guard) for guard in form.guards]
    max_step = min((signal.dt / 8 for signal in problem.scene.inputs.values()), default=inf)

    def advance(t, y, mode, line, end):
        constants = (*mode, *line)
        part = solve_ivp(
            lambda t, y, *c: rates(t, *y, *c),
            (t, end),
            y,
            method=method,
            rtol=tolerance,
            atol=tolerance,
            events=events or None,
            max_step=max_step,
            args=constants,
        )
        if part.status < 0:
            raise RuntimeError(part.message)
        if part.status == 0:
            return end, part.y[:, -1].tolist(), None
        if part.t[-1] == t:
            raise RuntimeError(f"the event at t = {t:.6g} is found again and again")
        fired = next(k for k, found in enumerate(part.t_events) if found.size)
        return float(part.t[-1]), part.y[:, -1].tolist(), fired

    return Loop(form, advance)


def _event(form: Form, guard: sp.Expr):
    compiled = sp.lambdify(form.arguments, guard, "math")

    def event(t, y, *constants):
        return compiled(t, *y, *constants)

    vars(event).update(terminal=True, direction=-1)  # as SciPy reads them
    return event
