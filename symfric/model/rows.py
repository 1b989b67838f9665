"""Rows: what an event loop accumulates of an expression along a run, for outputs and their derivatives."""

from typing import NamedTuple

import sympy as sp

# kinds of observables: smallest and largest value, integral over time, values at given times; for derivatives also the
# least local minimum, and the derivative of a RANGE, TURN or CROSSINGS; first, last and number of upward zero crossings
RANGE, INTEGRAL, VALUES, TURN, FOLLOW, CROSSINGS = range(6)


class Row(NamedTuple):
    """An observable: an expression accumulated along a run, and the kind of accumulation."""

    kind: int
    expr: sp.Expr
    times: tuple[float, ...] = ()  # sampling times of kind VALUES, increasing
    magnitude: bool = False  # range of |expr|, derived from that of expr, which has no kinks at zeros
    follows: int = -1  # for kind FOLLOW, the index of the observable whose derivative this is
    start: float = 0.0  # time from which on it is accumulated
