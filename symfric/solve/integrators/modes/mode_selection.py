"""Mode selection by trial: the consistent combination of modes nearest to the current one.

Slow, short, and independent of the compiled rule of the route `taylor`, which it checks.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi as ca
import numpy as np

from symfric.lower.automaton import Automaton, arguments_of
from symfric.lower.cell_edges import ON_EDGE
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS
from symfric.lower.mode_layout import backward, contact_of, forward
from symfric.solve.integrators.modes.forces_at_rest import Rest

_MOST_TRIALS = 20_000
_FORCES, _SPREAD, _EDGES = 5, 7, 9  # outputs of the gauge function
ROUNDING = 64 * 2.0**-52  # rounding error of a sum of a few terms, relative to their magnitudes
_FAR = 100  # largest correction of the state, in units of the zero of a slip
_HIT = 1e-6  # relative distance from a bound within which a force has reached it
_UNTOLD = 100  # difference of slips, in units of the zero of a slip, below which they are not distinguished
_ALLOWED = 1e3  # error, in tolerances, of a velocity that follows from slips that nearly agree
_TIE = 1e-12  # derivative relative to its scale below which its sign is undetermined


class NearlyParallel(Exception):
    """Raised if slips are so nearly equal that the integrator's error would decide which one is zero."""


@dataclass(frozen=True)
class Rule:
    """Functions on which mode selection depends.

    Attributes
    ----------
    automaton : Automaton
    look : casadi.Function
        ``(y, t, p, m) -> (guards, first, second)``: the guards and their derivatives along the motion.
    drift : casadi.Function
        ``(y, t, p, m) -> dw/dt``: the slip accelerations, shape (n_c,).
    slopes : casadi.Function
        ``(y, t, p) -> dw/du``, shape (n_c, n_u).
    velocities : slice
        Where the velocities stand in the state.
    zero : float
        Relative size below which a slip or a guard counts as zero; what the integrator leaves of an event.
    horizon : float
        Of the run.
    farthest : ndarray, shape (n_x,)
        Largest magnitudes of the states so far.
    untold : float
        Relative difference of slips below which the velocities that follow from their zeros are lost, in the errors of
        the integrator or in rounding.
    evaluated : bool
        Whether only the modes of contacts that can stick are data, and all else is computed from the state.
    """

    automaton: Automaton
    look: ca.Function
    drift: ca.Function
    slopes: ca.Function
    velocities: slice
    zero: float
    horizon: float
    farthest: np.ndarray
    untold: float
    evaluated: bool


def make_rule(automaton: Automaton, zero: float, tolerance: float, horizon: float, evaluated: bool) -> Rule:
    """Differentiate the guards along the motion."""
    field, n_q = automaton.field, automaton.n_q
    y, t, p, m = arguments_of(field)
    rate, guards, _ = field(y, t, p, m)
    first = along(guards, rate, y, t)
    look = ca.Function("look", [y, t, p, m], [guards, first, along(first, rate, y, t)])
    untold = max(_UNTOLD * zero, ROUNDING / (_ALLOWED * tolerance))
    slip = automaton.gauge(y, t, p)[0]
    drift = ca.Function("drift", [y, t, p, m], [along(slip, rate, y, t)])
    slopes = ca.Function("slopes", [y, t, p], [ca.densify(ca.jacobian(slip, y)[:, n_q : 2 * n_q])])
    return Rule(
        automaton, look, drift, slopes, slice(n_q, 2 * n_q), zero, horizon, np.zeros(y.numel()), untold, evaluated
    )


def along(expr: ca.SX, rate: ca.SX, y: ca.SX, t: ca.SX) -> ca.SX:
    """Return the time derivative of an expression along the motion."""
    return ca.densify(ca.jtimes(expr, y, rate) + ca.jtimes(expr, t, ca.SX(1)))


