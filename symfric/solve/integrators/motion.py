"""The state of a run of the route `integrators` in progress."""

import math
from dataclasses import dataclass, field

import numpy as np

from symfric.solve.path import Path
from symfric.solve.status import Status


@dataclass
class Motion:
    """State of a run in progress."""

    t: float
    y: np.ndarray
    total: np.ndarray
    before: np.ndarray  # the part of total from before a time after which alone it counts
    m: np.ndarray
    farthest: np.ndarray
    size: np.ndarray
    status: Status = Status.OK
    rest: float = math.nan
    marked: float = 0.0  # time at which progress was looked at last
    reach: float = math.inf
    events: list[tuple[float, int, int, int]] = field(default_factory=list)
    counts: dict[str, int] = field(
        default_factory=lambda: dict.fromkeys(("pieces", "steps", "events", "kinks", "grazes"), 0)
    )
    pieces: list[Path] = field(default_factory=list)
    inner: np.ndarray | None = None  # see `IntegratedPiece`
    low: np.ndarray | None = None
    high: np.ndarray | None = None
    at: np.ndarray | None = None  # times of low and high, (2, rows), if cubics run between the nodes
    values: dict[str, np.ndarray] = field(default_factory=dict)
