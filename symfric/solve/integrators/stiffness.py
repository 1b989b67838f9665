"""How stiff the laws with memory of a scene are: what explicit steps over its horizon would cost."""

import math

import casadi as ca
import numpy as np

from symfric.errors import SceneError
from symfric.lower.automaton import arguments_of
from symfric.solve.input_segments import segments
from symfric.solve.integrators.mode_functions import mode_integrator, signs_evaluated
from symfric.solve.integrators.refusals import declines
from symfric.solve.integrators.sizes import first_sizes, make_sizing
from symfric.solve.lowered import LoweredScene

MANY = 3e5  # explicit steps above which an implicit integrator is faster
MANY_WITH_DERIVATIVES = 1e5  # the same with derivatives, which make an explicit step several times as expensive
_PER_STEP = 18.0  # largest |rate of decay| times step of a Taylor series of order 17, measured
_NODES, _COARSE, _MOST = 400, 1e-7, 20_000  # of a rough motion: nodes, tolerance, steps
_DECAYS = 10.0  # a decay is stiff if its rate is so many times the frequencies


def explicit_steps(scene: LoweredScene) -> float:
    """Return about how many explicit steps the fast decays of a scene would take over its horizon; 0 if none is fast.

    Only scenes with a law with memory are looked at, and no others that can stick: a rough motion by an implicit
    integrator shows the rates of decay along it, which the law alone does not.
    """
    return scene.once(_explicit_steps)


def pays(scene: LoweredScene) -> bool:
    """Whether derivatives cost less by an implicit integrator, which takes about as many steps with them as without."""
    if explicit_steps(scene) <= MANY_WITH_DERIVATIVES:
        return False
    return not declines(scene.automaton, "cvodes", scene.scene, derivatives=True)


def _explicit_steps(scene: LoweredScene) -> float:
    automaton = scene.automaton
    laws = [c for c in scene.scene.contacts if c.law.memory and c.along_line]
    if any(c.law.memory.slowest is not None for c in laws if c.law.memory):
        return math.inf
    if not laws or any(automaton.sticks) or automaton.layout.others or None in scene.scene.values.values():
        return 0.0
    try:
        numbers = scene.scene.numbers()
    except SceneError:
        return 0.0
    field, horizon = signs_evaluated(automaton), scene.scene.horizon
    y = np.array([numbers[s] for s in scene.scene.system.states])
    _, inputs = segments([scene.scene.inputs[s] for s in automaton.inputs], horizon)
    p = np.concatenate([[numbers[s] for s in automaton.parameters], inputs[0]])
    m = np.ones(automaton.layout.n_mode)
    m[automaton.layout.sticking] = 0.0
    slopes = _slopes(field)
    size = first_sizes(make_sizing(automaton, field, 0, horizon), y, 0.0, p, m)
    motion = mode_integrator(field, 0, "cvodes", math.inf, _COARSE, horizon, 0, _NODES, _MOST)
    try:
        states = np.array(motion(x0=y / size, p=np.concatenate([p, m, size, [0.0, horizon]]))["xf"]) * size[:, None]
    except RuntimeError:
        return 0.0
    times = np.linspace(0.0, horizon, _NODES + 1)[1:]
    rates = [_decay(np.array(slopes(states[:, k], t, p, m))) for k, t in enumerate(times)]
    return float(np.mean(rates)) * horizon / _PER_STEP


def _slopes(field: ca.Function) -> ca.Function:
    y, t, p, m = arguments_of(field)
    return ca.Function("slopes", [y, t, p, m], [ca.densify(ca.jacobian(field(y, t, p, m)[0], y))])


def _decay(slopes: np.ndarray) -> float:
    """Return the fastest decay, if it is far faster than every vibration."""
    if not np.all(np.isfinite(slopes)):
        return 0.0
    values = np.linalg.eigvals(slopes)
    # a vibration needs its steps by any method; only decays that explicit ones must follow without need are stiff
    fastest = float(np.max(-values.real))
    return fastest if fastest > _DECAYS * np.max(np.abs(values.imag)) else 0.0
