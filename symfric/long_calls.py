"""Progress of long calls, shown on a terminal, in a notebook or in the log."""

import logging
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import wraps
from types import FrameType
from typing import ParamSpec, TypeVar

from symfric.shown_progress import Surface, forget, opened
from symfric.spelling import spelt

P = ParamSpec("P")
R = TypeVar("R")

PATIENCE = 2.0  # time after which a call is shown, s
INTERVAL = 0.2  # between two looks at calls that are shown, s
_log = logging.getLogger("symfric")
_RUNS = ("run", "simulate")  # calls that are one run

Told = tuple[str, float | None]
_NOTHING: Told = "", None


class Call:
    """A call by the user, while it works.

    Attributes
    ----------
    name : str
    begin : float
    levels : list of (str, float or None)
        What the call and the calls within it are at, outermost first: words, and the fraction done if it is known.
    """

    __slots__ = ("_surface", "begin", "levels", "name")

    def __init__(self, name: str):
        self.name, self.begin = name, time.monotonic()
        self.levels = [_NOTHING]
        self._surface: Surface | None = None

    def at(self) -> Told:
        """Return the stage of the call in words, and the fraction done if it is known."""
        levels = list(self.levels)
        return ", ".join([words for words, _ in levels if words][:2]), levels[0][1]

    def show(self, now: float) -> None:
        """Show the progress; a closed stream does not end the call."""
        with suppress(OSError, ValueError):
            if self._surface is None:
                self._surface = opened(self.name, _log)
            self._surface.update(*self.at(), now - self.begin)

    def close(self) -> None:
        """Remove the display; log how long the call took, where calls are logged."""
        spent = time.monotonic() - self.begin
        if self._surface is not None or spent > PATIENCE:
            with suppress(OSError, ValueError):
                surface, self._surface = self._surface or opened(self.name, _log), None
                surface.close(spent)


_CALL: ContextVar[Call | None] = ContextVar("the user's call", default=None)


class _Watch:
    """Thread that watches the calls under way; it ends when there are none."""

    def __init__(self) -> None:
        self.shown = os.environ.get("SYMFRIC_PROGRESS", "").lower() not in ("0", "off", "no", "false")
        self._lock = threading.Lock()
        self._calls: list[Call] = []
        self._thread: threading.Thread | None = None

    def add(self, call: Call) -> None:
        with self._lock:
            if call not in self._calls:
                self._calls.append(call)
            if self._thread is None:
                self._thread = threading.Thread(target=self._look, name="symfric progress", daemon=True)
                self._thread.start()

    def remove(self, call: Call) -> None:
        try:
            self._end(call)
        except KeyboardInterrupt:  # a second one
            self._end(call)
            raise

    def _end(self, call: Call) -> None:
        with self._lock:  # nothing is drawn after this
            if call in self._calls:
                self._calls.remove(call)
                call.close()

    def _look(self) -> None:
        while True:
            with self._lock:
                if not self._calls:
                    self._thread = None
                    return
                now, wait = time.monotonic(), PATIENCE
                for call in self._calls:
                    left = call.begin + PATIENCE - now
                    if left <= 0:
                        call.show(now)
                    wait = min(wait, max(left, INTERVAL))
            time.sleep(wait)


_watch = _Watch()


def _after_fork() -> None:
    global _watch
    forget()
    shown, _watch = _watch.shown, _Watch()
    _watch.shown = shown
    _CALL.set(None)


if sys.platform != "win32":
    os.register_at_fork(after_in_child=_after_fork)


@spelt
def show_progress(on: bool) -> None:
    """Turn the progress of calls of over two seconds on or off; it is on by default.

    On a terminal and in a notebook that is a bar, which disappears when the call ends. In scripts it is a line now and
    then: from the logger "symfric" if the script has set up logging, else on stderr. With the environment variable
    ``SYMFRIC_PROGRESS=0`` nothing is shown from the beginning.

    Parameters
    ----------
    on : bool

    Examples
    --------
    >>> import symfric as sf
    >>> sf.show_progress(False)
    >>> sf.show_progress(True)
    """
    if not isinstance(on, bool):
        raise TypeError(f"on is {on!r}; give True or False")
    _watch.shown = on


