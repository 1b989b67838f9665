"""What a scene under a sampled input wants, as rows of which a range or a value at a time is taken."""

from typing import NamedTuple

import sympy as sp

from symfric.errors import NoRoute
from symfric.lower.record import Record, record
from symfric.model.scene import Scene
from symfric.solve.compiled import INTEGRAL, RANGE, Wanted, wanted_of


class Recorded(NamedTuple):
    """A scene as one mass under a record, what it wants, and for each row whether its magnitude is meant."""

    problem: Record
    wanted: Wanted
    magnitude: tuple[bool, ...]


def recorded_in(scene: Scene, varied: frozenset[str] = frozenset()) -> Recorded:
    """Write a scene down as one mass under a record.

    Raises
    ------
    NoRoute
        If the scene is something else, or wants more than the march through a record gives.
    """
    wanted = wanted_of(scene)
    if any(r.kind == INTEGRAL for r in wanted.rows):
        raise NoRoute("an integral is wanted")
    magnitude = tuple(r.kind == RANGE and isinstance(r.expr, sp.Abs) for r in wanted.rows)
    exprs = [r.expr.args[0] if m else r.expr for r, m in zip(wanted.rows, magnitude, strict=True)]
    return Recorded(record(scene, exprs, varied), wanted, magnitude)
