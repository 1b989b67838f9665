"""Common parts of the commands: options, output, progress on stderr, output folders."""

import contextlib
import json
import logging
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TypeVar

import click

from symfric.errors import SceneError
from symfric.files import write_together, write_whole
from symfric.interrupts import raise_at_interrupt

F = TypeVar("F", bound=Callable[..., object])
Progress = Callable[[str, float], None]
PATIENCE = 1.0  # time before progress is shown, s


def common_options(command: F) -> F:
    """Decorate a command with the options ``--json`` and ``--quiet``."""
    command = click.option("--quiet", "-q", is_flag=True, help="No progress and no summary.")(command)
    return click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")(command)


def say(text: str = "", *, err: bool = False, nl: bool = True) -> None:
    """Print a text; the stream is passed explicitly, since click would otherwise ignore its encoding."""
    click.echo(text, file=sys.stderr if err else sys.stdout, nl=nl)


def print_json(data: object) -> None:
    """Print data as JSON; NaN and infinity must have been replaced by None."""
    say(json.dumps(data, indent=2, allow_nan=False))


def write_results(files: Mapping[Path, bytes | str]) -> None:
    """Write result files, either all or none."""
    raise_at_interrupt()
    try:
        write_together(files)
    except OSError as error:
        names = ", ".join(str(place) for place in files)
        raise SceneError(
            f"cannot write {names} ({error.strerror}); make room, or name another folder with -o"
        ) from None


@contextlib.contextmanager
def progress_on_stderr(quiet: bool) -> Iterator[Progress]:
    """Yield a function of (stage, fraction done): a bar on a terminal, a line per stage elsewhere, nothing if quiet.

    Messages of the logger "symfric", such as the note on the first compilation, are shown too, immediately.
    """
    with no_interrupt_lost() as check:

        def checked(report: Progress) -> Progress:
            def checking(stage: str, fraction: float) -> None:
                check()
                report(stage, fraction)

            return checking

        if quiet:
            yield checked(lambda _stage, _fraction: None)
        elif sys.stderr.isatty():
            with _bar() as (report, write), _logged(write):
                yield checked(report)
        else:
            with _logged(lambda line: say(line, err=True)):
                yield checked(_Lines())


@contextlib.contextmanager
def no_interrupt_lost() -> Iterator[Callable[[], None]]:
    """Yield a function that raises `KeyboardInterrupt` if an earlier interrupt was lost.

    CasADi discards an interrupt that arrives in some of its callbacks, and the work would continue to its end.
    """
    heard = threading.Event()

    def note(_signal: int, _frame: object) -> None:
        heard.set()
        raise KeyboardInterrupt

    def check() -> None:
        if heard.is_set():
            raise KeyboardInterrupt

    raise_at_interrupt()
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield check
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield check
    except Exception:
        check()  # an interrupt inside an import may end as another error
        raise
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


class _Messages(logging.Handler):
    """Log handler that passes every message as one line to a function."""

    def __init__(self, write: Callable[[str], None]) -> None:
        super().__init__()
        self._write = write

    def emit(self, record: logging.LogRecord) -> None:
        self._write(record.getMessage())


@contextlib.contextmanager
def _logged(write: Callable[[str], None]) -> Iterator[None]:
    """Pass the log messages of the package to a function, while the context lasts."""
    handler, logger = _Messages(write), logging.getLogger("symfric")
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)


@contextlib.contextmanager
def _bar() -> Iterator[tuple[Progress, Callable[[str], None]]]:
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    start = time.monotonic()
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    bar = Bar(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task("", total=1.0)

    def report(stage: str, fraction: float) -> None:
        if time.monotonic() - start > PATIENCE and not bar.live.is_started:
            bar.start()
        bar.update(task, description=stage, completed=fraction)

    try:
        yield report, lambda line: bar.console.print(line, highlight=False, markup=False)
    finally:
        if bar.live.is_started:
            bar.stop()


class _Lines:
    """Plain progress: one line for each stage, at most one per second."""

    def __init__(self) -> None:
        self.last, self.stage = time.monotonic(), ""

    def __call__(self, stage: str, fraction: float) -> None:
        now = time.monotonic()
        if stage != self.stage and now - self.last > PATIENCE:
            say(f"{100 * fraction:3.0f} % {stage}", err=True)
            self.last, self.stage = now, stage


def writable_folder(path: Path) -> Path:
    """Create a folder and check that a file can be written there."""
    raise_at_interrupt()
    try:
        if path.exists() and not path.is_dir():
            raise SceneError(f"{path} is a file; name a folder for the results with -o")
        path.mkdir(parents=True, exist_ok=True)
        probe = path / ".symfric-probe"
        write_whole(probe, b"")
        probe.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"cannot write to {path} ({reason}); name another folder with -o") from None
    return path
