"""Cost of outputs: time and memory of the same motion with more and more outputs, and of starting a process."""

import statistics
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from symfric.model import scenes
from symfric.model.outputs import End, Events, HalfRange, Integral, Output, Trajectory
from symfric.solve.routes import prepare

_TOLERANCE = 1e-10
_ROUNDS, _REPEATS = 9, 40
_X, _U = sp.symbols("x u", real=True)
_FIRST = (
    "import symfric as sf; sf.simulate(sf.scenes.mass_on_belt(v_b=0.2).wanting({'end': sf.End()}), 1e-10).checked()"
)
_EMPTY = f"""
import os, tempfile
with tempfile.TemporaryDirectory() as folder:
    os.environ["SYMFRIC_CACHE_DIR"] = folder
    {_FIRST}
"""
_STARTS = {
    "Python and SymPy": "import sympy",
    "the package": "import symfric",
    "first result of a mass on a belt": _FIRST,
    "the same on a machine that never ran it": _EMPTY,
}
_PEAK = """
try:
    print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
except OSError:  # only Linux tells
    print("nan")
"""


@dataclass(frozen=True)
class Need:
    """Cost of one set of outputs.

    Attributes
    ----------
    wanted : str
    seconds : float
        CPU time of one run, median; of a process, elapsed time.
    kilobytes : float
        Size of the result; of a process, its largest memory, NaN if the system does not report it.
    """

    wanted: str
    seconds: float
    kilobytes: float


def needs() -> tuple[Need, ...]:
    """Measure one motion, P2, with the final state only, then with more and more outputs, in interleaved rounds."""
    scene = scenes.mass_on_belt(v_b=0.2)
    spent = {"power": Integral(0.1 * _U**2)}
    asked: list[tuple[str, dict[str, Output], tuple[str, ...]]] = [
        ("end state", {"end": End()}, ()),
        ("+ half range", {"end": End(), "half": HalfRange(_X)}, ()),
        ("+ energy spent in the damper", {"end": End(), "half": HalfRange(_X), **spent}, ()),
        ("+ list of events", {"end": End(), "half": HalfRange(_X), **spent, "events": Events()}, ()),
        ("+ trajectory", {"end": End(), "half": HalfRange(_X), **spent, "path": Trajectory()}, ()),
        ("end state and its derivative to one value", {"end": End()}, ("v_b",)),
        ("end state and its derivatives to three", {"end": End()}, ("v_b", "beta", "gamma2")),
    ]
    programs = [prepare(scene.wanting(w), _TOLERANCE, None, directions) for _, w, directions in asked]
    samples: list[list[float]] = [[] for _ in programs]
    for program in programs:
        program.run().checked()
    for _ in range(_ROUNDS):
        for program, taken in zip(programs, samples, strict=True):
            start = time.process_time()
            for _ in range(_REPEATS):
                program.run()
            taken.append((time.process_time() - start) / _REPEATS)
    kept = [_kept(program.run) for program in programs]
    return tuple(
        Need(name, statistics.median(taken), size) for (name, *_), taken, size in zip(asked, samples, kept, strict=True)
    )


def _kept(run: Callable[[], object]) -> float:
    """Return the size of a result in kB."""
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    result = run()
    after = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    del result
    return (after - before) / 1024


def starts() -> tuple[Need, ...]:
    """Measure new processes, caches warm unless they are to be empty: three of each, in turn."""
    measured: dict[str, list[tuple[float, float]]] = {name: [] for name in _STARTS}
    for _ in range(4):
        for name, code in _STARTS.items():
            start = time.perf_counter()
            done = subprocess.run(
                [sys.executable, "-c", f"{code}\n{_PEAK}"], capture_output=True, text=True, check=True
            )
            measured[name].append((time.perf_counter() - start, float(done.stdout)))
    rows = []
    for name, pairs in measured.items():
        seconds, kilobytes = zip(*pairs[1:], strict=True)  # the first fills the caches
        rows.append(Need(name, statistics.median(seconds), statistics.median(kilobytes)))
    return tuple(rows)