def starting_mode(rule: Rule, y: np.ndarray, t: float, p: np.ndarray) -> np.ndarray | None:
    """Return the mode at the start, or None if no combination is consistent."""
    automaton = rule.automaton
    n_c, layout = len(automaton.contacts), automaton.layout
    slip = numbers(automaton.gauge(y, t, p)[0])
    others = np.zeros(layout.n_mode - layout.first_variable)
    m = np.concatenate([np.zeros(n_c), np.where(slip < 0, -1.0, 1.0), np.ones(layout.switches), others])
    for j in range(automaton.layout.switches):  # a switch may depend on the ones before it
        guard = numbers(rule.look(y, t, p, m)[0])[layout.switch(j)]
        m[layout.sign(j)] = 1.0 if guard >= 0 else -1.0
    return next_mode(rule, y, t, p, m, frozenset())


def moving(rule: Rule, y: np.ndarray, t: float, p: np.ndarray, m: np.ndarray) -> np.ndarray:
    """Return a mode with the directions of all slips that are not zero, after the state has jumped."""
    slip = numbers(rule.automaton.gauge(y, t, p)[0])
    scale = numbers(rule.automaton.gauge(np.maximum(rule.farthest, np.abs(y)), t, p)[1])
    m = m.copy()
    for i in np.flatnonzero(np.abs(slip) > rule.zero * scale):
        m[i], m[rule.automaton.layout.direction(int(i))] = 0.0, np.sign(slip[i])
    return m


def next_mode(
    rule: Rule, y: np.ndarray, t: float, p: np.ndarray, m: np.ndarray, hit: frozenset[int]
) -> np.ndarray | None:
    """Return the next mode; slips counted as zero are set exactly to zero in `y`.

    Parameters
    ----------
    y : ndarray, shape (n_x,)
        Changed in place.
    hit : frozenset of int
        Guards known to be zero.

    Returns
    -------
    ndarray or None
        None if no combination is consistent.

    Raises
    ------
    NearlyParallel
        If the error of the integrator would decide.
    """
    automaton = rule.automaton
    n_c = len(automaton.contacts)
    slip, _, pull = (numbers(e) for e in automaton.gauge(y, t, p)[:3])
    scale = numbers(automaton.gauge(np.maximum(rule.farthest, np.abs(y)), t, p)[1])
    layout = automaton.layout
    still = [i for i in range(n_c) if m[i] or backward(i) in hit]
    slow = [
        i for i in range(n_c) if abs(slip[i]) <= rule.zero * scale[i] and (automaton.sticks[i] or not rule.evaluated)
    ]
    for i in (i for i in slow if i not in still):
        if _nearly(rule, y, t, p, sorted([*still, i])):
            still = sorted([*still, i])
    _project(rule, y, t, p, still)
    slip = numbers(automaton.gauge(y, t, p)[0])  # those that follow from slips at zero are zero too
    followers = {i for i in range(n_c) if abs(slip[i]) <= ROUNDING * scale[i] and (i in slow or automaton.sticks[i])}
    still = sorted({*still, *followers})
    before = tuple(i for i in still if m[i] and not hit & {backward(i), forward(i)})
    m = m.copy()
    for j in (j for j in range(layout.switches) if layout.switch(j) in hit):
        m[layout.sign(j)] = -m[layout.sign(j)]
    reached = frozenset(
        g for g in hit if g >= layout.slips.stop or m[contact_of(g)]
    )  # of a contact's guards, only the bound of a stick stays zero
    rest = _at_rest(automaton, m, still)
    rows, columns = np.array(rule.slopes(y, t, p)), numbers(automaton.gauge(y, t, p)[_SPREAD])
    columns = columns.reshape(rows.shape, order="F")
    here = Rest(automaton, rows, columns, pull, lambda m: numbers(rule.look(y, t, p, m)[0]))
    if len(rows) > 1 and here.least_difference(still) < rule.untold:
        raise NearlyParallel

    def completed(trial: np.ndarray) -> np.ndarray | None:
        for marked in here.distributions(trial):
            mode = _with_switches(rule, y, t, p, marked, reached)
            if mode is not None and _consistent(rule, y, t, p, mode, still, reached, pull, here):
                return mode
        return None

    little = max(rule.zero, _TIE) * pull + ROUNDING * numbers(automaton.gauge(y, t, p)[_FORCES])
    likely = here.most_exceeded(rest, still, before, lambda m: numbers(rule.drift(y, t, p, m)), little)
    selected = next((mode for mode in map(completed, likely) if mode is not None), None)
    if selected is not None:
        for i in sorted((i for i in still if automaton.sticks[i]), key=lambda i: (i not in before, -pull[i])):
            if not selected[i]:
                alone = _at_rest(automaton, selected, [i])
                held = map(completed, (here.with_followers(alone, still), alone))
                selected = next((mode for mode in held if mode is not None), selected)
        return selected
    ordered = sorted(still, key=partial(_room, here.guards(here.marked(rest))))
    trials = itertools.islice(_trials(automaton, rest, ordered), _MOST_TRIALS)
    return next((mode for mode in map(completed, trials) if mode is not None), None)


