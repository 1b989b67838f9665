"""Branches of limit cycles: pseudo-arclength continuation through folds and across the onset of sticking."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from symfric.axes import Axes
from symfric.errors import SceneError
from symfric.long_calls import logged
from symfric.lower.mode_layout import contact_of_gap, slip_gap
from symfric.model.arguments import whole
from symfric.model.notebook import html_table
from symfric.model.results import ArrayResult, Drawable, Labelled, plain
from symfric.model.scene import Scene, check_scene
from symfric.model.springs import in_order
from symfric.model.symbols import Key, finite, pair
from symfric.model.units import attributes_of
from symfric.orbits.continuation.bifurcations import Condition
from symfric.orbits.continuation.branch_points import KIND, departures, doubled
from symfric.orbits.continuation.closed_branch import Placed
from symfric.orbits.continuation.hopf import birth
from symfric.orbits.continuation.walk import FINE, HalfBranch, SpecialPoint, Steps, Walk
from symfric.orbits.cycle import Orbit, found_cycle, orbit_of, read_guess, values_of
from symfric.orbits.flow_map import flow_of
from symfric.orbits.shooting import Point, ShootingSystem, solve
from symfric.theory.hopf import HopfPoint


@dataclass(frozen=True, eq=False)
class Special:
    """A special point (bifurcation) of a branch of limit cycles.

    Attributes
    ----------
    kind : str
        "hopf" (the orbit shrinks to steady sliding), "fold" (the parameter turns back), "branch-point" (another branch
        crosses; `continue_cycle` follows it from here), "flip", "neimark-sacker", "stick-onset" (the orbit just reaches
        zero slip and sticks beyond), "slip-onset" (a contact behind a spring slips on one side, and sticks all the time
        on the other) or "grazing" (another guard is touched, or a contact that already sticks touches zero slip once
        more). A change of events where the parameter turns back is a fold as well.
    value : float
        Of the parameter.
    orbit : Orbit
        There; at a Hopf point the smallest one found, and where static friction exceeds kinetic friction one that is
        3e-6 of the bound away, on the side from which the branch was followed.
    condition : Condition
        What holds there, for `continue_special`.
    jump : bool
        Whether the orbits end there: with a static coefficient above the kinetic one a contact that begins to stick may
        stick for a while at once. The branch goes on with the orbit to which the last one settles, if there is one.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.4)
    >>> branch = sf.continue_cycle(belt, "v_b", (0.38, 0.42))
    >>> special = branch.special[0]
    >>> special.kind, round(special.value, 6)
    ('stick-onset', 0.39579)
    """

    kind: str
    value: float
    orbit: Orbit
    condition: Condition = field(repr=False)
    jump: bool = False

    @property
    def contact(self) -> str | None:
        """The contact that begins to stick or to slip there; None of other kinds."""
        where, contacts = self.condition, self.orbit.scene.contacts
        if where.spring >= 0:
            state = self.orbit.scene.system.states[where.spring]
            return next(c.name for c in contacts if state in c.states)
        lines = [c.name for c in in_order(contacts) if c.along_line]
        if where.turn is not None:
            return lines[where.turn[0]]
        if where.guard >= slip_gap(len(lines)):
            stops = [c.name for c in contacts if c.frictionless]
            opening = [*stops, *(c.name for c in contacts if c.unilateral is not None and not c.frictionless)]
            return opening[where.guard - slip_gap(len(lines))]
        return lines[contact_of_gap(where.guard)] if where.guard >= 0 else None

    def __repr__(self) -> str:
        return f"Special({self.kind}, value={self.value:.14g}{', jump' if self.jump else ''})"


REASONS = {
    "span": "the end of the span",
    "hopf": "the Hopf point",
    "branch-point": "the branch point where it starts",
    "flip": "a flip of a branch with half its period",
    "grazing": "{}, without an orbit beyond",
    "jump": "{}, beyond which the motion settles to no cycle",
    "closed": "its start, as a closed curve",
    "folded-back": "an orbit from which it runs back over itself",
    "budget": "the largest number of orbits",
    "lost": "an orbit beyond which none was found",
    "interrupted": "an orbit beyond which the search was interrupted",
}


class Peak(NamedTuple):
    """The largest response along a branch.

    Attributes
    ----------
    value : float
        Of the parameter.
    half_range : float
        Of the coordinate asked for.
    orbit : Orbit
    """

    value: float
    half_range: float
    orbit: Orbit


@dataclass(frozen=True, eq=False)
class Branch(ArrayResult, Drawable):
    """A branch of limit cycles, in order along it.

    `plot` draws the half range of the first coordinate against the parameter.

    Attributes
    ----------
    parameter : str
    values : ndarray, shape (n,)
        Of the parameter; not monotonic where the branch folds.
    orbits : tuple of Orbit, length n
    special : tuple of Special
        In the order of the branch.
    ends : (str, str)
        Why it ends on either side: "span", "hopf", "branch-point" (where it starts), "flip" (on a branch with half its
        period), "grazing" (beyond, the motion misses the event), "jump" (static friction above kinetic friction ends
        the orbits there, and beyond, the motion settles to no other orbit), "closed", "folded-back" (it runs back over
        its own orbits), "budget", "interrupted" (see `symfric.keep_when_interrupted`), or "lost" if no orbit was found
        further on. `reasons` says the same in words.
    peak : Peak or None
        Of a frequency response; see `symfric.frequency_response`.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.4)
    >>> branch = sf.continue_cycle(belt, "v_b", (0.38, 0.42))
    >>> round(float(branch.values.min()), 6)
    0.38
    >>> sorted(branch.to_dict())[:2]
    ['ends', 'half_range']
    >>> len(branch.to_xarray().data_vars) > 0
    True
    >>> ax = branch.plot()
    """

    parameter: str
    values: np.ndarray
    orbits: tuple[Orbit, ...]
    special: tuple[Special, ...]
    ends: tuple[str, str]
    peak: Peak | None = None

    def _labelled(self) -> Labelled:
        data = {
            "half_range": (("point", "state"), np.array([o.half_range for o in self.orbits])),
            "period": ("point", [o.period for o in self.orbits]),
            "stick_fraction": ("point", [o.stick_fraction for o in self.orbits]),
            "stable": ("point", [o.stable for o in self.orbits]),
        }
        unit = attributes_of(self.parameter, self.orbits[0].base.units)
        return data, {"state": list(self.orbits[0].names), self.parameter: ("point", self.values, unit)}, {}

    @property
    def reasons(self) -> tuple[str, str]:
        """Why the branch ends on either side, in words and with the value of the parameter there."""
        one, other = (self._reason(self.ends[k], k) for k in (0, -1))
        return one, other

    def _reason(self, end: str, k: int) -> str:
        value, words = float(self.values[k]), REASONS[end]
        if end in ("hopf", "grazing", "jump") and self.special:
            point = self.special[k]
            value, words = (
                point.value,
                words.format(f"a {point.kind}" + f" of {point.contact}" * bool(point.contact)),
            )
        return f"{words.format('a corner')} at {self.parameter} = {value:.6g}"

    def _draw(self, ax: Axes | None) -> Axes:
        from symfric.orbits.plotting import plot_branch

        return plot_branch(self, ax)

    def to_dict(self) -> dict[str, Any]:
        of_orbits = ("half_range", "period", "stick_fraction", "stable")
        return {
            "parameter": self.parameter,
            "values": self.values.tolist(),
            **{name: plain([getattr(o, name) for o in self.orbits]) for name in of_orbits},
            "special": [{"kind": s.kind, "value": s.value, "jump": s.jump} for s in self.special],
            "ends": list(self.ends),
            "reasons": list(self.reasons),
        }

    def _repr_html_(self) -> str:
        ranges = [o.half_range for o in self.orbits]
        sizes = {n: [float(r[k]) for r in ranges] for k, n in enumerate(self.orbits[0].names)} if ranges else {}
        return html_table("Branch", {**self.to_dict(), "half_range": sizes})

    def __repr__(self) -> str:
        kinds = ", ".join(f"{s.kind}{' with a jump' * s.jump} at {s.value:.9g}" for s in self.special)
        kinds = kinds or "no special points"
        low, high = np.min(self.values), np.max(self.values)
        ends = " and ".join(self.reasons)
        return (
            f"Branch({self.parameter} from {low:.6g} to {high:.6g}, {len(self.orbits)} orbits; {kinds}; ends: {ends})"
        )


@logged
def continue_cycle(
    scene: Scene,
    parameter: Key,
    span: tuple[float, float],
    start: Orbit | HopfPoint | Special | tuple[Sequence[float], float] | None = None,
    most: int = 1000,
    tolerance: float = 1e-13,
) -> Branch:
    """Continue a limit cycle in a parameter, in both directions and round folds, to the ends of a span.

    Parameters
    ----------
    scene : Scene
        The value of the parameter in it is where the branch starts, unless a Hopf point or a special point is given.
    parameter : Symbol or str
    span : (float, float)
    start : Orbit, HopfPoint, Special, or (state, period), optional
        The orbit to start from, or something near it; by default what the motion of the scene settles to. From a Hopf
        point the branch starts with its small cycles. From a branch point the other branch is followed, to both sides;
        from a flip the cycles of twice the period; from any other special point the branch on which it was found.
    most : int
        Orbits in each direction.
    tolerance : float
        Of the motion.

    Returns
    -------
    Branch

    Raises
    ------
    NotFound
        If there is no cycle to start from, or no other branch at the branch point.
    SceneError
        If the start lies outside the span, or names and numbers are wrong.

    Notes
    -----
    Both sides of the start are followed, through stable and unstable parts alike, until the span ends or no orbit is
    found; `Branch.reasons` tells which. The walk passes a branch point on the branch that it came along.

    The branch goes on across the onset of sticking, where it has a corner: the orbit that touches zero slip is found
    by Newton's method on orbits that ignore the touch, and the orbits beyond start there. A reversal begins to stick
    where static friction can just bear the force that holds the contact. Special points are located to the precision of
    the orbits; where static friction exceeds kinetic friction, from orbits 3e-6 of the bound away on one side.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.4)
    >>> branch = sf.continue_cycle(belt, "v_b", (0.38, 0.42))
    >>> [(p.kind, round(p.value, 6)) for p in branch.special]
    [('stick-onset', 0.39579)]
    >>> branch.reasons
    ('the end of the span at v_b = 0.38', 'the end of the span at v_b = 0.42')
    """
    return followed(scene, parameter, span, start, most, tolerance, FINE)


@logged
def followed(
    scene: Scene,
    parameter: Key,
    span: tuple[float, float],
    start: Orbit | HopfPoint | Special | tuple[Sequence[float], float] | None,
    most: int,
    tolerance: float,
    steps: Steps,
) -> Branch:
    """Return the result of `continue_cycle`; from an orbit it is followed with given steps."""
    check_scene(scene)
    name, most = scene.parameter(parameter).name, whole(most, "most")
    low, high = (finite(v, f"an end of the span of {name}") for v in pair(span, "span"))
    if not low < high:
        raise SceneError(f"the span of {name} is ({low:g}, {high:g}); give (low, high) with low < high")
    begins = start.value if isinstance(start, HopfPoint | Special) else values_of(scene)[name]
    if not low <= begins <= high:
        raise SceneError(f"{name} = {begins:g} lies outside the span from {low:g} to {high:g}")
    scene = scene.where({name: begins})
    if isinstance(start, HopfPoint):
        return _from_hopf(scene, name, (low, high), start, most, tolerance)
    if isinstance(start, Special):
        if start.kind in (KIND, "flip"):
            return _across(scene, name, (low, high), start, most, tolerance)
        start = start.orbit
    orbit = found_cycle(scene, flow_of(scene, (name,), tolerance), start)
    system = _system(scene, name, (low, high), orbit, tolerance)
    first = solve(system, system.pack(orbit.start, orbit.period, system.values), _parameter_alone(system))
    upward = _parameter_alone(system)
    sides: list[HalfBranch] = []
    for way, end in ((-1, low), (1, high)):
        if begins == end or (sides and sides[0].end == "closed"):
            sides.append(HalfBranch(end="span" if begins == end else "closed"))
            continue
        if sides and sides[0].end == "interrupted":
            sides.append(HalfBranch(end="interrupted"))
            continue
        sides.append(Walk(scene, system, (low, high), most, steps).go(first, way * upward))
    return _joined(scene, system, first, *sides)


def _system(
    scene: Scene, name: str, span: tuple[float, float], orbit: Orbit | None, tolerance: float
) -> ShootingSystem:
    flow, values = flow_of(scene, (name,), tolerance), values_of(scene)
    multiple = read_guess(orbit, flow, flow.period(values)).multiple if flow.period and orbit else 0
    return ShootingSystem(flow, values, multiple, widths=(span[1] - span[0],))


def _parameter_alone(system: ShootingSystem) -> np.ndarray:
    return np.append(np.zeros(len(system.flow.states) + system.free), 1.0)


def _from_hopf(
    scene: Scene, name: str, span: tuple[float, float], start: HopfPoint, most: int, tolerance: float
) -> Branch:
    if start.parameter != name:
        raise SceneError(f"the Hopf point is one in {start.parameter}; find one in {name} for this branch")
    system = _system(scene, name, span, None, tolerance)
    first, grows = birth(scene, system, start)
    walk = Walk(scene, system, span, most)
    begin = HalfBranch(special=[SpecialPoint(Condition("hopf"), Placed(system, first), start.value)], end="hopf")
    return _joined(scene, system, first, begin, walk.go(first, grows))


def _across(scene: Scene, name: str, span: tuple[float, float], start: Special, most: int, tolerance: float) -> Branch:
    """Return the branch that crosses at a branch point, or that of twice the period from a flip."""
    if list(start.orbit.values) != [name]:
        known = ", ".join(start.orbit.values)
        raise SceneError(f"the {start.kind} is one in {known}; find one in {name} for this branch")
    system = _system(scene, name, span, start.orbit, tolerance)
    z, along = system.pack(start.orbit.start, start.orbit.period, system.values), np.array(start.condition.along)
    if start.kind == "flip":
        system, z, along = doubled(system, z, along)
    here, sides = departures(system, z, along)
    met = SpecialPoint(start.condition, Placed(system, here), start.value)
    halves = [HalfBranch(end=start.kind), HalfBranch(end=start.kind)]
    for k, (new, way) in enumerate(sides):
        if start.kind == "flip" and k:  # the same orbits, half a period later
            break
        inside = span[0] <= new.z[-1] <= span[1]
        halves[k] = Walk(scene, system, span, most).go(new, way) if inside else HalfBranch(end="span")
        halves[k].orbits[:0] = [Placed(system, new)] if inside else []
        if halves[k].end in ("closed", "interrupted"):
            break
    halves[0].special.insert(0, met)
    return _joined(scene, system, here, *halves)


def _joined(scene: Scene, system: ShootingSystem, first: Point, back: HalfBranch, there: HalfBranch) -> Branch:
    """Join two walks from one orbit, backward and forward, to a branch."""
    orbits = [*reversed(back.orbits), Placed(system, first), *there.orbits]
    special = [*reversed(back.special), *there.special]
    return Branch(
        parameter=system.flow.parameters[0],
        values=np.array([p.point.z[-1] for p in orbits]),
        orbits=tuple(orbit_of(scene, *p) for p in orbits),
        special=tuple(
            Special(m.condition.kind, m.value, orbit_of(scene, *m.orbit), m.condition, m.jump) for m in special
        ),
        ends=(back.end, there.end),
    )