def logged(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a function so that its progress is shown once it takes two seconds; see `show_progress`.

    Calls by the package itself are not shown: they are parts of a longer one.
    """

    answered = spelt(function)

    @wraps(function)
    def timed(*args: P.args, **kwargs: P.kwargs) -> R:
        call = _CALL.get()
        if call is None:
            caller = sys._getframe(1).f_globals.get("__name__", "")
            if caller.startswith("symfric."):
                return function(*args, **kwargs)
            with _shown(function.__name__):
                return answered(*args, **kwargs)
        levels = call.levels
        levels.append(_NOTHING)
        try:
            return function(*args, **kwargs)
        finally:
            levels.pop()

    return timed


def show_this() -> None:
    """Show the present call of the user, even if nothing else is shown."""
    call = _CALL.get()
    if call is not None:
        _watch.add(call)


@contextmanager
def _shown(name: str) -> Iterator[None]:
    call = Call(name)
    token = _CALL.set(call)
    try:
        if _watch.shown:
            _watch.add(call)
        yield
    finally:
        _CALL.reset(token)
        _watch.remove(call)


@contextmanager
def long_call(name: str) -> Iterator[None]:
    """Show work that has turned out to be long, unless it is part of a call that is shown or of other work."""
    if _CALL.get() is None and _by_the_user(sys._getframe(2)):
        with _shown(name):
            yield
    else:
        yield


def _by_the_user(frame: FrameType | None) -> bool:
    """Whether a call by the package was made by another program, in a thread of that program."""
    while frame is not None:
        name = frame.f_globals.get("__name__", "")
        if not name.startswith("symfric.") and name != "contextlib":
            return name != "threading"
        frame = frame.f_back
    return False


def tell(words: str, fraction: float | None = None) -> None:
    """Report the stage of the present call.

    Parameters
    ----------
    words : str
    fraction : float, optional
        Of its work that is done, if it is known.
    """
    call = _CALL.get()
    if call is not None and call.levels:
        call.levels[-1] = words, fraction


def tell_of_run(fraction: float) -> None:
    """Report the fraction of a run that is done; shown where the call is this run."""
    call = _CALL.get()
    if call is not None and call.name in _RUNS:
        call.levels[0] = "", fraction


_KEEPING = ContextVar("whether an interrupt keeps what was found", default=False)


@contextmanager
def keep_when_interrupted() -> Iterator[None]:
    """Let calls that are interrupted within this block return what they have found so far.

    Without it an interrupt (Ctrl-C) ends the call and what it found is lost. The logger "symfric" warns. Within it:

    - `continue_cycle`, `frequency_response` and `symfric.structures.onset` return the branch to the last orbit, with
      the end "interrupted", `continue_special` its curve likewise;
    - `sweep` its table, with the status -3 where a case was not computed, ``program.map`` its batch and
      `bifurcation_diagram` its points likewise; `symfric.structures.flutter_map` the values until then;
    - `basins` the attractors found, with the status -3 for starts that belong to none of them as yet;
    - `lyapunov` the exponents over the time until then;
    - `identify` the best fit of the starts that were tried, once there is one; `compare_laws` the laws fitted, with
      "interrupted" as the reason of the others; `test_design` the best of the settings that were tried;
    - designs the best one so far, unverified: `symfric.design.absorber` with a contact, `collocation`,
      `contact_damper`, `controller`, `isolator`, `quench` once its averaged optimum is found, and `damper` of a forced
      scene or with `settle`.

    Other calls have nothing to keep and are interrupted as ever, and so is the work after the block: a motion that has
    not closed as yet is no `limit_cycle`, a damping that was tried at some speeds only no design of `damper` against
    limit cycles, and `positioning` evaluates formulas.

    Returns
    -------
    context manager

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.4)
    >>> with sf.keep_when_interrupted():
    ...     branch = sf.continue_cycle(belt, "v_b", (0.38, 0.42))
    >>> branch.ends
    ('span', 'span')
    """
    token = _KEEPING.set(True)
    try:
        yield
    finally:
        _KEEPING.reset(token)


@contextmanager
def until_interrupted(*names: str) -> Iterator[None]:
    """Leave this block at an interrupt and go on behind it, where the user's call has one of these names and keeps what
    it has found; within other calls this work is a part that cannot be used alone."""
    try:
        yield
    except KeyboardInterrupt:
        call = _CALL.get()
        if not _KEEPING.get() or call is None or call.name not in names:
            raise
        _log.warning("%s was interrupted; the result holds what it had found", call.name)


@contextmanager
def silent() -> Iterator[None]:
    """Show no call within this block, which has a display of its own."""
    token = _CALL.set(Call("silent"))
    try:
        yield
    finally:
        _CALL.reset(token)
