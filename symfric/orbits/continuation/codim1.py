"""Curves of special points (fold, flip, Neimark-Sacker, stick onset, grazing) in the plane of two parameters."""

from dataclasses import dataclass, field

import numpy as np

from symfric.axes import Axes
from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged, tell, until_interrupted
from symfric.lower.relaxed_guards import FAR
from symfric.model.arguments import instance, whole
from symfric.model.results import ArrayResult, Drawable, Labelled
from symfric.model.scene import Scene
from symfric.model.symbols import Key, finite, pair
from symfric.orbits.continuation.arclength import cosine, step_along, tangent, units
from symfric.orbits.continuation.bifurcations import TOUCHES, Condition, at_the_edge, guard_size
from symfric.orbits.continuation.branch import Special
from symfric.orbits.cycle import Orbit, orbit_of, read_guess
from symfric.orbits.flow_map import flow_of
from symfric.orbits.shooting import Point, ShootingSystem, null_of, solve

# step lengths in units of the spans, the period and the ranges of the states
_FIRST, _LEAST, _LARGEST = 0.01, 1e-5, 0.03
_NEARLY = 1e-3  # distance from grazing, relative to the guard's size, at which the curve ends
INTERRUPTED = "interrupted"
_TURN = 0.9  # least cosine of the angle between consecutive steps


@dataclass(frozen=True, eq=False)
class Curve(ArrayResult, Drawable):
    """Special points of one kind in the plane of two parameters, in the order of the curve.

    `plot` draws the second parameter against the first.

    Attributes
    ----------
    kind : str
    parameters : (str, str)
    values : ndarray, shape (2, n)
    periods : ndarray, shape (n,)
    ends : (str, str)
        "span", "budget", "grazing" where the orbits touch a guard, "interrupted" (see
        `symfric.keep_when_interrupted`), or "lost" if no point was found further on.
    condition : Condition
        What holds on it.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.4)
    >>> branch = sf.continue_cycle(belt, "v_b", (0.38, 0.42))
    >>> curve = sf.continue_special(branch.special[0], ("v_b", "beta"), ((0.38, 0.42), (0.04, 0.06)), most=6)
    >>> curve.orbit(0).stable
    True
    >>> curve.at(0.395).shape
    (1,)
    >>> sorted(curve.to_dict())[:2]
    ['ends', 'kind']
    >>> len(curve.to_xarray().data_vars) > 0
    True
    >>> ax = curve.plot()
    """

    kind: str
    parameters: tuple[str, str]
    values: np.ndarray
    periods: np.ndarray
    ends: tuple[str, str]
    condition: Condition
    _points: tuple[Point, ...] = field(repr=False)
    _system: ShootingSystem = field(repr=False)
    _base: Scene = field(repr=False)
    _told = ("kind", "parameters", "values", "periods", "ends")

    def _labelled(self) -> Labelled:
        rows = {name: ("point", row) for name, row in zip(self.parameters, self.values, strict=True)}
        return {**rows, "period": ("point", self.periods)}, {}, {"kind": self.kind}

    def orbit(self, k: int) -> Orbit:
        """Return the periodic orbit at point k of the curve.

        Parameters
        ----------
        k : int
            Number of the point, from 0.

        Returns
        -------
        Orbit
        """
        return orbit_of(self._base, self._system, self._points[k])

    def at(self, value: float) -> np.ndarray:
        """Return the values of the second parameter at a value of the first, with the precision of the orbits.

        Shape (number of passages,), in the order of the curve.

        Parameters
        ----------
        value : float
            Of the first parameter.

        Returns
        -------
        ndarray, shape (number of passages,)
        """
        orbits = []
        for one, other in zip(self._points[:-1], self._points[1:], strict=True):
            before, after = one.z[-2] - value, other.z[-2] - value
            if before * after > 0 or before == after or (after == 0 and other is not self._points[-1]):
                continue
            near = one if abs(before) < abs(after) else other
            there = near.z.copy()
            there[-2] = value
            point = solve(self._system, near.z, _unit(self._system, -2), through=there)
            orbits.append(_exact(self._system, point, self.condition, _unit(self._system, -2))[-1])
        return np.array(orbits)

    def _draw(self, ax: Axes | None) -> Axes:
        from symfric.orbits.plotting import plot_curve

        return plot_curve(self, self._base.units, ax)

    def __repr__(self) -> str:
        low, high = np.min(self.values, axis=1), np.max(self.values, axis=1)
        spans = " and ".join(f"{n} from {a:.6g} to {b:.6g}" for n, a, b in zip(self.parameters, low, high, strict=True))
        return f"Curve({self.kind}, {spans}, {self.values.shape[1]} points)"


