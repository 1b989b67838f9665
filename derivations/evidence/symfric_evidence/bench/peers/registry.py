"""The solvers of the benchmark: the package's own routes, and those of other packages where they are installed."""

import importlib.util
import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from symfric.model.outputs import End, HalfRange
from symfric.model.scene import Scene
from symfric.orbits.cycle import Orbit, limit_cycle
from symfric.solve.integrators.route import Integrators
from symfric.solve.protocol import Program
from symfric.solve.routes import RouteName, Settings, prepare
from symfric_evidence.bench.peers import (
    casadi_peer,
    diffrax_peer,
    heyoka_batch,
    heyoka_by_hand,
    heyoka_peer,
    impacts_by_hand,
    pyharm_peer,
    regularised_plane,
    scipy_peer,
    shooting_by_hand,
    sundae_peer,
)
from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer


@dataclass(frozen=True)
class Peer:
    """A solver that can be prepared for a problem.

    Attributes
    ----------
    name : str
    prepare : callable
        ``prepare(problem, tolerance) -> run``; ``run() -> Answer``. `prepare` does all work that is needed only once.
    problems : tuple of str
        Names of the problems it takes.
    tolerances : tuple of float
    workarounds : tuple of str
        What was done so that it does its best.
    needs : tuple of str
        Packages, or "cc" for a C compiler.
    own : bool
        Whether it is a route of this package.
    """

    name: str
    prepare: Callable[[Problem, float], Callable[[], BenchAnswer]]
    problems: tuple[str, ...]
    tolerances: tuple[float, ...]
    workarounds: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    own: bool = False

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of missing packages or tools."""
        return tuple(need for need in self.needs if not _present(need))


def _present(need: str) -> bool:
    return bool(shutil.which("cc")) if need == "cc" else importlib.util.find_spec(need) is not None


def _prepare_default(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Prepare the automatically selected route, or shooting for a periodic motion."""
    if problem.frequencies:
        return _shooting(problem, tolerance)
    if problem.branch is not None:
        return _along_branch(problem, tolerance)
    return (_together if problem.speeds else _through_program)(problem, tolerance, None)


