"""pyHarm's harmonic balance on a forced mass with a Jenkins element."""

import contextlib
import functools
import io
import logging
import tempfile
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer

HARMONICS = {1e-2: 1, 1e-3: 3, 1e-4: 9, 1e-5: 19, 1e-6: 39}  # tried in the place of tolerances
WORKAROUNDS = (
    "its only setting of accuracy is the number of harmonics: 1, 3, 9, 19, 39, with some hundred samples of each",
    "solved at each frequency from the linear response, without continuation, and with its analytical Jacobian",
    "the peak is taken of the harmonics on 20001 times",
)
_SAMPLES = 20001  # times of a period at which the motion is evaluated for its peak
_MOST, _PER_HARMONIC = 4096, 256  # samples of a period for the friction


def prepare(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that balances the harmonics at each frequency of the problem."""
    with _silent(), _elsewhere():
        from pyHarm.Maestro import Maestro

        made = Maestro(_model(problem, HARMONICS[tolerance]))
    analysis, dofs = made.nls["response"], made.system.expl_dofs
    phase = np.linspace(0.0, 2 * np.pi, _SAMPLES)
    waves = [
        np.cos(h * phase) if part == "c" else np.sin(h * phase)
        for h, part in zip(dofs["harm"], dofs["cs"], strict=True)
    ]

    def peak(frequency: float) -> float:
        analysis.analysis_options["puls_start"] = frequency
        analysis.SolList.clear()
        analysis.initialise(None)
        (solution,) = analysis.SolList
        if not solution.flag_accepted:
            raise RuntimeError(f"the balance at the frequency {frequency:g} does not converge")
        return float(np.max(np.abs(solution.x[:-1] @ waves)))

    def run() -> BenchAnswer:
        with _silent(), _elsewhere():
            return BenchAnswer(tuple(peak(w) for w in problem.frequencies), 0)

    return run


def _model(problem: Problem, harmonics: int) -> dict[str, Any]:
    """Return the input of pyHarm for the oscillator of a problem."""
    one = problem.joint
    samples = min(_MOST, max(512, _PER_HARMONIC * (harmonics + 1)))
    at = {"connect": {"mass": [0]}, "dirs": [0]}
    return {
        "analysis": {
            "response": {
                "study": "frf",
                "puls_inf": 0.5 * min(problem.frequencies),
                "puls_sup": 2.0 * max(problem.frequencies),
                "verbose": False,
            }
        },
        "system": {"type": "Base", "nh": harmonics, "nti": samples},
        "substructures": {
            "mass": {
                "matrix": {"M": np.eye(1), "K": np.eye(1), "C": np.array([[one.damping]]), "G": np.zeros((1, 1))},
                "ndofs": 1,
                "nmodes": 0,
            }
        },
        "connectors": {
            "joint": {"type": "Jenkins", **at, "k": one.stiffness, "mu": 1.0, "N0": one.limit},
            "force": {"type": "GOForcing", **at, "dto": 0, "ho": 1, "amp": 1.0, "phi": 0.0},
        },
    }


@contextlib.contextmanager
def _elsewhere() -> Iterator[None]:
    """Work in a temporary folder of this process: it writes a folder ``.pyHarm`` into the present one."""
    with contextlib.chdir(_folder().name):
        yield


@functools.cache
def _folder() -> "tempfile.TemporaryDirectory[str]":
    return tempfile.TemporaryDirectory()


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Keep back its log, its banner, and numba's hints on its code."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(before)
