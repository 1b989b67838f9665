"""From the onset of vibration to its amplitude: Hopf point, its branch of limit cycles, and where contacts lift off."""

from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged
from symfric.model.outputs import Min
from symfric.model.scene import Scene
from symfric.model.symbols import Key
from symfric.orbits.continuation.branch import Branch, continue_cycle
from symfric.orbits.cycle import Orbit, limit_cycle
from symfric.search import zero
from symfric.solve.protocol import Program
from symfric.solve.routes import prepare
from symfric.solve.run import finished
from symfric.theory.hopf import HopfPoint, hopf

_CLOSE = 1e-9  # relative error of the value at which a contact lifts off
_TOLERANCE = 1e-11


@dataclass(frozen=True, eq=False)
class LiftOff:
    """The first limit cycle of a branch on which a load touches zero.

    Attributes
    ----------
    contact : str
    value : float
        Of the parameter.
    orbit : Orbit

    Examples
    --------
    >>> import sympy as sp, symfric as sf
    >>> mu = sp.Symbol("mu", positive=True)
    >>> s = sf.structures.Structure([[1, 0], [0, 1]], [[1.05, 0.2], [0.2, 0]], [[0.02, 0], [0, 0.02]], names=["x", "y"])
    >>> load = sf.structures.RowLoad(1.0, {"y": 1.0}, push={"y": -1.0})
    >>> law = sf.laws.custom(mu * (1 - 0.2 * sp.exp(-sf.SPEED)), mu)
    >>> belt = sf.structures.RowContact("belt", {"x": 1.0}, load, law, speed=1.0)
    >>> found = sf.structures.onset(s.scene([belt], values={mu: 0.3}), "mu", (0.1, 0.4), span=(0.2, 0.224))
    >>> (first,) = found.lift_off
    >>> first.contact, round(first.value, 6), round(float(first.orbit.x_min[1]), 4)
    ('belt', 0.222984, -1.0)
    """

    contact: str
    value: float
    orbit: Orbit


@dataclass(frozen=True, eq=False)
class Onset:
    """Onset of vibration and what grows from it.

    Attributes
    ----------
    hopf : HopfPoint
        Its coefficient tells how the amplitude begins.
    branch : Branch
        Limit cycles from the Hopf point on.
    lift_off : tuple of LiftOff
        For each contact whose load touches zero along the branch, the first such cycle.

    Examples
    --------
    >>> import sympy as sp, symfric as sf
    >>> chain = sf.structures.chain(2, damping=0.05, ends="fixed-free")
    >>> v_b = sp.Symbol("v_b", positive=True)
    >>> pad = sf.structures.RowContact("pad", {"x2": 1.0}, 1.0, sf.laws.cubic(0.4, 0.25, 0.5), speed=v_b)
    >>> scene = chain.scene([pad], values={v_b: 0.3})
    >>> found = sf.structures.onset(scene, "v_b", bracket=(0.3, 0.7), span=(0.45, 0.7))
    >>> found.hopf.kind, bool(found.branch.orbits[0].stable), found.lift_off
    ('supercritical', True, ())
    """

    hopf: HopfPoint
    branch: Branch = field(repr=False)
    lift_off: tuple[LiftOff, ...]


