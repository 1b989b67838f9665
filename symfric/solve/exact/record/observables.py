"""Observables of a scene under a sampled input."""

from typing import NamedTuple

from symfric.errors import NoRoute
from symfric.lower.sampled_oscillator import Record, record
from symfric.model.outputs import INTEGRAL
from symfric.solve.lowered import LoweredScene
from symfric.solve.observables import Wanted


class Recorded(NamedTuple):
    """A scene as one mass under a record, with its observables."""

    problem: Record
    wanted: Wanted


def recorded_in(lowered: LoweredScene) -> Recorded:
    """Express a scene as one mass under a record.

    Raises
    ------
    NoRoute
        If the scene has another form, or an output that this loop does not provide.
    """
    wanted = lowered.wanted
    if any(r.kind == INTEGRAL for r in wanted.rows):
        raise NoRoute("an integral is wanted")
    return Recorded(record(lowered.dynamics, lowered.scene.inputs, [r.expr for r in wanted.rows]), wanted)
