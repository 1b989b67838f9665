"""Displays of progress: a bar on a terminal or in a notebook, or lines of text."""

import logging
import sys
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress

_FIRST_PAUSE, _LONGEST_PAUSE = 10.0, 120.0  # between two lines about one call, s; each is twice the last one


class Surface(ABC):
    """Display of the progress of one call."""

    @abstractmethod
    def update(self, words: str, fraction: float | None, spent: float) -> None:
        """Show the stage of the call after some seconds, and the fraction done if it is known."""

    @abstractmethod
    def close(self, spent: float) -> None:
        """Remove the display, after the call."""


def opened(name: str, log: logging.Logger) -> Surface:
    """Return the display for a call in this program."""
    logs = log.isEnabledFor(logging.INFO) and log.hasHandlers()
    ends = Lines(name, log.info if logs else None)
    if _in_notebook():
        return Cell(name, ends)
    if sys.stderr is not None and sys.stderr.isatty():
        return Bar(name, ends)
    if logs or log.hasHandlers() or sys.stderr is None:
        return ends
    return Lines(name, _on_stderr)


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    return ipython is not None and type(ipython.get_ipython()).__name__ == "ZMQInteractiveShell"


def _on_stderr(line: str) -> None:
    print(f"symfric: {line}", file=sys.stderr, flush=True)


class Lines(Surface):
    """Lines at growing intervals, written by a function if there is one."""

    def __init__(self, name: str, write: Callable[[str], None] | None):
        self._name, self._write = name, write
        self._next, self._pause = 0.0, _FIRST_PAUSE

    def update(self, words: str, fraction: float | None, spent: float) -> None:
        if self._write is not None and spent >= self._next:
            self._next, self._pause = spent + self._pause, min(2 * self._pause, _LONGEST_PAUSE)
            done = "" if fraction is None else f"{100 * fraction:.0f} %"
            self._write(f"{self._name}: {', '.join(filter(None, (done, words))) or 'working'}")

    def close(self, spent: float) -> None:
        if self._write is not None:
            self._write(f"{self._name}: {spent:.1f} s")


class Cell(Surface):
    """A bar below the cell of a notebook; the log has the time at the end."""

    def __init__(self, name: str, ends: Lines):
        self._name, self._ends = name, ends
        self._handle: Any = None

    def update(self, words: str, fraction: float | None, spent: float) -> None:
        text = f"{self._name}: {words + ', ' * bool(words)}{spent:.0f} s"
        value = "" if fraction is None else f' value="{fraction:.3f}"'
        bar = f'<progress max="1"{value} aria-label="{escape(self._name)}"></progress>'
        data = {"text/plain": text, "text/html": f"{bar} {escape(text)}"}
        if self._handle is None:
            display = import_module("IPython.display").display  # it is there in a notebook, and no dependency
            self._handle = display(data, raw=True, display_id=True)
        else:
            self._handle.update(data, raw=True)

    def close(self, spent: float) -> None:
        if self._handle is not None:
            self._handle.update({"text/plain": "", "text/html": ""}, raw=True)
        self._ends.close(spent)


class Bar(Surface):
    """A line at the bottom of a terminal, which disappears; the log has the time at the end."""

    def __init__(self, name: str, ends: Lines):
        self._name, self._ends = name, ends
        self._task: Any = None

    def update(self, words: str, fraction: float | None, spent: float) -> None:
        bars = _bars.drawn()
        text, total = f"{self._name}: {words}" if words else self._name, None if fraction is None else 1.0
        if self._task is None:
            self._task = bars.add_task(text, total=total, spent=f"{spent:.0f} s")
        bars.update(self._task, description=text, total=total, completed=fraction or 0.0, spent=f"{spent:.0f} s")
        bars.refresh()

    def close(self, spent: float) -> None:
        if self._task is not None:
            _bars.remove(self._task)
        self._ends.close(spent)


class _Bars:
    """The bars of all calls under way, drawn by one display of rich."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._drawn: Progress | None = None

    def drawn(self) -> "Progress":
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        with self._lock:
            if self._drawn is None:
                columns = (
                    TextColumn("{task.description}", markup=False),
                    BarColumn(),
                    TextColumn("{task.fields[spent]}"),
                )
                console, both = Console(stderr=True), sys.stdout is not None and sys.stdout.isatty()
                # what the program prints on the terminal meanwhile comes above the bar; a file gets it as ever
                self._drawn = Progress(
                    *columns, console=console, auto_refresh=False, transient=True, redirect_stdout=both
                )
                self._drawn.start()
            return self._drawn

    def remove(self, task: Any) -> None:
        with self._lock:
            if self._drawn is not None:
                self._drawn.remove_task(task)
                if not self._drawn.tasks:
                    self._drawn.stop()
                    self._drawn = None


_bars = _Bars()


def forget() -> None:
    """Start anew in a process that was forked; what is drawn belongs to the other one."""
    global _bars
    _bars = _Bars()
