"""Outputs that are records of a run: its trajectory, its events."""

from dataclasses import dataclass
from typing import Any, ClassVar

from symfric.model.outputs.output import Output
from symfric.spelling import spelt


@spelt
@dataclass(frozen=True)
class Trajectory(Output):
    """The trajectory: states, modes, events and dense output.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=6.0)
    >>> run = sf.simulate(oscillator.wanting({"path": sf.Trajectory()}))
    >>> run.names
    ('x', 'u')
    >>> run(2.0).round(6)
    array([-0.274532, -0.818368])
    """

    word: ClassVar[str] = "trajectory"
    keeps_path: ClassVar[bool] = True
    keeps_events: ClassVar[bool] = True

    def value(self, run: Any, name: str) -> Any:
        return run.raw.path


@spelt
@dataclass(frozen=True)
class Events(Output):
    """The list of events, without the trajectory between them.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1, x0=1.0)
    >>> run = sf.simulate(oscillator.wanting({"events": sf.Events()}))
    >>> [e.kind for e in run["events"]]
    ['reverse', 'reverse', 'reverse', 'reverse', 'stick']
    """

    word: ClassVar[str] = "events"
    keeps_events: ClassVar[bool] = True

    def value(self, run: Any, name: str) -> Any:
        return run.events
