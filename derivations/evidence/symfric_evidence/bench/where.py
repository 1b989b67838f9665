"""Where the CPU time of long calls goes: equations, CasADi's graphs, compilation, runs, derivatives, Newton's method.

Each call runs in new processes: with empty caches on disk, with full ones, and once more in the second process. The
process samples its own stack by CPU time, and what passed since the last sample counts for the innermost frame that has
a kind, so long calls of compiled libraries count where they were made and nothing else is slowed down.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import FrameType

import symfric
from symfric.errors import SceneError
from symfric.solve.loop import compiled_model
from symfric_evidence.bench.calls import CALLS

KINDS = ("equations", "graphs", "compilation", "runs", "derivatives", "Newton", "other")
STATES = ("cold", "warm", "again")
_INTERVAL = 1e-3  # s of CPU time between two samples, where the system's clock allows
# the innermost frame whose file has one of these parts decides
_PLACES = (
    ("/sympy/", "equations"),
    ("/mpmath/", "equations"),
    ("/llvmlite/", "compilation"),
    ("/numba/", "compilation"),
    ("/symfric/codegen/", "compilation"),
    ("/symfric/model/", "equations"),
    ("/symfric/lower/", "equations"),
    ("/symfric/theory/", "equations"),
    ("/symfric/solve/taylor/", "graphs"),
    ("/symfric/solve/exact/", "graphs"),
    ("/symfric/solve/loop/", "graphs"),
    ("/symfric/solve/lanes/", "compilation"),
    ("/symfric/solve/integrators/implicit/", "derivatives"),
    ("/symfric/solve/integrators/", "runs"),
    ("/symfric/orbits/variations.py", "derivatives"),
    ("/symfric/orbits/gauss_steps.py", "derivatives"),
    ("/symfric/orbits/", "Newton"),
)
_RUNNING = ("launch", "_launch")  # names of the frames that call a compiled loop
_MAKING = ("__init__", "_check", "_guard_rates")  # frames of orbits in which CasADi's graphs are made, not evaluated


@dataclass(frozen=True)
class Share:
    """CPU time of one call in one state of the caches.

    Attributes
    ----------
    call, state : str
    seconds : dict of str to float
        By kind.
    runs, varied : int
        Runs of the compiled event loop, and those of them with derivatives.
    """

    call: str
    state: str
    seconds: dict[str, float]
    runs: int
    varied: int

    @property
    def total(self) -> float:
        """CPU seconds."""
        return sum(self.seconds.values())

    def to_dict(self) -> dict[str, object]:
        """Return plain data."""
        return asdict(self)


def where(names: Sequence[str] = (), progress: Callable[[str], None] | None = None) -> tuple[Share, ...]:
    """Measure calls with empty caches on disk, with full ones, and once more in the same process.

    Parameters
    ----------
    names : sequence of str
        Of `CALLS`; all of them unless given.
    progress : callable, optional
        Called with a line of text before each call.

    Raises
    ------
    SceneError
        On an unknown name, or where the system has no timer of CPU time.
    """
    if not hasattr(signal, "setitimer"):
        raise SceneError("this system has no timer of CPU time; Linux and macOS have one")
    unknown = next((name for name in names if name not in CALLS), None)
    if unknown is not None:
        raise SceneError(f"no call {unknown!r}; there are {', '.join(CALLS)}")
    shares: list[Share] = []
    for name in names or CALLS:
        if progress is not None:
            progress(name)
        with tempfile.TemporaryDirectory() as folder:
            shares += _measured(name, folder, 1)
            shares += _measured(name, folder, 2)
    return tuple(shares)


def _measured(name: str, folder: str, repeats: int) -> list[Share]:
    """Return the shares of a call in a new process."""
    roots = [str(Path(package.__file__ or "").parents[1]) for package in (symfric, sys.modules[__name__.split(".")[0]])]
    paths = os.pathsep.join([*roots, os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "SYMFRIC_CACHE_DIR": folder, "PYTHONPATH": paths}
    code = f"from symfric_evidence.bench.where import report; report({name!r}, {repeats})"
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    found = [json.loads(line) for line in done.stdout.splitlines()]
    states = STATES[:1] if repeats == 1 else STATES[1:]
    return [Share(name, state, *parts) for state, parts in zip(states, found, strict=False)]


def report(name: str, repeats: int) -> None:
    """Print, for each repeat of a call, its seconds by kind and its numbers of runs as a line of JSON."""
    for _ in range(repeats):
        sampler = Sampler()
        sampler.measure(CALLS[name])
        print(json.dumps([sampler.seconds, sampler.runs, sampler.varied]), flush=True)


class Sampler:
    """Adds up the CPU time of calls by kind.

    Attributes
    ----------
    seconds : dict of str to float
    runs, varied : int
        See `Share`.
    """

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(KINDS, 0.0)
        self.runs = self.varied = 0
        self._last = 0.0

    def measure(self, call: Callable[[], object]) -> None:
        """Make a call on the main thread, and add its time."""
        drive = compiled_model.Workspace.drive

        def counted(workspace: compiled_model.Workspace, *args: object) -> object:
            self.runs += 1
            self.varied += bool(workspace.arrays.limits.varied)
            return drive(workspace, *args)  # type: ignore[arg-type]

        compiled_model.Workspace.drive = counted  # type: ignore[assignment, method-assign]
        before = signal.signal(signal.SIGPROF, lambda _, frame: self._add(frame))
        self._last = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, _INTERVAL, _INTERVAL)
        try:
            call()
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            self._add(None)
            signal.signal(signal.SIGPROF, before)
            compiled_model.Workspace.drive = drive  # type: ignore[method-assign]

    def _add(self, frame: FrameType | None) -> None:
        now = time.process_time()
        self.seconds[kind_of(frame)] += now - self._last
        self._last = now


def kind_of(frame: FrameType | None) -> str:
    """Return the kind of work that a frame does."""
    evaluates = False
    while frame is not None:
        file, name = frame.f_code.co_filename.replace(os.sep, "/"), frame.f_code.co_name
        if "/casadi/" in file:
            evaluates = True
        elif "/symfric/codegen/" in file and name in _RUNNING:
            return _run_of(frame)
        elif file.startswith("<frozen importlib"):
            return "other"
        else:
            kind = next((kind for part, kind in _PLACES if part in file), "")
            if evaluates and "/symfric/" in file:
                return kind if kind in ("Newton", "derivatives", "runs") and name not in _MAKING else "graphs"
            if kind:
                return kind
        frame = frame.f_back
    return "other"


def _run_of(frame: FrameType) -> str:
    """Return whether a run is one with derivatives."""
    back: FrameType | None = frame
    while back is not None and back.f_code.co_name != "drive":
        back = back.f_back
    workspace = back.f_locals.get("self") if back is not None else None
    varied = isinstance(workspace, compiled_model.Workspace) and workspace.arrays.limits.varied
    return "derivatives" if varied else "runs"
