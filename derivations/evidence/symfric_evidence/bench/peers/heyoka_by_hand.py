"""A hand-written stick-slip loop over heyoka's adaptive Taylor integrator, as fast as its interface allows."""

from collections.abc import Callable
from math import sin
from typing import Any

from symfric_evidence.bench.problems import OscillatorProblem, Problem
from symfric_evidence.bench.result import BenchAnswer

WORKAROUNDS = (
    "the sign of slip is a runtime parameter, so that each problem is compiled once",
    "crossings are handled by a callback that lets the integrator continue, without leaving its loop",
    "the stick phase is solved in closed form and costs no step",
    "event cooldown set by hand to 1e-6: the one deduced by heyoka grows without bound after a release, where the "
    "slip velocity has a double root, and hides the next event",
    "the cube of the slip velocity is multiplied out: the series of a power divides by its base and is NaN at zero",
    "fast_math on, which saves a fifth of the time",
)
_COOLDOWN = 1e-6
_COOLDOWN_STIFF = 1e-9


def prepare(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Compile the integrator and return a function that resets its state and runs it."""
    oscillator = problem.by_hand
    return _continuous(oscillator, tolerance) if oscillator.v_s else _set_valued(oscillator, tolerance)


def _integrator(
    o: OscillatorProblem,
    friction: Callable[[Any], Any],
    guard: Callable[[Any], Any],
    callback: Callable[..., bool],
    pars: list[float],
    tolerance: float,
    cooldown: float,
) -> Any:
    import heyoka as hy

    x, u = hy.make_vars("x", "u")
    force = -x - friction(u - o.v_b)
    if o.beta:
        force = force - 2 * o.beta * u
    if o.drive:
        force = force + o.drive * hy.sin(o.Omega * hy.time)
    event = hy.t_event(guard(u - o.v_b), callback=callback, cooldown=cooldown)
    return hy.taylor_adaptive(
        [(x, u), (u, force)], [o.x0, 0.0], pars=pars, tol=tolerance, t_events=[event], fast_math=True
    )


def _set_valued(o: OscillatorProblem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Loop for the law with its jump; the callback returns False where the mass sticks."""
    import heyoka as hy

    if o.drive and o.settles:
        raise NotImplementedError("a forced mass never settles")
    events = [0]

    def arrive(_: object, __: object) -> bool:
        x = state[0]
        force = o.held - x + (o.drive * sin(o.Omega * ta.time) if o.drive else 0.0)
        state[1] = o.v_b
        if abs(force) <= o.mu_s:
            events[0] += 1
            return False
        sign = 1.0 if force > 0 else -1.0
        if pars[0] != sign:
            pars[0] = sign
            events[0] += 1
        return True

    def friction(w: Any) -> Any:
        falling = o.c1 * w + o.c3 * (w * w) * w if o.c1 or o.c3 else 0.0
        return hy.par[0] * o.mu_s + falling

    ta = _integrator(o, friction, lambda w: w, arrive, [float(o.start)], tolerance, _COOLDOWN)
    state, pars = ta.state, ta.pars
    end, release, finished = o.horizon, o.mu_s + o.held, hy.taylor_outcome.time_limit

    def run() -> BenchAnswer:
        events[0] = 0
        ta.reset_cooldowns()
        ta.time, state[0], state[1], pars[0] = 0.0, o.x0, 0.0, o.start
        while True:
            outcome = ta.propagate_until(end)[0]
            if outcome == finished or o.settles:
                return BenchAnswer((state[0], state[1]), events[0])
            if o.drive:
                raise NotImplementedError("a forced mass sticks; the loop has no rule for that")
            x, t = state[0], ta.time
            t_release = t + (release - x) / o.v_b
            if t_release >= end:
                return BenchAnswer((x + o.v_b * (end - t), o.v_b), events[0])
            events[0] += 1
            ta.time, state[0], state[1], pars[0] = t_release, release, o.v_b, -1.0

    return run


def prepare_sweep(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Compile once with the belt speed as a parameter; return a function that finds the half range at each speed."""
    import heyoka as hy

    o, (begin, end) = problem.by_hand, problem.window
    range_ = [0.0, 0.0]
    watching = [False]

    def seen(x: float) -> None:
        range_[:] = min(x, range_[0]), max(x, range_[1])

    def turn(ta: Any, time: float, _: object) -> None:
        if watching[0]:
            ta.update_d_output(time)
            seen(ta.d_output[0])

    def arrive(ta: Any, _: object) -> bool:
        v_b = pars[1]
        force = -2 * o.beta * v_b - state[0]
        state[1] = v_b
        if abs(force) <= o.mu_s:
            return False
        pars[0] = 1.0 if force > 0 else -1.0
        return True

    x, u = hy.make_vars("x", "u")
    w = u - hy.par[1]
    force = -x - 2 * o.beta * u - hy.par[0] * o.mu_s - o.c1 * w - o.c3 * (w * w) * w
    ta = hy.taylor_adaptive(
        [(x, u), (u, force)],
        [0.0, 0.0],
        pars=[-1.0, 0.0],
        tol=tolerance,
        t_events=[hy.t_event(w, callback=arrive, cooldown=_COOLDOWN)],
        nt_events=[hy.nt_event(u, turn)],
        fast_math=True,
    )
    state, pars, limit = ta.state, ta.pars, hy.taylor_outcome.time_limit

    def go(until: float, released: float) -> float:
        """Integrate to a time, from `released` if the mass sticks until then; return its next release time, or 0."""
        v_b = pars[1]
        while True:
            if released:
                if released >= until:
                    state[0] += v_b * (until - ta.time)
                    ta.time = until
                    return released
                ta.time, state[0], state[1], pars[0] = released, o.mu_s - 2 * o.beta * v_b, v_b, -1.0
            if ta.propagate_until(until)[0] == limit:
                return 0.0
            released = ta.time + (o.mu_s - 2 * o.beta * v_b - state[0]) / v_b

    def run() -> BenchAnswer:
        half_ranges = []
        for v_b in problem.speeds:
            ta.reset_cooldowns()
            ta.time, state[0], state[1], pars[0], pars[1] = 0.0, o.x0, 0.0, -1.0, v_b
            watching[0] = False
            released = go(begin, 0.0)
            range_[:], watching[0] = (state[0], state[0]), True
            go(end, released)
            seen(state[0])
            half_ranges.append((range_[1] - range_[0]) / 2)
        return BenchAnswer(tuple(half_ranges), 0)

    return run


def _continuous(o: OscillatorProblem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Loop for the regularised law: its kinks at w = +-v_s are events, par 0 the sign of slip or 0 on the line."""
    import heyoka as hy

    def turn(_: object, direction: int) -> bool:
        sign = 1.0 if state[1] > o.v_b else -1.0
        pars[0], pars[1] = (sign, 0.0) if direction > 0 else (0.0, 1.0)
        return True

    def friction(w: Any) -> Any:
        y = w - hy.par[0] * o.v_s
        slipping = hy.par[0] * o.mu_s + (1.0 - hy.par[1]) * (o.c1 * y + o.c3 * (y * y) * y)
        return slipping + hy.par[1] * (o.mu_s / o.v_s) * w

    pars_start = [0.0, 1.0] if abs(o.v_b) < o.v_s else [float(o.start), 0.0]
    ta = _integrator(o, friction, lambda w: w * w - o.v_s**2, turn, pars_start, tolerance, _COOLDOWN_STIFF)
    state, pars = ta.state, ta.pars

    def run() -> BenchAnswer:
        ta.reset_cooldowns()
        ta.time, state[0], state[1] = 0.0, o.x0, 0.0
        pars[0], pars[1] = pars_start
        ta.propagate_until(o.horizon)
        return BenchAnswer((state[0], state[1]), 0)

    return run
