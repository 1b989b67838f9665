"""The observables of a scene, which an event loop accumulates."""

from dataclasses import dataclass

from symfric.model.rows import Row


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