def _at_rest(automaton: Automaton, m: np.ndarray, still: list[int]) -> np.ndarray:
    """Return the mode in which the contacts at zero slip stick."""
    m = m.copy()
    for i in still:
        m[i] = 1.0 if automaton.sticks[i] else 0.0
    return m


def _room(guards: np.ndarray, i: int) -> float:
    """Return the reserve of a sticking contact relative to its bound; negative beyond the bound."""
    near, far = sorted(guards[[backward(i), forward(i)]])
    return near / max(abs(near) + abs(far), np.finfo(float).tiny)


def _trials(automaton: Automaton, base: np.ndarray, still: list[int]) -> Iterator[np.ndarray]:
    """Yield trial modes: all contacts at zero slip stick, then one of them is changed, then two, ...

    Of as many, those that come first in `still` are changed first. Where friction drops from rest to slip more than one
    mode may agree with the forces; the contact that exceeds its bound the most is released, as the route `taylor` does.
    """
    layout = automaton.layout
    for changed in range(len(still) + 1):
        for group in itertools.combinations(still, changed):
            ways = [(-1.0, 1.0) if automaton.sticks[i] else (-base[layout.direction(i)],) for i in group]
            for directions in itertools.product(*ways):
                trial = base.copy()
                for i, direction in zip(group, directions, strict=True):
                    trial[i], trial[layout.direction(i)] = 0.0, direction
                yield trial


def _with_switches(
    rule: Rule, y: np.ndarray, t: float, p: np.ndarray, m: np.ndarray, hit: frozenset[int]
) -> np.ndarray | None:
    """Return the mode with the correct sign of every switch, None if there is none.

    At a kink the rates of both sides agree but for what the event missed it by, which decides the sign of a slow
    crossing in a stiff motion: a switch that seems wrong on both sides crosses.
    """
    layout = rule.automaton.layout
    if rule.evaluated:
        return m
    m = _with_edges(rule, y, t, p, m, hit)
    before, turned = m, np.zeros(m.size, dtype=int)
    for _ in range(3 * layout.switches + 1):
        guards, first, second = (numbers(e) for e in rule.look(y, t, p, m))
        if not np.all(np.isfinite(first)):  # undefined beyond a switch; the branch changes when the switch has fallen
            return before
        wrong = []
        for k, g in ((layout.sign(j), layout.switch(j)) for j in range(layout.switches)):
            if abs(m[k]) == ON_EDGE:
                continue
            zero = g in hit or abs(guards[g]) <= rule.zero * (abs(guards[g]) + abs(first[g]) * rule.horizon)
            falls = first[g] < 0 or (first[g] == 0 and second[g] < 0)
            if (falls and turned[k] < 2) if zero else guards[g] < 0:
                wrong.append(k)
        if not wrong:
            return m
        before, m = m, m.copy()
        m[wrong[0]] = -m[wrong[0]]
        turned[wrong[0]] += 1
    return None


