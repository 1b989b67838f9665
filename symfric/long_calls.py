"""A log of calls that take long, for the functions that may."""

import logging
import sys
import threading
import time
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

PATIENCE = 1.0  # time after which a call is logged, s
_log = logging.getLogger("symfric")


def logged(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a function so that it logs that it works once this takes a second, and its time at the end.

    Calls by the package itself are not logged: they are parts of a longer one.
    """

    @wraps(function)
    def timed(*args: P.args, **kwargs: P.kwargs) -> R:
        caller = sys._getframe(1).f_globals.get("__name__", "")
        if not _log.isEnabledFor(logging.INFO) or caller.startswith("symfric."):
            return function(*args, **kwargs)
        begin = time.monotonic()
        waiting = threading.Timer(PATIENCE, _log.info, ("%s: working", function.__name__))
        waiting.daemon = True
        waiting.start()
        try:
            return function(*args, **kwargs)
        finally:
            waiting.cancel()
            if time.monotonic() - begin > PATIENCE:
                _log.info("%s: %.1f s", function.__name__, time.monotonic() - begin)

    return timed
