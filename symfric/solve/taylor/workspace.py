"""The arrays that one run of the event loop works on; made once for a program and used again for every run."""

from typing import NamedTuple

import numpy as np

from symfric.lower.automaton import Automaton
from symfric.solve.taylor.jets import Series
from symfric.solve.taylor.polynomials import DEPTH, bernstein_table

# entries of `counts`
STEPS, EVENTS, KINKS, GRAZES, KEPT_STEPS, KEPT_EVENTS, SEGMENT, PHASE, STALL, MARK_EVENTS, FLAGGED = range(11)
# entries of `clock`
T_LOW, H_LAST, REST, MARK_T, T_END, TOLERANCE = range(6)
# values of counts[PHASE]
SETTLE, EXPAND, GO = range(3)
# entries of `limits`
MAX_STEPS, MAX_EVENTS, CHUNK, KEEP_PATH, KEEP_EVENTS, N_Q = range(6)
# kinds of wanted rows
RANGE, INTEGRAL = range(2)


class Workspace(NamedTuple):
    """Arrays of one run; n_r = n_x + n_g + n_e rows of order + 1 coefficients."""

    code: np.ndarray  # addresses of prelude, series, probe, gauge
    y: np.ndarray  # state and time, (n_x + 1,)
    p: np.ndarray  # parameters, then start, value and slope of every input
    m: np.ndarray  # stick flags, directions, switch signs
    aux: np.ndarray  # what the prelude computes
    c: np.ndarray  # Taylor coefficients, (n_r, order + 1)
    probe: np.ndarray  # the first three of them, (n_r, 3)
    gauge: np.ndarray  # slip, its scale, and the pull of static friction, (3, n_c)
    scale: np.ndarray  # largest variation (states, wanted rows) or value (guards) so far, (n_r,)
    start: np.ndarray  # first value of every row, (n_r,)
    sticks: np.ndarray  # whether a contact can stick, (n_c,)
    anchor: np.ndarray  # index of the one velocity in a contact's slip, or -1, (n_c,)
    factor: np.ndarray  # and its factor, (n_c,)
    old: np.ndarray  # modes before an event, (n_c,)
    zero: np.ndarray  # contacts whose slip is zero now, (n_c,)
    turns: np.ndarray  # how often a contact or switch changed its mode while settling, (n_c + n_s,)
    hit: np.ndarray  # guards that have just reached zero, (n_g,)
    fresh: np.ndarray  # guards that start their mode at zero, (n_g,)
    kind: np.ndarray  # RANGE or INTEGRAL of every wanted row, (n_e,)
    total: np.ndarray  # smallest, largest, integral and its rounding rest of every wanted row, (n_e, 4)
    power: np.ndarray  # powers of the step, (order + 1,)
    poly: np.ndarray  # a scaled polynomial
    slope: np.ndarray  # its derivative
    found: np.ndarray  # roots
    stack: np.ndarray  # of the subdivision
    table: np.ndarray  # of Bernstein coefficients
    segment_t: np.ndarray  # times at which inputs change their slope, increasing, the last one infinite
    segment_p: np.ndarray  # start, value and slope of every input from there on
    counts: np.ndarray
    clock: np.ndarray
    limits: np.ndarray
    event_t: np.ndarray
    event_i: np.ndarray  # contact, mode before, mode after
    path_t: np.ndarray  # start and length of every step kept
    path_c: np.ndarray  # its state coefficients, (n, n_x, order + 1)
    path_m: np.ndarray  # its modes, (n, n_c)


def make_workspace(automaton: Automaton, series: Series, addresses: dict[str, int], kinds: list[int], segments) -> Workspace:
    """Allocate the arrays of a program."""
    n_x, n_c, n_g = len(automaton.states), len(automaton.contacts), automaton.n_guards
    n_e, order = len(kinds), series.order
    n_r = n_x + n_g + n_e
    code = [addresses[name] for name in ("prelude", "series", "probe", "gauge")]
    room = lambda *shape: np.zeros(shape)  # noqa: E731
    flags = lambda n: np.zeros(n, dtype=np.int64)  # noqa: E731
    return Workspace(
        code=np.array(code, dtype=np.int64),
        y=room(n_x + 1),
        p=room(series.prelude.nnz_in(0)),
        m=room(automaton.n_mode),
        aux=room(series.prelude.nnz_out(0)),
        c=room(n_r, order + 1),
        probe=room(n_r, min(order, 2) + 1),
        gauge=room(3, n_c),
        scale=room(n_r),
        start=room(n_r),
        sticks=np.array(automaton.sticks, dtype=np.int64),
        anchor=np.array([a for a, _ in automaton.anchors], dtype=np.int64),
        factor=np.array([f for _, f in automaton.anchors], dtype=float),
        old=flags(n_c),
        zero=flags(n_c),
        turns=flags(n_c + automaton.n_switches),
        hit=flags(n_g),
        fresh=flags(n_g),
        kind=np.array(kinds, dtype=np.int64),
        total=room(n_e, 4),
        power=room(order + 2),
        poly=room(order + 2),
        slope=room(order + 2),
        found=room(order + 2),
        stack=room(DEPTH + 4, order + 4),
        table=bernstein_table(order),
        segment_t=segments[0],
        segment_p=segments[1],
        counts=np.zeros(11, dtype=np.int64),
        clock=room(6),
        limits=np.zeros(6, dtype=np.int64),
        event_t=room(64),
        event_i=np.zeros((64, 3), dtype=np.int64),
        path_t=room(64, 2),
        path_c=room(64, n_x, order + 1),
        path_m=np.zeros((64, n_c), dtype=np.int64),
    )