@logged
def continue_special(
    special: Special,
    parameters: tuple[Key, Key],
    spans: tuple[tuple[float, float], tuple[float, float]],
    most: int = 1000,
    tolerance: float = 1e-13,
) -> Curve:
    """Continue a special point of a branch of limit cycles in two parameters.

    Parameters
    ----------
    special : Special
        A fold, flip, Neimark-Sacker point, onset of sticking or grazing from a `Branch`; a Hopf point needs no orbits.
    parameters : (Symbol or str, Symbol or str)
    spans : two pairs of floats
        Of either parameter.
    most : int
        Points in each direction.
    tolerance : float
        Of the motion.

    Returns
    -------
    Curve

    Raises
    ------
    NotFound
        If the condition cannot be stated: the guard that is touched has other events on the orbit.
    SceneError
        If names and numbers are wrong, or the point lies outside the spans.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.4)
    >>> branch = sf.continue_cycle(belt, "v_b", (0.38, 0.42))
    >>> curve = sf.continue_special(branch.special[0], ("v_b", "beta"), ((0.38, 0.42), (0.04, 0.06)), most=6)
    >>> curve.kind
    'stick-onset'
    """
    instance(special, Special, "special")
    if special.kind == "hopf":
        raise SceneError("a Hopf point is one of steady sliding; repeat sf.hopf for values of the other parameter")
    if special.kind == "slip-onset":
        raise SceneError(
            f"the onset of slip of {special.contact!r} has no curve; repeat sf.continue_cycle for values of the other "
            "parameter"
        )
    if special.kind == "branch-point":
        raise SceneError("a branch point has no curve; repeat sf.continue_cycle for values of the other parameter")
    orbit = special.orbit
    scene = orbit.scene
    names = tuple(scene.parameter(p).name for p in pair(parameters, "parameters"))
    if names[0] == names[1]:
        raise SceneError(f"both parameters are {names[0]}; give two")
    both = zip(names, pair(spans, "spans"), strict=True)
    limits = np.array([[finite(v, f"an end of the span of {n}") for v in pair(s, f"the span of {n}")] for n, s in both])
    whole(most, "most")
    values = {s.name: v for s, v in scene.parameter_values().items()}
    here = np.array([values[n] for n in names])
    if np.any(here < limits[:, 0]) or np.any(here > limits[:, 1]):
        raise SceneError(f"the point {dict(zip(names, here.tolist(), strict=True))} lies outside the spans")
    flow = flow_of(scene, names, tolerance)
    multiple = read_guess(orbit, flow, flow.period(values)).multiple if flow.period else 0
    system = _conditioned(
        ShootingSystem(flow, values, multiple, widths=tuple(np.ptp(limits, axis=1).tolist())), special.condition, orbit
    )
    first = solve(system, system.pack(orbit.start, orbit.period, values), _unit(system, -1))
    along = null_of(system, first)
    sides = [_trace(system, first, -along, limits, most)]
    sides.append(([], INTERRUPTED) if sides[0][1] == INTERRUPTED else _trace(system, first, along, limits, most))
    points = (*reversed(sides[0][0]), first, *sides[1][0])
    return Curve(
        kind=special.kind,
        parameters=names,
        values=np.array([_exact(system, p, special.condition)[-2:] for p in points]).T,
        periods=np.array([system.unpack(p.z)[1] for p in points]),
        ends=(sides[0][1], sides[1][1]),
        condition=special.condition,
        _points=points,
        _system=system,
        _base=scene,
    )


def _conditioned(system: ShootingSystem, condition: Condition, orbit: Orbit) -> ShootingSystem:
    """Return the equations of the special point; for a touch, the guard is in units of its size on the orbit."""
    if condition.kind in TOUCHES and condition.guard < 0 and not condition.turn:
        raise NotFound(
            "the contact that touches has other events on this orbit, which cannot be told from the touch, or it is in "
            "the plane"
        )
    if condition.guard < 0:
        return condition.system(system, 1.0)
    z = system.pack(orbit.start, orbit.period, system.values)
    return condition.system(system, guard_size(system, z, system.follow(z), condition.guard))


def _unit(system: ShootingSystem, place: int) -> np.ndarray:
    """Return the unit vector of one unknown."""
    direction = np.zeros(len(system.flow.states) + system.free + 2)
    direction[place] = 1.0
    return direction


def _exact(system: ShootingSystem, point: Point, condition: Condition, normal: np.ndarray | None = None) -> np.ndarray:
    """Return the unknowns at the grazing itself; see `at_the_edge`."""
    return np.asarray(point.z + at_the_edge(system, point, condition, normal))


def _grazes(system: ShootingSystem, point: Point) -> bool:
    """Whether another guard is about to graze, beyond which the orbits have other events."""
    gaps = [k for k, gap in enumerate(point.passage.gaps) if abs(gap) < FAR]
    return any(abs(point.passage.gaps[k]) < _NEARLY * guard_size(system, point.z, point.passage, k) for k in gaps)


def _trace(
    system: ShootingSystem, start: Point, along: np.ndarray, limits: np.ndarray, most: int
) -> tuple[list[Point], str]:
    """Follow the curve from a point to the end of a span; return the points and why it ended."""
    points: list[Point] = []
    with until_interrupted("continue_special"):
        return points, _followed(points, system, start, along, limits, most)
    return points, INTERRUPTED


def _followed(
    points: list[Point], system: ShootingSystem, start: Point, along: np.ndarray, limits: np.ndarray, most: int
) -> str:
    """Append the points of the curve to those given; return why it ended."""
    point, step, largest = start, _FIRST, start.passage.ranges
    way = tangent(system, point, units(system, point, limits, largest), along)
    while len(points) < most:
        largest = np.maximum(largest, point.passage.ranges)
        size = units(system, point, limits, largest)
        new, ends = step_along(system, point, way, step, size, limits)
        ahead = way if new is None else tangent(system, new, size, way)
        if new is None or (cosine(ahead, way, size) < _TURN and step > _LEAST):
            if step <= _LEAST:
                return "grazing" if _grazes(system, point) else "lost"
            step *= 0.4
            continue
        points.append(new)
        tell(f"{len(points)} points to {new.z[-2]:.5g}, {new.z[-1]:.5g}")
        if ends:
            return "span"
        point, way, step = new, ahead, min(1.5 * step, _LARGEST)
    return "budget"
