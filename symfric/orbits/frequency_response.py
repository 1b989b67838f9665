"""Forced periodic responses over the frequency of the excitation, and the peak."""

from dataclasses import replace

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged, tell
from symfric.model.excitation import is_excited
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import Key, finite, name_of, nearest, pair
from symfric.orbits.continuation.branch import Branch, Peak, followed
from symfric.orbits.continuation.walk import FINE, Steps
from symfric.orbits.cycle import Orbit, orbit_at, values_of
from symfric.orbits.flow_map import flow_of
from symfric.search import minimum

_PIECES = 6  # starts of a branch that ends within the span
_STEP = 1e-3  # of the span: how far behind an end the next piece starts


@logged
def frequency_response(
    scene: Scene,
    parameter: Key,
    span: tuple[float, float],
    coordinate: Key | None = None,
    start: Orbit | None = None,
    most: int = 1000,
    tolerance: float = 1e-13,
) -> Branch:
    """Follow the periodic response of a forced scene over the frequency of its excitation.

    Parameters
    ----------
    scene : Scene
        With an excitation whose frequency is the parameter.
    parameter : Symbol or str
        The frequency, such as Omega in ``cos(Omega t)``.
    span : (float, float)
        Range of the frequency; the value in the scene is where the branch starts if it lies within.
    coordinate : Symbol or str, optional
        State whose half range has the peak; the first coordinate unless given.
    start : Orbit, optional
        A response to start from; what the motion of the scene settles to unless given.
    most : int
        Orbits in each direction.
    tolerance : float
        Of the motion.

    Returns
    -------
    Branch
        With `peak`, located between the orbits by their responses, not read from them. Onset and loss of sticking are
        special points along it: "stick-onset", and of joints with a stiffness "slip-onset", see `Special`.

    Raises
    ------
    SceneError
        If the scene is not forced, or names and numbers are wrong.
    NotFound
        If the motion settles to no response from which to start.

    Notes
    -----
    Where a branch ends within the span, because the response jumps or another contact is met, the motion of the scene
    is followed beyond, and the next piece of the branch starts from what it settles to.

    Examples
    --------
    A joint that slips, force amplitude 1, against the closed form of a linear oscillator without friction:

    >>> import sympy as sp, symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> W = sp.Symbol("W", positive=True)
    >>> system = sf.System([x], [u], [[1]], [-x - u / 5 + sp.cos(W * sf.TIME)])
    >>> linear = sf.Scene(system, values={W: 0.9}, initial={x: 0, u: 0}, horizon=60.0)
    >>> found = sf.frequency_response(linear, "W", (0.8, 1.2)).peak
    >>> round(float(found.value), 6), round(found.half_range, 6)  # sqrt(1 - 2 D^2), 1/(2 D sqrt(1 - D^2)), D = 0.1
    (0.989949, 5.025189)
    """
    return response(scene, parameter, span, coordinate, start, most, tolerance, FINE)


@logged
def response(
    scene: Scene,
    parameter: Key,
    span: tuple[float, float],
    coordinate: Key | None,
    start: Orbit | None,
    most: int,
    tolerance: float,
    steps: Steps,
) -> Branch:
    """Return the result of `frequency_response`, followed with given steps."""
    check_scene(scene)
    name = scene.parameter(parameter).name
    low, high = (finite(v, f"an end of the span of {name}") for v in pair(span, "span"))
    if not low < high:
        raise SceneError(f"the span of {name} is ({low:g}, {high:g}); give (low, high) with low < high")
    if not is_excited(scene):
        raise SceneError("no force of the scene depends on time; a frequency response needs an excitation")
    names = [s.name for s in scene.system.states]
    measured = names[0] if coordinate is None else name_of(coordinate)
    if measured not in names:
        raise SceneError(f"{measured} is no state{nearest(measured, names)}")
    here = scene.values[scene.parameter(name)]
    begin = here if here is not None and low <= here <= high else 0.5 * (low + high)
    whole = followed(scene.where({name: begin}), name, (low, high), start, most, tolerance, steps)
    pieces = [whole]
    for side in (0, 1):
        if "interrupted" in pieces[-1].ends:
            break
        pieces += _beyond(scene, name, (low, high), whole, side, most, tolerance, steps)
    tell("the peak")
    return _joined(scene, pieces, names.index(measured), tolerance)


