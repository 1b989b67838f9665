"""What a scene under a sampled input wants, as rows of which a range or a value at a time is taken."""

from typing import NamedTuple

from symfric.errors import NoRoute
from symfric.lower.sampled_oscillator import Record, record
from symfric.model.outputs import INTEGRAL
from symfric.solve.lowered import LoweredScene
from symfric.solve.observables import Wanted


class Recorded(NamedTuple):
    """A scene as one mass under a record, and what it wants."""

    problem: Record
    wanted: Wanted


def recorded_in(lowered: LoweredScene) -> Recorded:
    """Write a scene down as one mass under a record.

    Raises
    ------
    NoRoute
        If the scene is something else, or wants more than the march through a record gives.
    """
    wanted = lowered.wanted
    if any(r.kind == INTEGRAL for r in wanted.rows):
        raise NoRoute("an integral is wanted")
    return Recorded(record(lowered.dynamics, lowered.scene.inputs, [r.expr for r in wanted.rows]), wanted)
