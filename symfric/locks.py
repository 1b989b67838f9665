"""Locks for libraries with global state, so that everything public can be called from any thread.

A thread takes them in the order in which they stand here, from the last to the first, and waits for no other thread
while it has one. A process that forks waits until they are free, so that a child never gets one that nobody gives back.
"""

import os
import threading
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

SYMBOLIC = threading.RLock()  # SymPy and mpmath, functions made by CasADi, compilers, caches of what they made
OPTIMISER = threading.RLock()  # IPOPT and its linear solver
DRAWING = threading.RLock()  # matplotlib's pyplot, fonts and settings
_ALL = DRAWING, OPTIMISER, SYMBOLIC


def alone(lock) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorate a function so that a thread has this lock while it runs."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def locked(*args: P.args, **kwargs: P.kwargs) -> R:
            with lock:
                return function(*args, **kwargs)

        return locked

    return decorate


def _acquire() -> None:
    for lock in _ALL:
        lock.acquire()


def _release() -> None:
    for lock in reversed(_ALL):
        lock.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_acquire, after_in_parent=_release, after_in_child=_release)