def _beyond(
    scene: Scene,
    name: str,
    span: tuple[float, float],
    branch: Branch,
    side: int,
    most: int,
    tolerance: float,
    steps: Steps,
) -> list[Branch]:
    """Return the pieces of the branch beyond an end within the span."""
    branches: list[Branch] = []
    for _ in range(_PIECES):
        if branch.ends[side] in ("span", "closed", "interrupted"):
            break
        at = float(np.max(branch.values) if side else np.min(branch.values))
        at += (1 if side else -1) * _STEP * (span[1] - span[0])
        if not span[0] < at < span[1]:
            break
        rest = (at, span[1]) if side else (span[0], at)
        try:
            branch = followed(scene.where({name: at}), name, rest, None, most, tolerance, steps)
        except NotFound:
            break
        branches.append(branch)
    return branches


def _joined(scene: Scene, pieces: list[Branch], k: int, tolerance: float) -> Branch:
    """Return one branch of the pieces, by increasing frequency, with its peak."""
    pieces = sorted(pieces, key=lambda b: float(np.min(b.values)))
    values = np.concatenate([b.values for b in pieces])
    orbits = tuple(o for b in pieces for o in b.orbits)
    special = tuple(s for b in pieces for s in b.special)
    whole = Branch(pieces[0].parameter, values, orbits, special, (pieces[0].ends[0], pieces[-1].ends[1]))
    return replace(whole, peak=_peak(scene, whole, k, tolerance))


def _peak(scene: Scene, branch: Branch, k: int, tolerance: float) -> Peak:
    """Return where the half range of state k is largest, between the neighbours of the largest orbit."""
    sizes = np.array([o.half_range[k] for o in branch.orbits])
    i = int(np.argmax(sizes))
    best = Peak(float(branch.values[i]), float(sizes[i]), branch.orbits[i])
    if not 0 < i < sizes.size - 1 or "interrupted" in branch.ends:
        return best
    low, high = sorted((float(branch.values[i - 1]), float(branch.values[i + 1])))
    if not low < best.value < high:
        return best  # a fold
    return highest(scene, branch.parameter, k, best, (low, high), tolerance)


def summits(branch: Branch, k: int) -> list[Peak]:
    """Return the orbits of a branch whose half range of state k is not below that of their neighbours."""
    sizes = np.array([o.half_range[k] for o in branch.orbits])
    beside = np.concatenate([[-np.inf], sizes, [-np.inf]])
    at = np.flatnonzero((sizes >= beside[:-2]) & (sizes >= beside[2:]))
    return [Peak(float(branch.values[i]), float(sizes[i]), branch.orbits[i]) for i in at]


def highest(
    scene: Scene,
    parameter: str,
    k: int,
    near: Peak,
    span: tuple[float, float],
    tolerance: float,
    close: float = 1e-9,
) -> Peak:
    """Return the response with the largest half range of state k within a span, with a single peak near a given one.

    Parameters
    ----------
    scene : Scene
    parameter : str
        The frequency.
    k : int
    near : Peak
        Whose orbit leads to those of the span. It is the result where no other is larger; of another scene give it the
        half range 0.0.
    span : (float, float)
    tolerance : float
        Of the motion.
    close : float
        Error of the frequency, relative to it.
    """
    best, known = near, {near.value: near.orbit}
    flow, values = flow_of(scene, (parameter,), tolerance), values_of(scene)  # that of the branch

    def size(value: float) -> float:
        nonlocal best
        try:
            orbit = orbit_at(scene, flow, {**values, parameter: value}, _between(known, value))
        except NotFound:
            return 0.0
        if near.half_range == 0.0:  # of another scene
            known.pop(near.value, None)
        known[value] = orbit
        if orbit.half_range[k] > best.half_range:
            best = Peak(float(value), float(orbit.half_range[k]), orbit)
        return -float(orbit.half_range[k])

    minimum(size, *span, xatol=close * max(abs(span[0]), abs(span[1])))
    return best


def _between(known: dict[float, Orbit], value: float) -> tuple[np.ndarray, float]:
    """Return a guess of the response at a frequency, on the line through the starts at the two nearest known ones."""
    one, *others = sorted(known, key=lambda v: abs(v - value))
    start, turn = known[one].start, known[one].period * one
    alike = [v for v in others if abs(known[v].period * v - turn) < 1e-6 * turn]
    if alike and alike[0] != one:
        start = start + (value - one) / (alike[0] - one) * (known[alike[0]].start - start)
    return start, turn / value
