"""SciPy: DOP853 restarted at terminal events for the law with its jump, LSODA for the regularised one."""

from collections.abc import Callable
from dataclasses import replace
from math import inf, pi, sin

from symfric.bench.problems import Oscillator, Problem
from symfric.bench.result import Answer

WORKAROUNDS = (
    "the sign of slip is held constant between events; the sign function in the right-hand side would never end",
    "events fall only: after a release the guard starts at zero and rises",
    "the stick phase is solved in closed form and costs no step",
    "right-hand side in plain floats, without NumPy",
    "of the 1000 speeds of a sweep every 25th is run, and the time multiplied",
    "under fast vibration max_step is an eighth of its period: a step that leaves the guard's zero and returns across "
    "it puts the event at the start of the step, and the loop never advances",
)

_EVERY = 25  # of the speeds of a sweep; all of them would take minutes


def prepare_events(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Return a function that runs ``solve_ivp(method="DOP853")`` from event to event."""
    from scipy.integrate import solve_ivp

    o = problem.by_hand
    slips = {sign: _slipping(o, sign) for sign in (-1, 1)}
    guards = {sign: _guard(o, sign) for sign in (-1, 1)}
    release, end = o.mu_s + o.held, o.horizon
    max_step = 2 * pi / o.Omega / 8 if o.drive else inf

    def slip(t, y, sign):
        part = solve_ivp(
            slips[sign],
            (t, end),
            y,
            method="DOP853",
            rtol=tolerance,
            atol=tolerance,
            events=guards[sign],
            max_step=max_step,
        )
        if part.status < 0:
            raise RuntimeError(part.message)
        if part.t[-1] == t:
            raise RuntimeError(f"the event at t = {t:.6g} is found again and again")
        return float(part.t[-1]), float(part.y[0, -1]), float(part.y[1, -1]), part.status == 0

    def run() -> Answer:
        t, y, sign, events = 0.0, [o.x0, 0.0], o.start, 0
        while True:
            t, x, u, finished = slip(t, y, sign)
            if finished:
                return Answer((x, u), events)
            events += 1
            force = o.held - x + (o.drive * sin(o.Omega * t) if o.drive else 0.0)
            if abs(force) > o.mu_s:
                y, sign = [x, o.v_b], 1 if force > 0 else -1
                continue
            if o.settles:
                return Answer((x, o.v_b), events)
            if o.drive:
                raise NotImplementedError("a forced mass sticks; the loop has no rule for that")
            t_release = t + (release - x) / o.v_b
            if t_release >= end:
                return Answer((x + o.v_b * (end - t), o.v_b), events)
            t, y, sign, events = t_release, [release, o.v_b], -1, events + 1

    return run


def prepare_sweep(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Return a function that finds the half range at every 25th speed, from event to event."""
    from scipy.integrate import solve_ivp

    o, (begin, end) = problem.by_hand, problem.window

    def turn(_, y):
        return y[1]

    def half_range(v_b: float) -> float:
        here = replace(o, v_b=v_b)
        slips, guards, release = _slipping(here, -1), [_guard(here, -1), turn], o.mu_s + here.held

        def go(t, y, until, released):
            """Go on to a time, from `released` if the mass sticks until then."""
            seen: list[float] = []
            while True:
                if released:
                    if released >= until:
                        return [y[0] + v_b * (until - t), v_b], released, seen
                    t, y = released, [release, v_b]
                part = solve_ivp(slips, (t, until), y, method="DOP853", rtol=tolerance, atol=tolerance, events=guards)
                seen += [x for x, _ in part.y_events[1]]
                t, y = float(part.t[-1]), part.y[:, -1].tolist()
                if part.status == 0:
                    return y, 0.0, seen
                released = t + (release - y[0]) / v_b

        first, released, _ = go(0.0, [o.x0, 0.0], begin, 0.0)
        last, _, seen = go(begin, first, end, released)
        seen += [first[0], last[0]]
        return (max(seen) - min(seen)) / 2

    def run() -> Answer:
        return Answer(tuple(half_range(v) for v in problem.speeds[::_EVERY]), 0, _EVERY)

    return run


def prepare_stiff(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Return a function that runs ``solve_ivp(method="LSODA")`` through the kinks of the regularised law."""
    from scipy.integrate import solve_ivp

    o = problem.by_hand
    slope = o.mu_s / o.v_s

    def rate(t, y):
        x, u = y
        w = u - o.v_b
        speed = abs(w) - o.v_s
        mu = slope * w if speed < 0 else (1 if w > 0 else -1) * (o.mu_s + speed * (o.c1 + o.c3 * speed * speed))
        return [u, -2 * o.beta * u - x - mu]

    def run() -> Answer:
        whole = solve_ivp(rate, (0, o.horizon), [o.x0, 0.0], method="LSODA", rtol=tolerance, atol=tolerance)
        if whole.status:
            raise RuntimeError(whole.message)
        return Answer((whole.y[0, -1], whole.y[1, -1]), 0)

    return run


def _slipping(o: Oscillator, sign: int):
    """Right-hand side with the sign of slip held."""
    c1, c3, v_b, damping, drive, Omega, rest = o.c1, o.c3, o.v_b, 2 * o.beta, o.drive, o.Omega, sign * o.mu_s

    def rate(t, y):
        x, u = y
        w = u - v_b
        force = -x - damping * u - rest - w * (c1 + c3 * w * w)
        return [u, force + drive * sin(Omega * t) if drive else force]

    return rate


def _guard(o: Oscillator, sign: int):
    def guard(_, y):
        return sign * (y[1] - o.v_b)

    vars(guard).update(terminal=True, direction=-1)  # as SciPy reads them
    return guard