@logged
def onset(
    scene: Scene,
    parameter: Key,
    bracket: tuple[float, float] | HopfPoint,
    span: tuple[float, float] | None = None,
    most: int = 200,
) -> Onset:
    """Follow the vibration of a structure from its onset: Hopf point, limit cycles, lift-off.

    Parameters
    ----------
    scene : Scene
        With steady sliding at the ends of the bracket, such as one of a reduced structure.
    parameter : Symbol or str
    bracket : (float, float) or HopfPoint
        Between which steady sliding becomes unstable, or the point where it does.
    span : (float, float), optional
        Along which limit cycles are followed; the bracket unless given.
    most : int
        Most limit cycles.

    Returns
    -------
    Onset

    Raises
    ------
    NotFound
        If sliding does not become unstable in between; or if no cycle grows from there because the equations of sliding
        are linear, as under Coulomb friction: then the amplitude is decided by lift-off and sticking, and a simulation
        finds it.
    SceneError
        If names and numbers are wrong.

    Examples
    --------
    >>> import sympy as sp, symfric as sf
    >>> mu = sp.Symbol("mu", positive=True)
    >>> s = sf.structures.Structure([[1, 0], [0, 1]], [[1.05, 0.2], [0.2, 0]], [[0.02, 0], [0, 0.02]], names=["x", "y"])
    >>> load = sf.structures.RowLoad(1.0, {"y": 1.0}, push={"y": -1.0})
    >>> law = sf.laws.custom(mu * (1 - 0.2 * sp.exp(-sf.SPEED)), mu)
    >>> belt = sf.structures.RowContact("belt", {"x": 1.0}, load, law, speed=1.0)
    >>> found = sf.structures.onset(s.scene([belt], values={mu: 0.3}), "mu", (0.1, 0.4), span=(0.2, 0.224))
    >>> found.hopf.kind, round(found.hopf.value, 6), [contact.contact for contact in found.lift_off]
    ('supercritical', 0.222917, ['belt'])
    """
    point = bracket if isinstance(bracket, HopfPoint) else hopf(scene, parameter, bracket)
    if point.kind == "degenerate":
        raise NotFound(
            f"the cubic coefficient at {point.parameter} = {point.value:.9g} vanishes: the amplitude is not decided "
            "near the onset but by lift-off and sticking; simulate the scene until it settles"
        )
    if span is None:
        if isinstance(bracket, HopfPoint):
            raise SceneError("onset starts at a Hopf point: give the span along which limit cycles are followed")
        span = bracket
    branch = continue_cycle(scene, parameter, span, point, most, _TOLERANCE)
    return Onset(point, branch, lift_offs(scene, point.parameter, branch))


def lift_offs(scene: Scene, name: str, branch: Branch) -> tuple[LiftOff, ...]:
    """Return for each contact the first orbit of a branch, from its small end on, on which its load touches zero.

    Parameters
    ----------
    scene : Scene
    name : str
        Of the parameter of the branch.
    branch : Branch

    Returns
    -------
    tuple[LiftOff, ...]
    """
    loads = {c.name: load for c in scene.contacts if (load := _inside(c.normal)) is not None}
    if not loads or not branch.orbits:
        return ()
    longest = max(orbit.period for orbit in branch.orbits)
    program = prepare(scene.until(1.01 * longest, {c: Min(e) for c, e in loads.items()}), _TOLERANCE)
    sizes = [float(np.max(orbit.half_range)) for orbit in branch.orbits]
    order = range(len(sizes)) if sizes[0] <= sizes[-1] else range(len(sizes) - 1, -1, -1)
    lifts = []
    for contact in loads:
        before = None
        for k in order:
            value, orbit = float(branch.values[k]), branch.orbits[k]
            if _least(program, scene, name, value, orbit, contact) <= 0:
                lifts.append(_located(program, scene, name, contact, before, (value, orbit)))
                break
            before = value, orbit
    return tuple(lifts)


def _located(
    program: Program,
    scene: Scene,
    name: str,
    contact: str,
    before: tuple[float, Orbit] | None,
    after: tuple[float, Orbit],
) -> LiftOff:
    """Return where between two orbits of a branch the load of a contact touches zero."""
    if before is None or before[0] == after[0]:
        return LiftOff(contact, *after)
    orbits = dict([before, after])

    def left(value: float) -> float:
        if value not in orbits:
            near = min(orbits, key=lambda known: abs(known - value))
            orbits[value] = limit_cycle(scene.where({name: value}), orbits[near], _TOLERANCE)
        return _least(program, scene, name, value, orbits[value], contact)

    try:
        value = zero(left, before[0], after[0], rtol=_CLOSE, xtol=_CLOSE * abs(after[0]))
    except NotFound:
        return LiftOff(contact, *after)
    left(value)
    return LiftOff(contact, value, orbits[value])


def _least(program: Program, scene: Scene, name: str, value: float, orbit: Orbit, contact: str) -> float:
    start = dict(zip(orbit.names, orbit.start.tolist(), strict=True))
    return float(finished(program.run({name: value}, start))[contact])


def _inside(normal: sp.Expr) -> sp.Expr | None:
    """Return what a load ``Max(0, e)`` is while it is positive; None for other loads."""
    if not isinstance(normal, sp.Max) or len(normal.args) != 2 or sp.S.Zero not in normal.args:
        return None
    return next(e for e in normal.args if e != 0)
