"""Find a periodic orbit: follow the motion until it repeats itself, or begin at a guess; then Newton's method."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged, tell
from symfric.model.scene import Scene, check_scene
from symfric.orbits.cycle.orbit import Orbit
from symfric.orbits.cycle.properties import orbit_of
from symfric.orbits.flow_map import FlowMap, flow_of
from symfric.orbits.guess import EndsEarly, Fades, Grows, Guess, Waits, settled
from symfric.orbits.shooting import Point, ShootingSystem, solve
from symfric.orbits.sizes import UNMOVED, filled

_VANISHED = 1e-6  # range relative to that of the guess below which Newton's method has found an equilibrium
_FAR = 1e6  # distance from a guess, in its sizes and ranges, beyond which an orbit has nothing to do with it
_SAME = 1e-8  # least difference relative to the ranges of the states up to which motions count as one
_ACCURATE = 100.0  # the same in gaps to which an orbit is closed
_FINE = 1e-9  # tolerance of the motion at which orbits of a whole and of a part of a period are told apart
_PATIENCE = (1, 4, 16, 64)  # horizons of the scene for settling, tried in turn; near a fold settling is slow


@logged
def limit_cycle(
    scene: Scene, guess: Orbit | tuple[Sequence[float] | np.ndarray, float] | None = None, tolerance: float = 1e-13
) -> Orbit:
    """Find a periodic orbit of a scene by Newton's method on the map over a period (shooting).

    Parameters
    ----------
    scene : Scene
        Autonomous, or excited by sines and cosines of time, or sampled by clocks, with a common period. Its start and
        horizon matter only without a guess: then its motion is followed until it repeats itself, and leads to a stable
        cycle. Where it settles to no cycle, as on a torus or in chaos, the result is one near the motion, with
        ``stable`` False. Rest for good under an excitation or a clock is a cycle of their period, with
        ``stick_fraction`` 1.
    guess : Orbit, or (state, period), optional
        An approximation of the cycle, which may be unstable. If forced, the state is that at t = 0, and the period is
        rounded to a multiple of that of the excitation.
    tolerance : float
        Of the motion.

    Returns
    -------
    Orbit

    Raises
    ------
    NotFound
        If the motion of an autonomous scene settles to rest or steady sliding, a motion ends early, or no cycle is
        found near the guess.
    SceneError
        If the excitation has no period, or an input is sampled.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> orbit = sf.limit_cycle(belt)
    >>> round(orbit.period, 6)
    6.799421
    >>> orbit.stable
    True
    """
    check_scene(scene)
    return found_cycle(scene, flow_of(scene, (), tolerance), guess)


def found_cycle(
    scene: Scene, flow: FlowMap, guess: Orbit | tuple[Sequence[float] | np.ndarray, float] | None = None
) -> Orbit:
    """Return the result of `limit_cycle` from a flow map of the scene, which may have one parameter."""
    values = values_of(scene)
    if guess is not None:
        return orbit_at(scene, flow, values, guess)
    forcing = flow.period(values) if flow.period else None
    reason, waits, settling, unstable = "", "", False, None
    for patience in _PATIENCE:
        settling = False
        try:
            tell("following the motion until it repeats itself")
            attained = settled(scene, flow, forcing, patience)
            settling = attained.shrinking
            tell("Newton's method")
            orbit = _near(scene, flow, values, attained)
        except Fades:
            raise
        except Grows as failure:
            reason = str(failure)
            break
        except EndsEarly as failure:
            reason = reason or str(failure)  # what a shorter run has told says more
            break
        except Waits as failure:
            waits = str(failure)
            continue
        except NotFound as failure:
            reason = str(failure)
            continue
        if orbit.stable:
            return orbit
        unstable = orbit  # the motion is still near it, or goes around it
    if unstable is not None:
        return unstable
    if settling:
        raise Fades("the motion still shrinks after the longest wait and settles to no cycle")
    raise NotFound(waits or reason)


def values_of(scene: Scene) -> dict[str, float]:
    """Return the values of a scene by name; raise if one is missing."""
    return {s.name: v for s, v in scene.parameter_values().items()}


def read_guess(guess: Any, flow: FlowMap, forcing: float | None) -> Guess:
    """Return a user's guess as state, period, and multiple of the excitation's period."""
    if isinstance(guess, Orbit):
        state, period = guess.start, guess.period
    else:
        try:
            state, period = guess
            state, period = np.array(state, dtype=float), float(period)
        except (TypeError, ValueError):
            raise SceneError("guess is neither an Orbit nor a pair (state, period)") from None
    if state.shape != (len(flow.states),):
        raise SceneError(f"the state of the guess has shape {state.shape}; the scene has {len(flow.states)} states")
    if not period > 0:
        raise SceneError(f"the period of the guess is {period}; it must be positive")
    multiple = max(1, round(period / forcing)) if forcing else 0
    return Guess(state, period, multiple, max(1, multiple))


def orbit_at(
    scene: Scene, flow: FlowMap, values: dict[str, float], guess: Orbit | tuple[Sequence[float] | np.ndarray, float]
) -> Orbit:
    """Return the orbit near a guess at given values, with a flow map that may have one parameter.

    Raises
    ------
    NotFound
        If no orbit is found near the guess.
    """
    return _near(scene, flow, values, read_guess(guess, flow, flow.period(values) if flow.period else None))


def _near(scene: Scene, flow: FlowMap, values: dict[str, float], guess: Guess) -> Orbit:
    system = ShootingSystem(flow, values, guess.multiple, widths=(1.0,) * len(flow.parameters))  # one may be zero
    z = system.pack(guess.start, guess.period, values)
    first = system.at(z, None, guess.start)
    closed = solve(system, z, _held(system, z), first=first)
    size = first.passage.ranges + np.abs(guess.start)
    if np.any(np.abs(system.unpack(closed.z)[0] - guess.start)[size > 0] > _FAR * size[size > 0]):
        raise NotFound("no limit cycle near the guess: Newton's method leads away from it beyond any bound")
    if system.free and np.all(closed.passage.ranges <= _VANISHED * first.passage.ranges):
        raise NotFound("no limit cycle near the guess: Newton's method leads to steady sliding")
    return orbit_of(scene, *_shortest(system, closed, guess.turns))


def _shortest(system: ShootingSystem, point: Point, turns: int) -> tuple[ShootingSystem, Point]:
    """Return the orbit with its least period."""
    start, period, values = system.unpack(point.z)
    for parts in (k for k in range(turns, 1, -1) if turns % k == 0):
        if _repeats(system, point, parts):
            least = replace(system, multiple=system.multiple // parts)
            z = least.pack(start, period / parts, values)
            return least, solve(least, z, _held(least, z))
    return system, point


def _repeats(system: ShootingSystem, point: Point, parts: int) -> bool:
    """Whether an orbit comes back after a part of its period, up to the accuracy to which it is known.

    Its start is known less well than the motion, the less the closer a multiplier is to 1: where a coarse motion comes
    nearly back, the orbit is computed anew on a finer one. A state that moves by rounding alone does not count.
    """
    start, period, values = system.unpack(point.z)
    flow = system.flow
    ranges = filled(np.maximum(point.passage.ranges, UNMOVED * np.abs(start)), len(flow.scene.system.q))
    away = float(np.max(np.abs(flow.run(start, values, period / parts).end - start) / ranges))
    if away > np.sqrt(flow.tolerance) or flow.tolerance <= _FINE:
        return away <= max(_SAME, _ACCURATE * flow.closed)
    finer = replace(system, flow=flow_of(flow.scene, flow.parameters, _FINE))
    try:
        return _repeats(finer, solve(finer, point.z, _held(finer, point.z)), parts)
    except NotFound:
        return False


def _held(system: ShootingSystem, z: np.ndarray) -> np.ndarray | None:
    """Return the direction of the parameter among the unknowns, which Newton's method holds; None without one."""
    return np.append(np.zeros(z.size - 1), 1.0) if system.flow.parameters else None
