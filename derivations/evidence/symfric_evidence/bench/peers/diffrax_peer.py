"""diffrax on a written-out scene, one compiled solve from event to event."""

import logging
import re
from collections.abc import Callable
from typing import Any

import sympy as sp

from symfric_evidence.bench.peers.written_out import PeerLoop, Step, form_of
from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer

WORKAROUNDS = (
    "compiled once: signs of slip and sticking are arguments",
    "events may only fall, and are refined by Newton's method to a hundredth of the tolerance",
)
_STEPS = 100_000


def prepare(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Compile the solve and return a function that runs it from event to event."""
    import diffrax
    import jax
    import jax.numpy as jnp
    import optimistix

    jax.config.update("jax_enable_x64", True)
    logging.getLogger("jax").setLevel(logging.CRITICAL)  # a solve that fails logs its traceback before it raises
    form = form_of(problem.scene)
    rates = sp.lambdify(form.arguments, list(form.rates), "jax", cse=True)
    guards = [sp.lambdify(form.arguments, guard, "jax") for guard in form.guards]
    event = None
    if guards:
        finder = optimistix.Newton(rtol=1e-2 * tolerance, atol=1e-2 * tolerance)
        conditions = [lambda t, y, args, guard=guard, **_: guard(t, *y, *args) for guard in guards]
        event = diffrax.Event(conditions, finder, direction=False)
    term = diffrax.ODETerm(lambda t, y, args: jnp.stack([jnp.asarray(r, float) for r in rates(t, *y, *args)]))
    controller = diffrax.PIDController(rtol=tolerance, atol=tolerance)

    @jax.jit
    def solved(t: Any, end: Any, y: Any, args: Any) -> Any:
        part = diffrax.diffeqsolve(
            term,
            diffrax.Tsit5(),
            t,
            end,
            None,
            y,
            args,
            stepsize_controller=controller,
            event=event,
            max_steps=_STEPS,
        )
        fell = jnp.stack(part.event_mask) if guards else jnp.zeros(1, bool)
        return part.ts[-1], part.ys[-1], fell

    def advance(t: float, y: list[float], mode: list[float], line: list[float], end: float) -> Step:
        try:
            reached, state, fell = solved(t, end, jnp.array(y), jnp.array([*mode, *line]))
        except (RuntimeError, ValueError) as error:
            reasons = re.findall(r"\w+Error: (.+?)(?:\. |$)", str(error), re.MULTILINE)  # inside a traceback
            raise RuntimeError(f"{reasons[-1] if reasons else error}, after t = {t:.6g}") from None
        fired = [k for k, yes in enumerate(fell.tolist()) if yes]
        if not fired:
            return end, state.tolist(), None
        if float(reached) == t:
            raise RuntimeError(f"the event at t = {t:.6g} is found again and again")
        return float(reached), state.tolist(), fired[0]

    return PeerLoop(form, advance)