def _prepare_series(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Prepare the route `taylor` where another one is selected automatically."""
    return _through_program(problem, tolerance, "taylor")


def _prepare_integrators(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Prepare the route `integrators`: erk on the law with its jump, cvodes on the continuous ones."""
    stiff = problem.name in _CONTINUOUS
    return _through_program(problem, tolerance, Integrators("cvodes" if stiff else "erk"))


def _through_program(
    problem: Problem, tolerance: float, route: RouteName | Settings | None
) -> Callable[[], BenchAnswer]:
    program = prepare(problem.scene, tolerance=tolerance, route=route)

    def run() -> BenchAnswer:
        result = program.run()
        return BenchAnswer(tuple(result.final.tolist()), int(result.stats["events"]))

    return run


def parts_of_sweep(
    problem: Problem, tolerance: float, route: RouteName | Settings | None
) -> tuple[Program, Program, sp.Symbol, sp.Symbol]:
    """Return both parts of a sweep, the second for the half range alone, and the state between them."""
    begin, end = problem.window
    (x,), (u,) = problem.scene.system.q, problem.scene.system.u
    first = prepare(problem.scene.until(begin, {"end": End()}), tolerance, route)
    return first, prepare(problem.scene.until(end - begin, {"half": HalfRange(x)}), tolerance, route), x, u


def _together(problem: Problem, tolerance: float, route: RouteName | Settings | None) -> Callable[[], BenchAnswer]:
    """Run all speeds of a sweep together."""
    first, second, x, u = parts_of_sweep(problem, tolerance, route)
    speeds = {"v_b": np.array(problem.speeds)}

    def run() -> BenchAnswer:
        state = first.map(speeds).final
        return BenchAnswer(tuple(second.map(speeds, {x: state[0], u: state[1]}).outputs["half"].tolist()), 0)

    return run


def _shooting(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Find the periodic motion at each frequency, from the start of the scene."""
    scenes = [problem.scene.where({"Omega": frequency}) for frequency in problem.frequencies]

    def peak(scene: Scene) -> float:
        orbit = limit_cycle(scene, tolerance=tolerance)
        return float(max(orbit.x_max[0], -orbit.x_min[0]))

    return lambda: BenchAnswer(tuple(peak(scene) for scene in scenes), 0)


def _along_branch(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Find the limit cycle at each speed, at the first from rest and then from the cycle before."""
    scenes = [problem.scene.where({"v_b": speed}) for speed in problem.branched.speeds]

    def run() -> BenchAnswer:
        orbits: list[Orbit] = []
        for scene in scenes:
            orbits.append(limit_cycle(scene, orbits[-1] if orbits else None, tolerance))
        return BenchAnswer(tuple(orbit.period for orbit in orbits), 0)

    return run


def _one_by_one(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Run every speed of a sweep by itself."""
    first, second, x, u = parts_of_sweep(problem, tolerance, None)

    def half_range(v_b: float) -> float:
        speed = {"v_b": v_b}
        state = first.run(speed).final
        return float(second.run(speed, {x: state[0], u: state[1]}).outputs["half"])

    return lambda: BenchAnswer(tuple(half_range(v) for v in problem.speeds), 0)


def _heyoka_together(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Take the number of belts side by side that is fastest on this machine."""
    return fastest([heyoka_batch.prepare_sweep(problem, tolerance, size) for size in heyoka_batch.SIZES])


def fastest(runs: Sequence[Callable[[], BenchAnswer]]) -> Callable[[], BenchAnswer]:
    """Return the function that takes the least CPU time."""

    def seconds(run: Callable[[], BenchAnswer]) -> float:
        start = time.process_time()
        run()
        return time.process_time() - start

    return min(runs, key=lambda run: min(seconds(run) for _ in range(2)))


def _heyoka(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Take the loop written by hand where there is one: there a callback of half a microsecond counts."""
    if problem.speeds:
        return heyoka_by_hand.prepare_sweep(problem, tolerance)
    return heyoka_by_hand.prepare(problem, tolerance) if problem.oscillator else heyoka_peer.prepare(problem, tolerance)


_EXACT_LAW = ("P1", "P2", "P3")
_CONTINUOUS = ("P4", "P9")
_MANY = ("P6", "P7", "P8")
_STICKING = (*_EXACT_LAW, *_MANY)
_ALL = (*_EXACT_LAW, *_CONTINUOUS, "P5", *_MANY)
_MODELICA = ("P11", "P12", "P13")
_FINE = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
_HARMONIC = tuple(pyharm_peer.HARMONICS)
_SHOOTING = shooting_by_hand.WORKAROUNDS
_SLOW = (1e-6, 1e-8, 1e-10, 1e-12)


def peers() -> dict[str, Peer]:
    """Return every solver by name, installed or not."""
    scipy, casadi = scipy_peer.WORKAROUNDS, casadi_peer.WORKAROUNDS
    every = [
        Peer("symfric", _prepare_default, (*_ALL, "P10", *_MODELICA, "P14", "P15", "P16"), _FINE, own=True),
        Peer("symfric taylor", _prepare_series, ("P1", *_MANY), _FINE, own=True),
        Peer("symfric one by one", _one_by_one, ("P5",), _FINE, own=True),
        Peer("symfric integrators", _prepare_integrators, (*_STICKING, *_CONTINUOUS), _SLOW, own=True),
        Peer("heyoka", _heyoka, _ALL, _FINE, heyoka_by_hand.WORKAROUNDS, ("heyoka",)),
        Peer("heyoka batch", _heyoka_together, ("P5",), _FINE, heyoka_batch.WORKAROUNDS, ("heyoka",)),
        Peer("scipy DOP853", scipy_peer.prepare_events, (*_STICKING, "P5", "P9"), _SLOW, scipy),
        Peer("scipy LSODA", scipy_peer.prepare_stiff, _CONTINUOUS, _SLOW),
        Peer("scipy LSODA, plane", regularised_plane.prepare, ("P14",), _SLOW, regularised_plane.WORKAROUNDS),
        Peer("scipy DOP853, impacts", impacts_by_hand.prepare_scipy, ("P15",), _SLOW, impacts_by_hand.WORKAROUNDS),
        Peer(
            "heyoka, impacts", impacts_by_hand.prepare_heyoka, ("P15",), _FINE, impacts_by_hand.WORKAROUNDS, ("heyoka",)
        ),
        Peer("heyoka, response", shooting_by_hand.prepare_response, ("P10",), _FINE, _SHOOTING, ("heyoka",)),
        Peer("heyoka, branch", shooting_by_hand.prepare_branch, ("P16",), _FINE, _SHOOTING, ("heyoka",)),
        Peer("casadi erk", casadi_peer.prepare_interpreted, (*_STICKING, "P9"), _SLOW, casadi),
        Peer("casadi erk, C", casadi_peer.prepare_compiled, (*_STICKING, "P9"), _FINE, casadi, ("cc",)),
        Peer("casadi cvodes", casadi_peer.prepare_stiff, ("P4",), _SLOW),
        Peer("sundae CVODE", sundae_peer.prepare, (*_STICKING, "P9"), _SLOW, sundae_peer.WORKAROUNDS, ("sksundae",)),
        Peer("diffrax Tsit5", diffrax_peer.prepare, (*_EXACT_LAW, "P8"), _SLOW, diffrax_peer.WORKAROUNDS, ("diffrax",)),
        Peer("pyHarm", pyharm_peer.prepare, ("P10",), _HARMONIC, pyharm_peer.WORKAROUNDS, ("pyHarm",)),
    ]
    return {p.name: p for p in every}
