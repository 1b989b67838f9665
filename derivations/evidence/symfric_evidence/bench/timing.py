"""Measure CPU time and achieved error of solvers, interleaved in one process on one thread."""

import gc
import platform
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib import metadata

import mpmath as mp

from symfric.errors import SceneError
from symfric_evidence.bench.peers.registry import Peer, peers
from symfric_evidence.bench.problems import NAMES, Problem, named
from symfric_evidence.bench.result import BenchAnswer, Benchmark, ErrorCurve, ErrorPoint

_SAMPLE = 0.02  # least CPU time of a sample, s, so that the clock's resolution is negligible
_SLOW, _SLOWEST = 0.5, 5.0  # s; runs that take longer are measured in three rounds, and in one
_SHORT, _MORE = 0.01, 3  # s; shorter runs are measured in three times as many rounds, as a sample of them is short
_QUICK_ROUNDS, _ENOUGH = 3, 0.3  # of a quick benchmark; s, a solver that is slower is run at its first tolerance only


@dataclass
class _Entry:
    """One solver at one tolerance while it is measured."""

    tolerance: float
    run: Callable[[], BenchAnswer]
    answer: BenchAnswer
    once: float
    rounds: int
    samples: list[float] = field(default_factory=list)

    def sample(self) -> None:
        """Take CPU seconds of one run, averaged over the repeats; the collector is off, as in timeit."""
        run, repeats = self.run, max(1, int(_SAMPLE / self.once))
        enabled = gc.isenabled()
        gc.disable()
        try:
            start = time.process_time_ns()
            for _ in range(repeats):
                run()
            self.samples.append((time.process_time_ns() - start) / (1e9 * repeats) * self.answer.every)
        finally:
            if enabled:
                gc.enable()


@dataclass
class _Measured:
    """One solver on one problem while it is measured."""

    peer: Peer
    problem: Problem
    entries: list[_Entry] = field(default_factory=list)
    prepared: float | None = None
    failure: str = ""
    stopped: bool = False

    def prepare(self, rounds: int, quick: bool) -> None:
        """Prepare it for each of its tolerances, until one fails."""
        for tolerance in self.peer.tolerances[quick :: 1 + quick]:
            try:
                entry = self._entry(tolerance, rounds)
            except Exception as error:  # any failure of a peer is reported in the table
                self.failure = f"{type(error).__name__} at {tolerance:g}: {_message(error)}"
                return
            self.entries.append(entry)
            if quick and entry.once > _ENOUGH:
                self.stopped = True
                return

    def _entry(self, tolerance: float, rounds: int) -> _Entry:
        """Prepare and run twice: the first run may still compile or load, the second says how often to repeat."""
        start = time.perf_counter()  # elapsed time, since CPU time does not include a compiler process
        run = self.peer.prepare(self.problem, tolerance)
        answer = run()
        if self.prepared is None:
            self.prepared = time.perf_counter() - start
        start = time.process_time()
        run()
        once = max(time.process_time() - start, 1e-7)
        most = 1 if once > _SLOWEST else 3 if once > _SLOW else rounds
        samples = _MORE * rounds if once < _SHORT else min(rounds, most)
        return _Entry(tolerance, run, answer, once, samples)

    def curve(self) -> ErrorCurve:
        """Return what was measured."""
        points = tuple(
            ErrorPoint(
                tolerance=entry.tolerance,
                seconds=statistics.median(entry.samples),
                spread=max(entry.samples) / max(min(entry.samples), 1e-9),
                error=achieved_error(entry.answer, self.problem),
                events=entry.answer.events,
            )
            for entry in self.entries
        )
        name, solver, prepared = self.problem.name, self.peer.name, self.prepared or 0.0
        return ErrorCurve(name, solver, points, prepared, self.problem.events, self.failure, self.stopped)


def measure(
    names: Sequence[str] = (),
    *,
    with_peers: bool = False,
    rounds: int = 7,
    quick: bool = False,
    progress: Callable[[str], None] | None = None,
) -> Benchmark:
    """Measure the package's routes, and the peers that are installed, on the problems.

    Parameters
    ----------
    names : sequence of str
        Names of the problems; all of them unless given.
    with_peers : bool
        Whether the peers run too.
    rounds : int
        Samples of each solver and tolerance, three times as many of runs below 10 ms; all solvers are sampled once
        before any is sampled again, so that a disturbance of the machine meets them alike.
    quick : bool
        Whether three rounds of every second tolerance will do, and of a solver that takes .3 s or more one tolerance.
    progress : callable, optional
        Called with a line of text before each piece of work.

    Returns
    -------
    Benchmark

    Raises
    ------
    SceneError
        On an unknown problem.
    """
    unknown = next((name for name in names if name not in NAMES), None)
    if unknown is not None:
        raise SceneError(f"no problem {unknown!r} in the benchmark; there are {', '.join(NAMES)}")
    chosen = [p for p in peers().values() if p.own or with_peers]
    rounds = min(rounds, _QUICK_ROUNDS) if quick else rounds
    tell = progress or (lambda _: None)
    curves = []
    asked = [named(name) for name in (names or NAMES)]
    for each in asked:
        curves += _measure_problem(each, [p for p in chosen if not p.missing], rounds, quick, tell)
    return Benchmark(
        curves=tuple(curves),
        rounds=rounds,
        machine=machine(),
        workarounds={p.name: p.workarounds for p in chosen if p.workarounds},
        absent={p.name: ", ".join(p.missing) for p in chosen if p.missing},
        titles={each.name: each.title for each in asked},
    )


def machine() -> dict[str, str]:
    """Return a description of the machine: processor, Python, versions."""
    description = {"processor": _processor(), "python": platform.python_version()}
    for package in ("symfric", "casadi", "numpy", "scipy", "numba", "heyoka", "scikit-sundae", "diffrax", "pyHarm-os"):
        try:
            description[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return description


def _processor() -> str:
    try:
        with open("/proc/cpuinfo") as lines:
            return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def _measure_problem(
    problem: Problem, chosen: list[Peer], rounds: int, quick: bool, tell: Callable[[str], None]
) -> list[ErrorCurve]:
    measured = [_Measured(peer, problem) for peer in chosen if problem.name in peer.problems]
    for each in measured:
        tell(f"{problem.name}: preparing {each.peer.name}")
        each.prepare(rounds, quick)
    tell(f"{problem.name}: measuring")
    entries = [entry for each in measured for entry in each.entries]
    for k in range(max((entry.rounds for entry in entries), default=0)):
        for entry in entries:
            if k < entry.rounds:
                entry.sample()
    return [each.curve() for each in measured]


def _message(error: Exception) -> str:
    """Return the last line of an error that is not a rule: where CasADi says the reason, after the places."""
    lines = [line.strip() for line in str(error).splitlines() if any(c.isalnum() for c in line)]
    return lines[-1][:120] if lines else ""


def achieved_error(answer: BenchAnswer, problem: Problem) -> float:
    """Return the largest difference from the reference, computed with more digits than it has."""
    with mp.workdps(40):
        pairs = zip(answer.values, problem.reference[:: answer.every], strict=True)
        return max(float(abs(mp.mpf(float(value)) - mp.mpf(true))) for value, true in pairs)
