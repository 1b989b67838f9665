"""What `symfric` offers: the one list of its names, for Python and for type checkers; see ``__init__.py``.

In stubs only names imported ``as`` themselves are public.
"""

from . import design as design, export as export, motions as motions, structures as structures, theory as theory
from .ensemble.attractors import Attractor as Attractor
from .ensemble.basins import Basins as Basins, basins as basins
from .ensemble.bifurcation_diagram import (
    BifurcationDiagram as BifurcationDiagram,
    bifurcation_diagram as bifurcation_diagram,
)
from .ensemble.exceedance import plot_probability as plot_probability
from .ensemble.sampling import CaseTable as CaseTable, draw as draw
from .ensemble.statistics import probability as probability, spread as spread
from .ensemble.sweep import sweep as sweep
from .errors import NoRoute as NoRoute, NotFound as NotFound, RunFailed as RunFailed, SceneError as SceneError
from .identification.comparison import Comparison as Comparison, compare_laws as compare_laws
from .identification.curves import fit_curve as fit_curve
from .identification.decay import fit_decay as fit_decay
from .identification.experiments import TestDesign as TestDesign, test_design as test_design
from .identification.fit import Fit as Fit
from .identification.identify import identify as identify
from .identification.loops import fit_loop as fit_loop
from .identification.profile import Profile as Profile
from .long_calls import keep_when_interrupted as keep_when_interrupted, show_progress as show_progress
from .model import control as control, laws as laws, mechanics as mechanics, scenes as scenes
from .model.held import Held as Held
from .model.laws import Law as Law
from .model.outputs.extremes import (
    HalfRange as HalfRange,
    Max as Max,
    Min as Min,
)
from .model.outputs.integrals import Integral as Integral, Mean as Mean, RMS as RMS
from .model.outputs.of_contacts import (
    dissipated_power as dissipated_power,
    friction_force as friction_force,
    normal_force as normal_force,
    slip as slip,
    stored_energy as stored_energy,
)
from .model.outputs.records import Events as Events, Trajectory as Trajectory
from .model.outputs.times import Period as Period, StopTime as StopTime
from .model.outputs.values import At as At, End as End, Samples as Samples
from .model.resets import Reset as Reset
from .model.scene import Scene as Scene
from .model.scenes.isolator import patched_floor as patched_floor
from .model.symbols import SPEED as SPEED, TIME as TIME
from .model.stops import stops as stops
from .model.system import Contact as Contact, Signal as Signal, System as System
from .model.unilateral import Unilateral as Unilateral
from .orbits.continuation.branch import Branch as Branch, Special as Special, continue_cycle as continue_cycle
from .orbits.continuation.codim1 import Curve as Curve, continue_special as continue_special
from .orbits.cycle import Orbit as Orbit, limit_cycle as limit_cycle
from .orbits.frequency_response import frequency_response as frequency_response
from .orbits.lyapunov import Lyapunov as Lyapunov, lyapunov as lyapunov
from .orbits.poincare import PoincareSection as PoincareSection, poincare as poincare
from .report.explorer.live import Exploration as Exploration, explore as explore
from .scenefile.read import read as read
from .solve.batch import Batch as Batch
from .solve.casadi_function import as_function as as_function
from .solve.exact.route import Exact as Exact
from .solve.integrators.route import Integrators as Integrators
from .solve.routes import Explanation as Explanation, explain as explain, prepare as prepare, simulate as simulate
from .solve.run import Event as Event, Run as Run
from .solve.status import Status as Status
from .solve.taylor.route import Taylor as Taylor
from .theory import (
    Equilibrium as Equilibrium,
    HopfPoint as HopfPoint,
    SlowFlow as SlowFlow,
    Stability as Stability,
    average as average,
    equilibrium as equilibrium,
    hopf as hopf,
    separate as separate,
    stability as stability,
)

__version__: str
