"""What a scene under a sampled input wants, as rows of which a range or a value at a time is taken."""

import math
from typing import NamedTuple

import sympy as sp

from symfric.errors import NoRoute
from symfric.lower.record import Record, record
from symfric.model.outputs import At, Integral, ScalarOfExpression
from symfric.model.scene import Scene


class Row(NamedTuple):
    """The range of an expression or of its magnitude, or its value at a time; the time is negative for a range."""

    expr: sp.Expr
    magnitude: bool
    time: float


class Recorded(NamedTuple):
    """A scene as one mass under a record, its wanted rows, and the row of every scalar output."""

    problem: Record
    rows: tuple[Row, ...]
    row: dict[str, int]


def recorded_in(scene: Scene, varied: frozenset[str] = frozenset()) -> Recorded:
    """Write a scene down as one mass under a record.

    Raises
    ------
    NoRoute
        If the scene is something else, or wants more than the march through a record gives.
    """
    place, rows = {}, {}
    for name, output in scene.outputs.items():
        if isinstance(output, Integral):
            raise NoRoute("an integral is wanted")
        if isinstance(output, ScalarOfExpression):
            place[name] = rows.setdefault(_row(output, scene.horizon), len(rows))
    return Recorded(record(scene, [r.expr for r in rows], varied), tuple(rows), place)


def _row(output: ScalarOfExpression, horizon: float) -> Row:
    if isinstance(output, At):
        return Row(output.expr, False, horizon if output.time is None else min(output.time, horizon))
    if isinstance(output.expr, sp.Abs):
        return Row(output.expr.args[0], True, -math.inf)
    return Row(output.expr, False, -math.inf)
