"""What `symfric` offers: the one list of its names, for Python and for type checkers; see ``__init__.py``."""

from . import design, export, motions, structures, theory
from .ensemble.attractors import Attractor
from .ensemble.basins import Basins, basins
from .ensemble.bifurcation_diagram import BifurcationDiagram, bifurcation_diagram
from .ensemble.sampling import CaseTable, draw
from .ensemble.statistics import probability, spread
from .ensemble.sweep import sweep
from .errors import NoRoute, NotFound, RunFailed, SceneError
from .identification.comparison import Comparison, compare_laws
from .identification.curves import fit_curve
from .identification.decay import fit_decay
from .identification.experiments import TestDesign, test_design
from .identification.fit import Fit
from .identification.identify import identify
from .identification.loops import fit_loop
from .identification.profile import Profile
from .model import laws, mechanics, scenes
from .model.laws import Law
from .model.outputs import (
    At,
    End,
    Events,
    HalfRange,
    Integral,
    Max,
    Min,
    Samples,
    StopTime,
    Trajectory,
    dissipated_power,
    friction_force,
    slip,
    stored_energy,
)
from .model.scene import Scene
from .model.scenes.isolator import patched_floor
from .model.symbols import SPEED, TIME
from .model.system import Contact, Signal, System
from .orbits.continuation.branch import Branch, Special, continue_cycle
from .orbits.continuation.codim1 import Curve, continue_special
from .orbits.cycle import Orbit, limit_cycle
from .orbits.frequency_response import frequency_response
from .orbits.lyapunov import Lyapunov, lyapunov
from .orbits.poincare import PoincareSection, poincare
from .scenefile.read import read
from .solve.batch import Batch
from .solve.casadi_function import as_function
from .solve.exact.route import Exact
from .solve.integrators.route import Integrators
from .solve.routes import Explanation, explain, prepare, simulate
from .solve.run import Event, Run
from .solve.status import Status
from .solve.taylor.route import Taylor
from .theory import (
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
    "Batch",
    "BifurcationDiagram",
    "Branch",
    "CaseTable",
    "Comparison",
    "Contact",
    "Curve",
    "End",
    "Equilibrium",
    "Event",
    "Events",
    "Exact",
    "Explanation",
    "Fit",
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
    "Profile",
    "Run",
    "RunFailed",
    "Samples",
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
    "TestDesign",
    "Trajectory",
    "as_function",
    "average",
    "basins",
    "bifurcation_diagram",
    "compare_laws",
    "continue_cycle",
    "continue_special",
    "design",
    "dissipated_power",
    "draw",
    "equilibrium",
    "explain",
    "export",
    "fit_curve",
    "fit_decay",
    "fit_loop",
    "frequency_response",
    "friction_force",
    "hopf",
    "identify",
    "laws",
    "limit_cycle",
    "lyapunov",
    "mechanics",
    "motions",
    "patched_floor",
    "poincare",
    "prepare",
    "probability",
    "read",
    "scenes",
    "separate",
    "simulate",
    "slip",
    "spread",
    "stability",
    "stored_energy",
    "structures",
    "sweep",
    "test_design",
    "theory",
]
