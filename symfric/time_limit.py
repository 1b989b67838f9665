"""A limit of the time that a computation may spend in runs, however many they are and whoever starts them."""

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_END: ContextVar[tuple[float, float]] = ContextVar("end of the time for runs, and its length", default=(math.inf, 0.0))


class OutOfTime(Exception):
    """The time of the present `time_limit` has passed."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Let runs within this block, of this thread, raise `OutOfTime` once so much time has passed.

    A run looks at the clock when it begins and now and then; the time between two runs is not interrupted. Limits may
    be nested: the one that ends first counts.

    Parameters
    ----------
    seconds : float
        Processor time of this thread: a busy machine changes no result.
    """
    end = time.thread_time() + seconds, seconds
    token = _END.set(min(end, _END.get()))
    try:
        yield
    finally:
        _END.reset(token)


def check_time() -> None:
    """Raise `OutOfTime` if the limit of the present block has passed."""
    end, seconds = _END.get()
    if end < math.inf and time.thread_time() > end:
        raise OutOfTime(f"stopped after {seconds:g} s")


@contextmanager
def untimed() -> Iterator[None]:
    """Not count the time of this block, which prepares the machine for all later runs."""
    begin = time.thread_time()
    try:
        yield
    finally:
        end, seconds = _END.get()
        _END.set((end + time.thread_time() - begin, seconds))
