"""The largest gain, sampling period or dead time of a controller without hunting."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from symfric.design.controller.followed_motion import FollowedMotion
from symfric.design.controller.settling_motions import SettlingMotions, grid_of_starts
from symfric.design.result import Curve, Design
from symfric.design.verification import BEST_FOUND, Interrupted, Neighbour, design
from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model.results import Result
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import Key, finite, listed, mapped, name_of, nearest, pair, positive
from symfric.search import minimum_near

_SURVEY, _PERIODS = 33, 9  # values over the bounds, and sampling periods, that are looked at first
_WIDE = 10.0  # ratio of positive bounds from which on the values are spread by their logarithm
_SHARES = tuple(np.geomspace(1.0, 0.01, 24).tolist())  # of the scene's own start, from which motions begin
_ROUNDS = 8  # most times that motions of the verification that go on are added to those of the search
_BESIDE, _FINER = 1e-3, 1e-11  # relative distance of the designs that are verified, and tolerance of their runs


@dataclass(frozen=True)
class ControllerProbe:
    """What motions do with one design.

    Attributes
    ----------
    value, period : float
        Of the parameter; of the sampling period, NaN if it is not varied.
    left : float
        Latest time of rest, or largest half range after `settle`; infinite where a motion goes on.
    settles : bool
    starts : int
        Number of motions.
    """

    value: float
    period: float
    left: float
    settles: bool
    starts: int


@dataclass(frozen=True)
class ControllerCheck(Result):
    """Verification: motions at a finer tolerance a little below and above the design, below from other starts too.

    Attributes
    ----------
    below : ControllerProbe
    above : ControllerProbe or None
        None at the upper bound.
    """

    _told = ("agrees", "below", "above")

    below: ControllerProbe
    above: ControllerProbe | None

    @property
    def agrees(self) -> bool:
        """Whether all motions settle below the design, and not all of them above."""
        return not self.disagreements

    @property
    def disagreements(self) -> tuple[str, ...]:
        """The motions that contradict the design, as lines of text."""
        wrong = [] if self.below.settles else [_words(self.below, "a little below")]
        if self.above is not None and self.above.settles:
            wrong.append(_words(self.above, "a little above"))
        return tuple(wrong)

    def __str__(self) -> str:
        told = [_words(self.below, "a little below")]
        told += [_words(self.above, "a little above")] if self.above else []
        return "; ".join([*told, "other starts may behave differently"])


def _words(p: ControllerProbe, where: str) -> str:
    state = f"settle (worst: {p.left:.6g})" if p.settles else "do not all settle"
    return f"{where}, {p.starts} motions {state}"


@logged
def controller(
    scene: Scene,
    parameter: Key,
    bounds: tuple[float, float],
    periods: tuple[float, float] | None = None,
    half_range: float = 0.0,
    *,
    period: Key = "T",
    settle: float | None = None,
    starts: Mapping[Key, Sequence[float]] | None = None,
) -> Design:
    """Find the largest gain, sampling period or dead time of a controller with which a motion comes to rest.

    Parameters
    ----------
    scene : Scene
        With a controller, sampled (`sf.Held`) or not. Its horizon has to be longer than the waits of hunting.
    parameter : Symbol or str
        To be as large as possible.
    bounds : (float, float)
        Of the parameter; motions must come to rest at the lower one.
    periods : (float, float), optional
        Sampling periods at each of which they must; the scene's own unless given.
    half_range : float
        Of the first coordinate, by which it may still move after `settle`; 0.0: it rests.
    period : Symbol or str
        Name of the sampling period, or of any other value over whose range the design must hold, such as a dead time.
    settle : float, optional
        Time by which the motions must have come to rest, for the rest of the horizon; half of it unless given.
    starts : mapping of state to sequence of float, optional
        Start values, in every combination; the scene's own start and parts of it down to a hundredth unless given.

    Returns
    -------
    Design
        `curve` is the largest value over the sampling periods, or the time of rest over the values.

    Raises
    ------
    NotFound
        If motions go on at the lower bound.
    SceneError
        If an argument is wrong.

    Notes
    -----
    A sampled system seldom hunts periodically, as a stop lies anywhere between two samples, so that no branch of cycles
    ends at the border; motions decide. They are surveyed over the bounds from below, and between the last value with
    which all of them settle and the next one the border is bisected. Where hunting begins few starts lead to it, so a
    motion that hunts beyond the border is followed to lower values, each run from where the last one was at a sampling
    instant, until it comes to rest. Motions from other starts between the given ones
    verify it; where one of them goes on, these count, too. Values beyond it, at which motions settle again,
    do not count. A motion that fails or grows for ever does not settle.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, u = sp.symbols("x u", real=True)
    >>> D, T = sp.symbols("D T", positive=True)
    >>> damping = sf.Held("damping", update=sp.Max(-1, sp.Min(1, -D * u)), every=T)
    >>> rail = sf.Contact("rail", slip=u, normal=1, law=sf.laws.coulomb(0.2))
    >>> system = sf.System([x], [u], [[1]], [-x + damping.symbol])
    >>> scene = sf.Scene(system, [rail], {D: 1, T: 0.2}, {x: 0, u: 0.4}, 60.0, held=[damping])
    >>> found = sf.design.controller(scene, "D", bounds=(1, 30))
    >>> found.status, found.active
    ('optimal', ('hunting',))
    >>> 10.3 < found.values["D"] < 10.6
    True
    """
    check_scene(scene)
    scene.numbers()
    name = scene.parameter(parameter).name
    low, high = _range(bounds, "bounds")
    end = scene.horizon
    latest = 0.5 * end if settle is None else finite(settle, "settle")
    if not 0 < latest < end:
        raise SceneError(f"settle is {latest:g}; it must lie between 0 and the horizon of the scene, {end:g}")
    positive(half_range, "half_range", zero=True)
    varied, ends = None, None
    if periods is not None:
        varied, ends = scene.parameter(period).name, np.linspace(*_range(periods, "periods"), _PERIODS)
        if varied == name:
            raise SceneError(f"{name} is the parameter, and periods its range too; give period='...' another name")
    given = _starts(scene, starts)
    spread = np.geomspace if low > 0 and high > _WIDE * low else np.linspace
    grid = np.unique(np.clip(spread(low, high, _SURVEY), low, high))
    least = {name: low} | ({} if ends is None else {str(varied): float(ends[0])})
    motions = SettlingMotions(scene, name, varied, least, given, latest, float(half_range))
    borders: list[_Border] = []
    with until_interrupted("controller"):
        for k in range(_ROUNDS):
            tell(f"the border of settling, round {k + 1}")
            border, motions = _followed(motions, _border(motions, grid, ends), grid)
            borders.append(border)
            below = _below(motions, border, low)
            if below.settles:
                break
            motions = replace(motions, starts=[*motions.starts, *_between(motions.starts)])
        tell("verification of the design")
        return _result(motions, scene, border, high, below, _curve(motions, grid, border, ends))
    if not borders:
        raise KeyboardInterrupt
    return _interrupted(motions, scene, borders[-1], ends)


def _interrupted(motions: SettlingMotions, scene: Scene, border: "_Border", periods: np.ndarray | None) -> Design:
    """Return the last border that was found before an interrupt."""
    value = border.value
    at = np.array([value]) if periods is None else periods
    curve = Curve(at, border.all, value, motions.name if periods is None else str(motions.period), motions.name, ())
    placed = scene.where(motions.placed(value, border.period))
    return design(
        {motions.name: value}, value, (), placed, Interrupted(), curve, claim=BEST_FOUND, neighbours=(), sense=-1
    )


class _Border(NamedTuple):
    """The largest value, the sampling period that limits it, and the largest values at all periods.

    With a little more, `beyond`, not all motions settle; NaN if they do up to the upper bound.
    """

    value: float
    period: float | None
    all: np.ndarray
    beyond: float


def _border(motions: SettlingMotions, grid: np.ndarray, periods: np.ndarray | None) -> _Border:
    last, first = motions.border(grid, periods)
    if np.any(np.isnan(last)):
        at = "" if periods is None else f" and {motions.period} = {periods[int(np.argmax(np.isnan(last)))]:.6g}"
        raise NotFound(
            f"not all motions settle by t = {motions.settle:g} even at {motions.name} = {grid[0]:g}{at}; give lower "
            "bounds or a longer horizon"
        )
    k = int(np.argmin(last))
    value, worst, beyond = float(last[k]), None if periods is None else float(periods[k]), float(first[k])
    if periods is not None and 0 < k < periods.size - 1 and value < grid[-1]:
        near = minimum_near(lambda t: float(motions.border(grid, np.array([t]))[0][0]), periods, k)
        if near.value < value:
            value, worst = near.value, near.place
            beyond = float(motions.border(grid, np.array([worst]))[1][0])
    return _Border(value, worst, last, beyond)


def _followed(motions: SettlingMotions, border: _Border, grid: np.ndarray) -> tuple[_Border, SettlingMotions]:
    """Lower the border by the motion that goes on beyond it, and count that motion from then on."""
    followed = FollowedMotion(motions, border.period)
    state = None if np.isnan(border.beyond) else followed.from_starts(border.beyond)
    if state is None:
        return border, motions
    value, beyond, state = followed.lowest(border.beyond, float(grid[0]), state)
    if value <= grid[0]:
        return border, motions
    numbers = motions.scene.numbers()
    own = {s.name: float(numbers[s]) for s in motions.scene.system.states}
    starts = [{**own, **start} for start in (*motions.starts, state)]
    least = min(value, border.value)
    return border._replace(value=least, beyond=beyond), replace(motions, starts=starts)


def _below(motions: SettlingMotions, border: _Border, low: float) -> ControllerProbe:
    """Return what motions do a little below the border, at a finer tolerance and from starts between the others too."""
    more = replace(motions, tolerance=_FINER, starts=[*motions.starts, *_between(motions.starts)])
    return _probe(more, max(low, border.value * (1 - _BESIDE)), border.period)


def _range(given: tuple[float, float], name: str) -> tuple[float, float]:
    low, high = (finite(e, f"an end of {name}") for e in pair(given, name))
    if not 0 <= low < high:
        raise SceneError(f"{name} is ({low:g}, {high:g}); give 0 <= low < high")
    return low, high


def _starts(scene: Scene, given: Mapping[Key, Sequence[float]] | None) -> list[dict[str, float]]:
    """Return the starts of the motions; those of the scene's own, in parts, if none are given."""
    states = [s.name for s in scene.system.states]
    if given is None:
        return _parts(scene, _SHARES)
    lists = {name_of(k): v for k, v in mapped(given, "starts", "{'x': [0.1, 1.0]}").items()}
    for n, values in lists.items():
        if n not in states:
            raise SceneError(f"{n} in starts is no state{nearest(n, states)}")
        lists[n] = [finite(v, f"a start of {n}") for v in listed(values, f"starts of {n}")]
    if not lists or not all(lists.values()):
        raise SceneError("starts names no values; give {'x': [0.1, 1.0]}")
    return grid_of_starts(lists)


