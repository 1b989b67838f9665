"""What of a motion is wanted, as the rows that an event loop follows."""

from dataclasses import dataclass
from typing import NamedTuple

import sympy as sp

from symfric.model.outputs import At, Events, Integral, ScalarOfExpression, Trajectory
from symfric.model.scene import Scene

# kinds of rows; TURN: the least value where a row turns upward; FOLLOW: the derivative of a RANGE or TURN
RANGE, INTEGRAL, THEN, TURN, FOLLOW = range(5)


class Row(NamedTuple):
    """An expression and what of it is wanted; THEN is its value at a time."""

    kind: int
    expr: sp.Expr
    time: float = 0.0
    magnitude: bool = False  # the range of |expr|: that of expr says it, without a kink wherever it is zero


@dataclass(frozen=True)
class Wanted:
    """What of a motion is wanted.

    Attributes
    ----------
    rows : tuple of Row
        Each once.
    row : dict of str to int
        The row of every scalar output.
    path, events : bool
        Whether the trajectory, or the list of events, is kept.
    """

    rows: tuple[Row, ...]
    row: dict[str, int]
    path: bool
    events: bool


def wanted_of(scene: Scene) -> Wanted:
    """Read the outputs of a scene."""
    outputs = {n: o for n, o in scene.outputs.items() if isinstance(o, ScalarOfExpression)}
    row = {n: _row(o, scene.horizon) for n, o in outputs.items()}
    rows = tuple(dict.fromkeys(row.values()))
    path = any(isinstance(o, Trajectory) for o in scene.outputs.values())
    events = path or any(isinstance(o, Events) for o in scene.outputs.values())
    return Wanted(rows, {n: rows.index(r) for n, r in row.items()}, path, events)


def _row(output: ScalarOfExpression, horizon: float) -> Row:
    if isinstance(output, At):
        return Row(THEN, output.expr, horizon if output.time is None else min(output.time, horizon))
    if isinstance(output, Integral):
        return Row(INTEGRAL, output.expr)
    magnitude = isinstance(output.expr, sp.Abs)
    return Row(RANGE, output.expr.args[0] if magnitude else output.expr, magnitude=magnitude)
