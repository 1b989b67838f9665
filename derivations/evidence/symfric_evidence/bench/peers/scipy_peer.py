"""SciPy on a written-out scene: DOP853 restarted at terminal events, LSODA where nothing sticks."""

from collections.abc import Callable

import numpy as np
import sympy as sp

from symfric_evidence.bench.peers.written_out import Advance, PeerLoop, Step, WrittenForm, branch, form_of
from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer

WORKAROUNDS = (
    "the sign of slip is held constant between events; the sign function in the right-hand side would never end",
    "events fall only: after a release the guard starts at zero and rises",
    "a stick phase with constant velocities is solved in closed form and costs no step",
    "right-hand side in plain floats, without NumPy",
    "of the 1000 speeds of a sweep every 25th is run, and the time multiplied",
    "a sampled input is integrated from sample to sample, so that no step meets a kink of it; max_step is an eighth of "
    "a sample, and of the period of an excitation: a step that leaves the guard's zero and returns across it puts the "
    "event at the start of the step, and the loop never advances",
)

_EVERY = 25  # every 25th speed of a sweep is run; all would take minutes


def prepare_events(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that runs ``solve_ivp(method="DOP853")`` from event to event, a sweep over its speeds."""
    if problem.speeds:
        return _prepare_sweep(problem, tolerance)
    form = form_of(problem.scene).with_rest_apart()
    return PeerLoop(form, _advance(form, problem, tolerance, "DOP853"))


def prepare_stiff(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that runs ``solve_ivp(method="LSODA")``; through the branches of a law without events."""
    form = form_of(problem.scene, through=any(c.law.smooth for c in problem.scene.contacts))
    return PeerLoop(form, _advance(form, problem, tolerance, "LSODA"))


def _prepare_sweep(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that finds the half range at every 25th speed, from event to event."""
    (x,), (u,), speed = problem.scene.system.q, problem.scene.system.u, problem.scene.parameter("v_b")
    form, (begin, end) = form_of(problem.scene, (speed,)).with_rest_apart(), problem.window
    turns: list[float] = []
    turning = sp.lambdify((x, u), u, "math")
    loop = PeerLoop(form, _advance(form, problem, tolerance, "DOP853", lambda _, y: turning(*y), turns))

    def half_range(v_b: float) -> float:
        y, given = list(form.start), [v_b]
        y, mode, _ = loop.run(0.0, y, loop.first(y, given), [(begin,)], given)
        turns[:] = [y[0]]
        y, _, _ = loop.run(begin, y, mode, [(end,)], given)
        return (max(*turns, y[0]) - min(*turns, y[0])) / 2

    def run() -> BenchAnswer:
        return BenchAnswer(tuple(half_range(v) for v in problem.speeds[::_EVERY]), 0, _EVERY)

    return run


def _advance(
    form: WrittenForm,
    problem: Problem,
    tolerance: float,
    method: str,
    turn: Callable[[float, np.ndarray], float] | None = None,
    turns: list[float] | None = None,
) -> Advance:
    """Return a function that integrates to the next event; zeros of `turn` are recorded in `turns`."""
    from scipy.integrate import solve_ivp

    rates = sp.lambdify(form.arguments, [_plain(e) for e in form.rates], "math", cse=True)
    constants: list[float] = []
    events = [_event(form, guard, constants) for guard in form.guards]
    options = {"method": method, "rtol": tolerance, "atol": tolerance, "events": [*events, *([turn] if turn else [])]}
    periods = (form.fastest, *(signal.dt for signal in problem.scene.inputs.values()))
    options["max_step"] = min(periods) / 8
    if not options["events"]:
        del options["events"]

    def rate(t: float, y: np.ndarray) -> list[float]:
        slopes: list[float] = rates(t, *y.tolist(), *constants)
        return slopes

    def advance(t: float, y: list[float], mode: list[float], line: list[float], end: float) -> Step:
        constants[:] = (*mode, *line)
        part = solve_ivp(rate, (t, end), np.array(y), **options)
        if part.status < 0:
            raise RuntimeError(part.message)
        if turns is not None:
            turns.extend(state[0] for state in part.y_events[-1])
        if part.status == 0:
            return end, part.y[:, -1].tolist(), None
        if part.t[-1] == t:
            raise RuntimeError(f"the event at t = {t:.6g} is found again and again")
        fired = next(k for k, zeros in enumerate(part.t_events) if zeros.size)
        return float(part.t[-1]), part.y[:, -1].tolist(), fired

    return advance


def _plain(expr: sp.Expr) -> sp.Expr:
    return expr.replace(branch, lambda side, above, below: sp.Piecewise((above, side > 0), (below, True)))


def _event(form: WrittenForm, guard: sp.Expr, constants: list[float]) -> Callable[[float, np.ndarray], float]:
    compiled = sp.lambdify(form.arguments, guard, "math")

    def event(t: float, y: np.ndarray) -> float:
        return float(compiled(t, *y.tolist(), *constants))

    vars(event).update(terminal=True, direction=-1)  # as SciPy reads them
    return event