def _with_edges(rule: Rule, y: np.ndarray, t: float, p: np.ndarray, m: np.ndarray, hit: frozenset[int]) -> np.ndarray:
    """Return the mode with the switches of profiles that stay at zero marked; see `symfric.lower.cell_edges`.

    As long as a switch is marked, a contact that is released has the friction of its side of the edge. Of a switch that
    was marked before, what the forces leave by rounding in the meantime is zero, too.
    """
    automaton = rule.automaton
    if not automaton.at_edges:
        return m
    layout = automaton.layout
    entries, edges = ([place(j) for j in automaton.at_edges] for place in (layout.sign, layout.switch))
    rested, m = np.abs(m[entries]) == ON_EDGE, m.copy()
    m[entries] = ON_EDGE
    guards, first, second = (numbers(e)[edges] / ON_EDGE for e in rule.look(y, t, p, m))
    place, rate, force = np.split(numbers(automaton.gauge(np.maximum(rule.farthest, np.abs(y)), t, p)[_EDGES]), 3)
    drift = rested * force * t
    zero = np.isin(edges, list(hit)) | (np.abs(guards) <= rule.zero * np.maximum(place, drift * t))
    still = zero & (np.abs(first) <= rule.zero * np.maximum(rate, drift))
    resting = still & (np.abs(second) <= rule.zero * force)
    sign = np.where(zero, np.where(still, second, first), guards)
    m[entries] = np.where(resting, ON_EDGE, np.where(sign < 0, -1.0, 1.0))
    return m


def _consistent(
    rule: Rule,
    y: np.ndarray,
    t: float,
    p: np.ndarray,
    m: np.ndarray,
    still: list[int],
    hit: frozenset[int],
    pull: np.ndarray,
    here: Rest,
) -> bool:
    """Whether a mode is consistent: stick forces within bounds, and starting slips in their directions."""
    guards, first, second = (numbers(e) for e in rule.look(y, t, p, m))
    drift, forces = numbers(rule.drift(y, t, p, m)), numbers(rule.automaton.gauge(y, t, p)[_FORCES])
    for i in still:
        if m[i] in (FOLLOWS, AT_BOUND):
            if abs(drift[i]) > max(rule.zero, _TIE) * pull[i] + ROUNDING * forces[i]:
                return False
            continue
        if m[i]:
            bound = 0.5 * abs(guards[backward(i)] + guards[forward(i)])
            for k in (backward(i), forward(i)):
                if (
                    k in hit and rule.evaluated
                ):  # the derivatives of stiff forces are too inexact to ask whether it falls
                    return False
                at_bound = abs(guards[k]) <= (_HIT if k in hit else rule.zero) * bound
                if first[k] * rule.horizon < -_TIE * bound if at_bound else guards[k] < 0:
                    return False
        else:
            start, then = first[backward(i)], second[backward(i)]
            little = max(rule.zero, _TIE) * pull[i]
            if rule.evaluated and hit & {backward(i), forward(i)}:
                little, then = max(little, _HIT * pull[i]), max(then, 0.0)
            if max(abs(start), abs(then) * rule.horizon) <= little and here.idle(m, i):
                return False
            if start < -little or (abs(start) <= little and then * rule.horizon < -_TIE * pull[i]):
                return False
    return True


def _project(rule: Rule, y: np.ndarray, t: float, p: np.ndarray, still: list[int]) -> None:
    """Set the slips in `still` to zero: exactly for slips of one velocity, else by the least change of velocities."""
    automaton = rule.automaton
    for i in (i for i in still if automaton.anchors[i][0] >= 0):
        index, factor = automaton.anchors[i]
        y[index] -= numbers(automaton.gauge(y, t, p)[0])[i] / factor
    coupled = [i for i in still if automaton.anchors[i][0] < 0]
    if coupled:
        rows = np.array(rule.slopes(y, t, p))[coupled]
        rows[:, [automaton.anchors[i][0] - rule.velocities.start for i in still if automaton.anchors[i][0] >= 0]] = 0
        slip = numbers(automaton.gauge(y, t, p)[0])[coupled]
        y[rule.velocities] -= np.linalg.lstsq(rows, slip, rcond=None)[0]


def _nearly(rule: Rule, y: np.ndarray, t: float, p: np.ndarray, still: list[int]) -> bool:
    """Whether the slips in `still` are all zero at a state within the integrator's error of y.

    Of slips that nearly agree each may be as good as zero, though all are zero only far away.
    """
    there = y.copy()
    _project(rule, there, t, p, still)
    speeds = np.maximum(rule.farthest, np.abs(y))[rule.velocities]
    return bool(np.all(np.abs(there - y)[rule.velocities] <= _FAR * rule.zero * np.max(speeds, initial=0.0)))


def numbers(e: Any) -> np.ndarray:
    """Return a CasADi vector as an array, shape (n,)."""
    return np.array(e, dtype=float).ravel()
