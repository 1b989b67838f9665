"""The solvers of the benchmark: the package's own routes, and those of other packages where they are installed."""

import importlib.util
import shutil
from collections.abc import Callable
from dataclasses import dataclass

from symfric.bench import casadi_erk, heyoka_loop, scipy_loop
from symfric.bench.problems import Problem
from symfric.bench.result import Answer
from symfric.solve.choose import prepare
from symfric.solve.one_mode import Integrators


@dataclass(frozen=True)
class Peer:
    """A solver that can be prepared for a problem.

    Attributes
    ----------
    name : str
    prepare : callable
        ``prepare(problem, tolerance) -> run``; ``run() -> Answer``. Everything that is done once is done by `prepare`.
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
    prepare: Callable[[Problem, float], Callable[[], Answer]]
    problems: tuple[str, ...]
    tolerances: tuple[float, ...]
    workarounds: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    own: bool = False

    @property
    def missing(self) -> tuple[str, ...]:
        """What it needs and is not there."""
        return tuple(need for need in self.needs if not _present(need))


def _present(need: str) -> bool:
    return bool(shutil.which("cc")) if need == "cc" else importlib.util.find_spec(need) is not None


def _prepare_default(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Prepare the route that the package chooses."""
    return _through_program(problem, tolerance, None)


def _prepare_integrators(problem: Problem, tolerance: float) -> Callable[[], Answer]:
    """Prepare the route `integrators`: erk on the law with its jump, cvodes on the continuous one."""
    return _through_program(problem, tolerance, Integrators("cvodes" if problem.oscillator.v_s else "erk"))


def _through_program(problem: Problem, tolerance: float, route: Integrators | None) -> Callable[[], Answer]:
    program = prepare(problem.scene, tolerance=tolerance, route=route)
    n_q = len(problem.scene.system.q)

    def run() -> Answer:
        result = program.run()
        return Answer((float(result.final[0]), float(result.final[n_q])), int(result.stats["events"]))

    return run


_EXACT_LAW = ("P1", "P2", "P3")
_FINE = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
_SLOW = (1e-6, 1e-8, 1e-10, 1e-12)


def peers() -> dict[str, Peer]:
    """Return every solver by name, installed or not."""
    every = [
        Peer("symfric", _prepare_default, (*_EXACT_LAW, "P4"), _FINE, own=True),
        Peer("symfric integrators", _prepare_integrators, (*_EXACT_LAW, "P4"), _SLOW, own=True),
        Peer("heyoka", heyoka_loop.prepare, (*_EXACT_LAW, "P4"), _FINE, heyoka_loop.WORKAROUNDS, ("heyoka",)),
        Peer("scipy DOP853", scipy_loop.prepare_events, _EXACT_LAW, _SLOW, scipy_loop.WORKAROUNDS),
        Peer("scipy LSODA", scipy_loop.prepare_stiff, ("P4",), _SLOW),
        Peer("casadi erk", casadi_erk.prepare_interpreted, _EXACT_LAW, _SLOW, casadi_erk.WORKAROUNDS),
        Peer("casadi erk, C", casadi_erk.prepare_compiled, _EXACT_LAW, _FINE, casadi_erk.WORKAROUNDS, ("cc",)),
        Peer("casadi cvodes", casadi_erk.prepare_stiff, ("P4",), _SLOW),
    ]
    return {p.name: p for p in every}
