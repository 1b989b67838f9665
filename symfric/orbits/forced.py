"""The forced periodic motion of a mass that slips all the time, and the belt speeds at which it loses its peace.

Under fast excitation the quiet motion is a small periodic orbit in pure slip. It is the fixed point of the map over one
period of the excitation. With rising belt speed two things end its life or begin it: below, the mass reaches the speed
of the belt (grazing); above, the divergence of the flow averages to zero, so that the product of the two Floquet
multipliers is one (a Neimark-Sacker point). Between them the mass vibrates by itself: Thomsen, figure 9.
"""

from dataclasses import dataclass

import numpy as np
import sympy as sp
from scipy.optimize import brentq

from symfric.errors import NotFound, SceneError
from symfric.model.names import SPEED
from symfric.model.outputs import End, Integral, Max
from symfric.model.scene import Scene
from symfric.solve.choose import Program, prepare

_STEP = 1e-6  # of the differences for Newton's method; they cost convergence, not accuracy


@dataclass(frozen=True)
class ForcedOrbit:
    """A periodic motion over one period of the excitation.

    Attributes
    ----------
    start : ndarray, shape (n_x,)
        State at t = 0.
    gap : float
        Smallest sliding speed on the orbit; zero at grazing, negative if the mass sticks to the belt or overtakes it.
    decay : float
        Minus the logarithm of the determinant of the monodromy matrix over the period: negative if areas grow.
    """

    start: np.ndarray
    gap: float
    decay: float


@dataclass(frozen=True)
class SelfExcitation:
    """Belt speeds between which the forced motion gives way to self-excited vibration.

    Attributes
    ----------
    lower : float
        Grazing: below it the excitation carries the mass to the speed of the belt in every period.
    upper : float
        Neimark-Sacker point: above it steady sliding is stable.
    """

    lower: float
    upper: float

    def to_dict(self) -> dict[str, float]:
        """Return plain numbers."""
        return {"lower": self.lower, "upper": self.upper}


def forced_program(scene: Scene, speed: str = "v_b", frequency: str = "Omega", tolerance: float = 1e-13) -> Program:
    """Prepare one period of a scene with one coordinate and one contact for `forced_orbit`.

    Raises
    ------
    SceneError
        If the scene has more coordinates or contacts, or first-order states.
    """
    if len(scene.system.q) != 1 or len(scene.contacts) != 1 or scene.system.z:
        raise SceneError("the forced orbit takes one coordinate and one contact")
    (contact,), (u,) = scene.contacts, scene.system.u
    sliding = -contact.slip * sp.sign(scene.values[scene.parameter(speed)])
    friction = contact.normal * contact.profile * contact.law.kinetic.diff(SPEED).subs(SPEED, sliding)
    divergence = (scene.system.force[0].diff(u) - friction) / scene.system.mass[0]
    period = 2 * np.pi / scene.values[scene.parameter(frequency)]
    outputs = {"end": End(), "approach": Max(-sliding), "divergence": Integral(divergence)}
    return prepare(scene.until(period).wanting(outputs), tolerance)


def forced_orbit(program: Program, values: dict[str, float], guess: np.ndarray) -> ForcedOrbit:
    """Find the fixed point of the map over one period by Newton's method; unstable orbits too.

    Parameters
    ----------
    program : Program
        From `forced_program`.
    values : dict
        Changes of the scene's values.
    guess : ndarray, shape (2,)

    Raises
    ------
    NotFound
        If Newton's method does not converge.
    """
    names = [s.name for s in program.scene.system.states]
    flow = lambda y: program.run(values=values, initial=dict(zip(names, y, strict=True)))  # noqa: E731
    y = np.array(guess, dtype=float)
    for _ in range(30):
        run = flow(y)
        columns = [(flow(y + d).final - flow(y - d).final) / (2 * _STEP) for d in _STEP * np.eye(2)]
        step = np.linalg.solve(np.column_stack(columns) - np.eye(2), run.final - y)
        y = y - step
        if np.max(np.abs(step)) < 1e-12:
            run = flow(y)
            gap = -run["approach"] if run.stats["events"] == 0 else min(-run["approach"], -_STEP)
            return ForcedOrbit(y, gap, -run["divergence"])
    raise NotFound("no periodic motion near the guess: Newton's method on the map over one period does not converge")


def self_excitation(scene: Scene, bracket: tuple[float, float], speed: str = "v_b") -> SelfExcitation:
    """Return the belt speeds at which self-excited vibration begins and ends under fast excitation.

    Parameters
    ----------
    scene : Scene
        One mass on a belt with harmonic excitation of frequency Omega, such as ``scenes.mass_on_belt``.
    bracket : (float, float)
        Belt speeds that enclose both bounds.
    speed : str
        Name of the belt speed.

    Raises
    ------
    NotFound
        If there is no such range within the bracket: the excitation quenches the vibration at all its speeds.

    Notes
    -----
    Full model, no averaging. For the cubic law the upper bound is where ``v_b^2 + <x'^2> = v_b1^2`` on the orbit.
    """
    program = forced_program(scene, speed)
    guess = {"y": None}

    def orbit(v: float) -> ForcedOrbit:
        start = guess["y"] if guess["y"] is not None else _first_guess(scene, speed, v)
        found = forced_orbit(program, {speed: v}, start)
        guess["y"] = found.start
        return found

    low, high = bracket
    speeds = np.linspace(high, low, 25)
    orbits = [orbit(v) for v in speeds]
    grazing = next((k for k, o in enumerate(orbits) if o.gap < 0), None)
    growing = next((k for k, o in enumerate(orbits) if o.decay < 0), None)
    if growing is None or (grazing is not None and growing >= grazing):
        raise NotFound(f"no self-excited vibration between {speed} = {low:g} and {high:g}: the excitation quenches it")
    if growing == 0:
        raise NotFound(f"the motion is still self-excited at {speed} = {high:g}; raise the upper end of the bracket")
    if grazing is None:
        raise NotFound(f"the orbit does not graze above {speed} = {low:g}; lower the lower end of the bracket")
    guess["y"] = orbits[growing].start
    upper = brentq(lambda v: orbit(v).decay, speeds[growing], speeds[growing - 1], xtol=1e-13, rtol=1e-13)
    guess["y"] = orbits[grazing - 1].start
    lower = brentq(lambda v: orbit(v).gap, speeds[grazing], speeds[grazing - 1], xtol=1e-13, rtol=1e-13)
    return SelfExcitation(lower, upper)


def _first_guess(scene: Scene, speed: str, v: float) -> np.ndarray:
    """Return the quasi-equilibrium, with the fast velocity at t = 0 from integrating the excitation."""
    from symfric.theory import equilibrium, separate

    scene = scene.where({speed: v})
    slow = separate(scene)
    shift = slow.numbers()[slow.system.u[0]] - scene.numbers()[scene.system.u[0]]
    return np.array([equilibrium(slow).x[0], -shift])
