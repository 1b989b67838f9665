"""Locks for libraries with global state, so that everything public can be called from any thread.

A thread acquires them in the reverse order of their definition here, and waits for no other thread while it holds one.
A fork waits until they are free, so that no child process inherits a lock that is never released. So it does for the
lock of LLVM, which a thread holds without any of these where it lets go of machine code.
"""

import os
import sys
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from symfric.spelling import spelt

P = ParamSpec("P")
R = TypeVar("R")

SYMBOLIC = threading.RLock()  # SymPy and mpmath, CasADi functions, compilers, and their caches
OPTIMISER = threading.RLock()  # IPOPT and its linear solver
DRAWING = threading.RLock()  # matplotlib's pyplot, fonts and settings
_ALL = DRAWING, OPTIMISER, SYMBOLIC
_compilers: list[Any] = []  # the lock of LLVM, during a fork


def alone(lock: AbstractContextManager[Any]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorate a function so that it holds a lock while it runs."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        answered = spelt(function)

        @wraps(function)
        def locked(*args: P.args, **kwargs: P.kwargs) -> R:
            with lock:
                return answered(*args, **kwargs)

        return locked

    return decorate


def _acquire() -> None:
    for lock in _ALL:
        lock.acquire()
    library = getattr(sys.modules.get("llvmlite.binding.ffi"), "lib", None)
    if library is not None:  # loaded so far; no thread that holds it waits for one of ours
        library._lock.__enter__()
        _compilers.append(library._lock)


def _release() -> None:
    if _compilers:
        _compilers.pop().__exit__()
    for lock in reversed(_ALL):
        lock.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_acquire, after_in_parent=_release, after_in_child=_release)
