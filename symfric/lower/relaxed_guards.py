"""Relax guards so that trajectories continue past grazing.

At a grazing, such as the onset of sticking, the sequence of events of a periodic orbit changes and the map over a
period is not differentiable. The motion that ignores the event depends smoothly on parameters; the grazing is where the
least value of its guard is zero.
"""

from dataclasses import replace

import casadi as ca
import sympy as sp

from symfric.lower.automaton import Automaton
from symfric.lower.constraint_forces import HOLDS, SHARES
from symfric.lower.mode_layout import backward, forward
from symfric.lower.unilateral import GUARDS

FAR = 1e29  # rows that are not defined in a mode have larger values


LIFTS = 2  # shifts of each contact: of its guard while it slips, and while it sticks


def lift_of(i: int, slips: bool) -> int:
    """Return the index of the shift of contact i while it slips, or while it sticks."""
    return LIFTS * i + (not slips)


def n_lifts(automaton: Automaton) -> int:
    """Return the number of shifts: two of each contact along a line, one of each that opens."""
    return LIFTS * len(automaton.contacts) + len(automaton.layout.openings)


def lifted(automaton: Automaton) -> Automaton:
    """Return the automaton with guard shifts as parameters and its guards as first observables.

    The parameters, behind the others, are added to the guards of contact i while it slips and while it sticks, then to
    the gaps of contacts that open. The
    rows are the guards without them, in the order of `symfric.lower.mode_layout.gaps`: the slip in its direction, and
    what is left to both bounds of sticking, then the gaps of contacts that open; where they do not apply they are
    constant and large.
    """
    field, n_c = automaton.field, len(automaton.contacts)
    y, t, m = ca.SX.sym("y", field.nnz_in(0)), ca.SX.sym("t"), ca.SX.sym("m", field.nnz_in(3))
    p, lift = ca.SX.sym("p", field.nnz_in(2)), ca.SX.sym("lift", n_lifts(automaton))
    rate, guards, rows = field(y, t, p, m)
    gaps, raised = [], ca.SX(guards)
    for i in range(n_c):
        sticks, left, right = m[i] > 0.5, guards[backward(i)], guards[forward(i)]
        slipping, sticking = lift[lift_of(i, slips=True)], lift[lift_of(i, slips=False)]
        raised[backward(i)] = left + ca.if_else(sticks, sticking, slipping)
        raised[forward(i)] = right + ca.if_else(sticks, sticking, 0)
        carries = ca.logic_or(m[i] == HOLDS, m[i] == SHARES)
        gaps += [
            ca.if_else(sticks, 10 * FAR, left),
            ca.if_else(carries, left, 10 * FAR),
            ca.if_else(carries, right, 10 * FAR),
        ]
    for j, place in enumerate(automaton.layout.openings):
        g, is_open = automaton.layout.first_opening + GUARDS * j, m[place] > 0.5
        raised[g] = guards[g] + ca.if_else(is_open, lift[LIFTS * n_c + j], 0)
        gaps.append(ca.if_else(is_open, guards[g], 10 * FAR))
    wide = ca.vertcat(p, lift)
    out = [rate, ca.densify(raised), ca.densify(ca.vertcat(*gaps, rows))]
    gauge = automaton.gauge
    names = [sp.Symbol(f"lift of {c} while it {how}") for c in automaton.contacts for how in ("slips", "sticks")]
    names += [sp.Symbol(f"lift of gap {j}") for j in range(len(automaton.layout.openings))]
    return replace(
        automaton,
        field=ca.Function("field", [y, t, wide, m], out, field.name_in(), field.name_out()),
        gauge=ca.Function("gauge", [y, t, wide], list(gauge(y, t, p)), gauge.name_in(), gauge.name_out()),
        parameters=(*automaton.parameters, *names),
        transition=_wider(automaton.transition, wide, p),
        impact=_wider(automaton.impact, wide, p),
    )


def _wider(change: ca.Function | None, wide: ca.SX, p: ca.SX) -> ca.Function | None:
    """Return a transition or an impact with more parameters, which it does not use."""
    if change is None:
        return None
    arguments = [ca.SX.sym(name, change.size1_in(k)) for k, name in enumerate(change.name_in())]
    out = list(change(*arguments[:2], p, *arguments[3:]))
    arguments[2] = wide
    return ca.Function(change.name(), arguments, out, change.name_in(), change.name_out())
