"""Types of what `symfric` offers; see ``__init__.py``."""

from symfric import design, motions, theory
from symfric.ensemble.attractors import Attractor
from symfric.ensemble.basins import Basins, basins
from symfric.ensemble.bifurcation_diagram import BifurcationDiagram, bifurcation_diagram
from symfric.ensemble.sweep import sweep
from symfric.errors import NoRoute, NotFound, RunFailed, SceneError
from symfric.model import laws, mechanics, scenes
from symfric.model.laws import Law
from symfric.model.outputs import (
    At,
    End,
    Events,
    HalfRange,
    Integral,
    Max,
    Min,
    StopTime,
    Trajectory,
    friction_force,
    slip,
)
from symfric.model.scene import Scene
from symfric.model.scenes.isolator import patched_floor
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import Contact, Signal, System
from symfric.orbits.continuation.branch import Branch, Special, continue_cycle
from symfric.orbits.continuation.codim1 import Curve, continue_special
from symfric.orbits.cycle import Orbit, limit_cycle
from symfric.orbits.lyapunov import Lyapunov, lyapunov
from symfric.orbits.poincare import PoincareSection, poincare
from symfric.solve.casadi_function import as_function
from symfric.solve.exact.route import Exact
from symfric.solve.integrators.route import Integrators
from symfric.solve.routes import Explanation, explain, prepare, simulate
from symfric.solve.run import Event, Run
from symfric.solve.status import Status
from symfric.solve.taylor.route import Taylor
from symfric.theory import (
    Equilibrium,
    HopfPoint,
    SlowFlow,
    Stability,
    average,
    equilibrium,
    hopf,
    separate,
    stability,
)

__version__: str

__all__ = [
    "SPEED",
    "TIME",
    "At",
    "Attractor",
    "Basins",
    "BifurcationDiagram",
    "Branch",
    "Contact",
    "Curve",
    "End",
    "Equilibrium",
    "Event",
    "Events",
    "Exact",
    "Explanation",
    "HalfRange",
    "HopfPoint",
    "Integral",
    "Integrators",
    "Law",
    "Lyapunov",
    "Max",
    "Min",
    "NoRoute",
    "NotFound",
    "Orbit",
    "PoincareSection",
    "Run",
    "RunFailed",
    "Scene",
    "SceneError",
    "Signal",
    "SlowFlow",
    "Special",
    "Stability",
    "Status",
    "StopTime",
    "System",
    "Taylor",
    "Trajectory",
    "as_function",
    "average",
    "basins",
    "bifurcation_diagram",
    "continue_cycle",
    "continue_special",
    "design",
    "equilibrium",
    "explain",
    "friction_force",
    "hopf",
    "laws",
    "limit_cycle",
    "lyapunov",
    "mechanics",
    "motions",
    "patched_floor",
    "poincare",
    "prepare",
    "scenes",
    "separate",
    "simulate",
    "slip",
    "stability",
    "sweep",
    "theory",
]