def _parts(scene: Scene, shares: Sequence[float]) -> list[dict[str, float]]:
    numbers, n = scene.numbers(), 2 * len(scene.system.q)
    own = {s.name: numbers[s] for s in scene.system.states[:n]}
    if not any(own.values()):
        raise SceneError(
            "the scene starts at rest at zero; give starts={'x': [0.1, 1.0]}, from which motions begin, "
            "or starts={'x': [0.0]} where a reference moves it"
        )
    return [{name: share * v for name, v in own.items()} for share in shares]


def _between(starts: Sequence[Mapping[str, float]]) -> list[dict[str, float]]:
    """Return starts between given ones and the next."""
    return [{n: 0.5 * (a[n] + b[n]) for n in a} for a, b in zip(starts, [*starts[1:], starts[0]], strict=True)]


def _result(
    motions: SettlingMotions, scene: Scene, border: _Border, high: float, below: ControllerProbe, curve: Curve
) -> Design:
    name, value, worst = motions.name, border.value, border.period
    at = "" if worst is None else f" at {motions.period} = {worst:.6g}"
    limited = value >= high
    above = None if limited else _probe(replace(motions, tolerance=_FINER), value * (1 + _BESIDE), worst)
    beside = [Neighbour(f"{name} smaller by {100 * _BESIDE:g} %", below.value, 0.0 if below.settles else 1.0)]
    if above is not None:
        violated = 0.0 if above.settles else 1.0
        beside.append(Neighbour(f"{name} larger by {100 * _BESIDE:g} %", above.value, violated))
    allowed = f"half range {motions.half_range:g} after t = {motions.settle:g}{at}"
    met = allowed if motions.half_range else f"hunting{at}"
    active = f"{name} at its upper bound" if limited else met
    values, placed = {name: value}, motions.placed(value, worst)
    check = ControllerCheck(below, above)
    return design(
        values, value, (active,), scene.where(placed), check, curve, claim="optimal", neighbours=beside, sense=-1
    )


def _probe(motions: SettlingMotions, value: float, period: float | None) -> ControllerProbe:
    left = float(motions.left(np.array([value]), None if period is None else np.array([period]))[0])
    settles = left <= (motions.half_range or motions.settle)
    return ControllerProbe(value, np.nan if period is None else period, left, settles, len(motions.starts))


def _curve(motions: SettlingMotions, grid: np.ndarray, border: _Border, periods: np.ndarray | None) -> Curve:
    if periods is not None:
        marks = (float(border.period or 0.0),)
        return Curve(periods, border.all, border.value, f"{motions.period}", f"largest {motions.name}", marks)
    grid = np.append(grid[grid < border.value], border.value)
    left = motions.left(grid)
    label = f"half range after t = {motions.settle:g}" if motions.half_range else "time of rest"
    y = np.where(np.isfinite(left), left, np.nan)
    return Curve(grid, y, motions.half_range or motions.settle, motions.name, label, (border.value,))
