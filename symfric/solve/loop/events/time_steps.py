"""Steps in time: switches of conditions on time alone, at which forces, slips, loads and laws may jump.

Their instants are known to rounding only, and several may coincide. So at every event those that occur `soon` occur
now; the gauge takes them likewise, see `symfric.lower.contact_dynamics.ContactDynamics.unswitched`.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.mode_layout import JUST_AFTER
from symfric.solve.loop.modes.layout import sign, switch
from symfric.solve.loop.stepping.calls import prelude, probe
from symfric.solve.loop.workspace import LoopArrays


@compiled(inline=True)
def soon(w: LoopArrays) -> float:
    """Return the time after which a step in time has surely occurred."""
    return JUST_AFTER * (abs(w.y[w.y.size - 1]) + w.clock.t_end)


@compiled(inline=True)
def just_after(w: LoopArrays, row: int) -> float:
    """Return the guard of a step in time just after now, from the coefficients of a trial mode."""
    ahead = soon(w)
    return w.probe[row, 0] + ahead * (w.probe[row, 1] + ahead * w.probe[row, 2])


@compiled(inline=True)
def missed(w: LoopArrays, row: int) -> float:
    """Return by how much a guard differs between the instant of a step in time and now, from `step_over`."""
    return soon(w) * abs(w.probe[row, 1]) if w.limits.steps and w.counts.jumped else 0.0


@compiled(inline=True)
def occurs(w: LoopArrays, row: int) -> bool:
    """Whether the sign of a step in time is wrong just after now."""
    return just_after(w, row) < 0.0


@compiled
def mark_steps(w: LoopArrays, n_x: int, n_c: int, starting: bool) -> None:
    """Mark the steps in time that occur now as hit, unless this only completes the first mode; slips may jump."""
    prelude(w)
    probe(w)
    for j in range(w.contacts.step.size):
        g = switch(j, n_c)
        if w.contacts.step[j] and (w.guards.hit[g] or occurs(w, n_x + g)):
            w.guards.hit[g], w.counts.jumped = not starting or w.guards.hit[g], 1


@compiled
def step_over(w: LoopArrays, n_x: int, n_c: int) -> None:
    """Give every step in time its sign just after now; one may depend on those before it. Probe the rows with them."""
    for _ in range(w.contacts.step.size + 1):
        prelude(w)
        probe(w)
        changed = False
        for j in range(w.contacts.step.size):
            if w.contacts.step[j] and occurs(w, n_x + switch(j, n_c)):
                w.m[sign(j, n_c)] = -w.m[sign(j, n_c)]
                w.counts.kinks += 1
                changed = True
        if not changed:
            break
