"""The observables of a scene, which an event loop accumulates."""

from dataclasses import dataclass

from symfric.model.outputs import OutputOfExpression, Row
from symfric.model.scene import Scene


@dataclass(frozen=True)
class Observables:
    """Observables of a scene, and whether its trajectory and events are stored.

    Attributes
    ----------
    rows : tuple of Row
        Each once.
    row : dict of str to int
        Index of the observable of every output of an expression.
    path, events : bool
        Whether the trajectory, or the list of events, is stored.
    """

    rows: tuple[Row, ...]
    row: dict[str, int]
    path: bool
    events: bool


def observables_of(scene: Scene) -> Observables:
    """Return the observables of the outputs of a scene."""
    outputs = scene.outputs
    row = {n: o.row(scene.horizon) for n, o in outputs.items() if isinstance(o, OutputOfExpression)}
    rows = tuple(dict.fromkeys(row.values()))
    path = any(o.keeps_path for o in outputs.values())
    events = any(o.keeps_events for o in outputs.values())
    return Observables(rows, {n: rows.index(r) for n, r in row.items()}, path, events)
