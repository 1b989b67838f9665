"""Progress of a sweep: cases done, rate and remaining time."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from symfric.long_calls import tell

INTERVAL = 0.1  # least time between two reports, s


@dataclass(frozen=True)
class Progress:
    """Progress of a sweep.

    Attributes
    ----------
    done, total : int
        Cases; those found in a store count as done.
    rate : float
        Cases per second, without those found in a store.
    left : float
        Remaining time in seconds at that rate; infinite before the first case.
    """

    done: int
    total: int
    rate: float
    left: float

    def __str__(self) -> str:
        head = f"{self.done} of {self.total} cases"
        return f"{head}, {self.rate:.3g}/s, {duration(self.left)} left" if self.rate > 0 else head


def duration(seconds: float) -> str:
    """Return a time as text: 8 s, 4 min 10 s, 2 h 5 min."""
    s = round(seconds)
    if s < 60:
        return f"{s} s"
    return f"{s // 60} min {s % 60} s" if s < 3600 else f"{s // 3600} h {s % 3600 // 60} min"


class Meter:
    """Calls a progress function at most ten times a second."""

    def __init__(self, report: Callable[[Progress], None] | None, done: int, total: int):
        self._report, self._done_before, self._total = report, done, total
        self._begin = self._last = time.monotonic()

    def __call__(self, done: int, last: bool = False) -> None:
        now = time.monotonic()
        if now - self._last < INTERVAL and not last:
            return
        self._last = now
        made, spent = done - self._done_before, now - self._begin
        rate = made / spent if made and spent > 0 else 0.0
        left = (self._total - done) / rate if rate else float("inf")
        at = Progress(done, self._total, rate, left)
        tell(str(at), done / self._total)
        if self._report is not None:
            self._report(at)
