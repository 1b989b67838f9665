"""heyoka on a written-out scene: one terminal event for each guard, the logic in its callbacks."""

from collections.abc import Callable

import sympy as sp

from symfric.bench.peers.written_out import Loop, form_of
from symfric.bench.problems import Problem
from symfric.bench.result import Answer
from symfric.model.symbols import TIME

_COOLDOWN = 1e-6


def prepare(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Compile the integrator and return a function that resets its state and runs it."""
    import heyoka as hy

    form = form_of(problem.scene)
    loop = Loop(form)
    variables = hy.make_vars(*(s.name for s in form.states))
    if len(form.states) == 1:
        variables = [variables]
    constants = (*form.signs, *form.moving, *(form.line if problem.scene.inputs else ()))
    parameters = [hy.par[k] for k in range(len(constants))]
    rates, guards = _translated(hy, (TIME, *form.states, *constants), (form.rates, form.guards))(
        hy.time, *variables, *parameters
    )
    events, line, modes = [0], [0.0, 0.0], len(form.signs) + len(form.moving)

    def falls(k: int):
        def callback(ta, _):
            y, mode, changed = loop.after(ta.time, ta.state.tolist(), ta.pars[:modes].tolist(), line, k)
            ta.state[:], ta.pars[:modes] = y, mode
            events[0] += changed
            return True

        return hy.t_event(guards[k], callback=callback, cooldown=_COOLDOWN, direction=hy.event_direction.negative)

    ta = hy.taylor_adaptive(
        list(zip(variables, [rate + 0.0 * variables[0] for rate in rates], strict=True)),
        list(form.start),
        pars=[0.0] * len(constants),
        tol=tolerance,
        t_events=[falls(k) for k in range(len(form.guards))],
        fast_math=True,
    )

    def run() -> Answer:
        events[0] = 0
        ta.reset_cooldowns()
        ta.time, ta.state[:], ta.pars[:modes] = 0.0, form.start, loop.first(list(form.start))
        for end, *line[:] in form.segments:
            ta.pars[modes:] = line[: len(constants) - modes]
            ta.propagate_until(end)
        return Answer(tuple(ta.state.tolist()), events[0])

    return run


def _translated(hy, arguments, expressions):
    """Return a function that builds heyoka's expressions; powers become products."""

    def product(base, n):
        return base if n == 1 else base * product(base, n - 1)

    multiplied = sp.Function("product")
    plain = [
        [e.replace(lambda p: p.is_Pow and p.exp.is_Integer and p.exp > 1, lambda p: multiplied(*p.args)) for e in row]
        for row in (map(sp.sympify, row) for row in expressions)
    ]
    return sp.lambdify(arguments, plain, [{"product": product, "sin": hy.sin, "cos": hy.cos, "exp": hy.exp}])
