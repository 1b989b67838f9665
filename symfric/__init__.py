"""Vibration caused and damped by dry friction: symbolic derivation, exact stick-slip simulation, optimal design.

What stands here is loaded when it is asked for, so that a simulation does not wait for the design and the orbits.
``__init__.pyi`` says the same to type checkers.
"""

from importlib import import_module

__version__ = "0.1.0"

_MODULES = {
    "design": "symfric.design",
    "laws": "symfric.model.laws",
    "mechanics": "symfric.model.mechanics",
    "motions": "symfric.motions",
    "scenes": "symfric.model.scenes",
    "theory": "symfric.theory",
}
_NAMES = {
    "symfric.ensemble.attractors": "Attractor",
    "symfric.ensemble.basins": "Basins basins",
    "symfric.ensemble.bifurcation_diagram": "BifurcationDiagram bifurcation_diagram",
    "symfric.ensemble.sweep": "sweep",
    "symfric.errors": "NoRoute NotFound RunFailed SceneError",
    "symfric.model.laws": "Law",
    "symfric.model.scenes.isolator": "patched_floor",
    "symfric.model.symbols": "SPEED TIME",
    "symfric.model.outputs": "At End Events HalfRange Integral Max Min Samples StopTime Trajectory friction_force slip",
    "symfric.model.scene": "Scene",
    "symfric.model.system": "Contact Signal System",
    "symfric.orbits.continuation.branch": "Branch Special continue_cycle",
    "symfric.orbits.continuation.codim1": "Curve continue_special",
    "symfric.orbits.cycle": "Orbit limit_cycle",
    "symfric.orbits.lyapunov": "Lyapunov lyapunov",
    "symfric.orbits.poincare": "PoincareSection poincare",
    "symfric.solve.routes": "Explanation explain prepare simulate",
    "symfric.solve.exact.route": "Exact",
    "symfric.solve.casadi_function": "as_function",
    "symfric.solve.integrators.route": "Integrators",
    "symfric.solve.run": "Event Run",
    "symfric.solve.status": "Status",
    "symfric.solve.taylor.route": "Taylor",
    "symfric.theory": "Equilibrium HopfPoint SlowFlow Stability average equilibrium hopf separate stability",
}
_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}

__all__ = sorted([*_MODULES, *_HOME])


def __getattr__(name: str):
    if name in _MODULES:
        value = import_module(_MODULES[name])
    elif name in _HOME:
        value = getattr(import_module(_HOME[name]), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
