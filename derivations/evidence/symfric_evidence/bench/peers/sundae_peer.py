"""scikit-sundae's CVODE on a written-out scene, restarted at its root finding."""

from collections.abc import Callable

import numpy as np
import sympy as sp

from symfric_evidence.bench.peers.written_out import PeerLoop, Step, form_of
from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer

WORKAROUNDS = (
    "Adams method for slip and stick, as for any problem that is not stiff",
    "signs of slip are held constant between events, and every event may only fall",
    "whether an event fell is asked of the status: the list of events keeps those of earlier solves",
)
_STEPS = 10**7
_FELL = 2  # status of a solve that an event ended


def prepare(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that runs CVODE from event to event."""
    from sksundae.cvode import CVODE

    form = form_of(problem.scene)
    rates = sp.lambdify(form.arguments, list(form.rates), "math", cse=True)
    guards = sp.lambdify(form.arguments, list(form.guards), "math", cse=True)
    constants: list[float] = []

    def rate(t: float, y: np.ndarray, yp: np.ndarray) -> None:
        yp[:] = rates(t, *y.tolist(), *constants)

    def fall(t: float, y: np.ndarray, values: np.ndarray) -> None:
        values[:] = guards(t, *y.tolist(), *constants)

    n = len(form.guards)
    options = {"rtol": tolerance, "atol": tolerance, "method": "Adams", "max_num_steps": _STEPS}
    vars(fall).update(terminal=[True] * n, direction=[-1] * n)
    events = {"eventsfn": fall, "num_events": n} if n else {}
    solver = CVODE(rate, **options, **events)

    def advance(t: float, y: list[float], mode: list[float], line: list[float], end: float) -> Step:
        constants[:] = [*mode, *line]
        part = solver.solve(np.array([t, end]), np.array(y))
        if not part.success:
            raise RuntimeError(part.message)
        if part.t[-1] == t:
            raise RuntimeError(f"the event at t = {t:.6g} is found again and again")
        if part.status != _FELL:
            return end, part.y[-1].tolist(), None
        return float(part.t[-1]), part.y[-1].tolist(), int(np.flatnonzero(part.i_events[-1])[0])

    return PeerLoop(form, advance)
