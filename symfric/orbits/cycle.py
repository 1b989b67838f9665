"""Limit cycles of stick-slip motion, stable and unstable, and their Floquet multipliers."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.axes import Axes
from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged, tell
from symfric.lower.mode_layout import OPEN
from symfric.model.notebook import changes_of_mode, columns, html_table
from symfric.model.outputs import Trajectory
from symfric.model.results import COMPLEX, Drawable, Result, as_plain
from symfric.model.scene import Scene, check_scene
from symfric.model.units import with_unit
from symfric.orbits.flow_map import FlowMap, flow_of
from symfric.orbits.guess import Fades, Guess, settled
from symfric.orbits.passages import Passage
from symfric.orbits.shooting import Point, ShootingSystem, solve
from symfric.solve.routes import prepare
from symfric.solve.run import Event, Run

if TYPE_CHECKING:
    from os import PathLike

    import xarray as xr
    from matplotlib.animation import FuncAnimation

_VANISHED = 1e-6  # range relative to that of the guess below which Newton's method has found an equilibrium
_SAME = 1e-8  # difference relative to the ranges of the states up to which motions count as one
_ZERO = 1e-11  # relative to the largest: a multiplier below it is zero, its direction lost by sticking
_NEUTRAL = 1e-10  # largest rounding error of a multiplier of 1
_CARRIED = 1e-3  # largest relative change of the rate of the motion under the map over a period
_AT_START = 1e-9  # fraction of the period within which a slip of the size of rounding ends
_PATIENCE = (1, 4, 16, 64)  # horizons of the scene for settling, tried in turn; near a fold settling is slow


@dataclass(frozen=True, eq=False)
class Orbit(Result, Drawable):
    """A periodic orbit (limit cycle) of a scene.

    `plot` draws the phase plane of the first coordinate.

    Attributes
    ----------
    period : float
    start : ndarray, shape (n_x,)
        A state on the orbit; of a forced scene the one at t = 0.
    half_range, x_max, x_min : ndarray, shape (n_x,)
        Half range and extremes of every state, in the order of `names`.
    stick_time : float
        Time in one period during which at least one contact sticks.
    stick_fraction : float
        `stick_time` over `period`.
    multipliers : ndarray, shape (n_x,)
        Floquet multipliers, the trivial one of an autonomous scene first, the others by falling magnitude; a complex
        array if any is. Those that sticking makes zero are exactly zero.
    trivial : int or None
        Index of the multiplier that belongs to a shift of time; None if the scene is forced.
    stable : bool
        Whether all others lie within the unit circle, or on it as that of a body which friction holds for good.
    events : tuple of Event
        Within one period from `start`.
    names : tuple of str
    differentiable : bool
        Whether the multipliers exist: not at a graze, nor where two events come at one time.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> orbit = sf.limit_cycle(belt)
    >>> round(float(orbit.half_range[0]), 6)
    0.286209
    >>> round(orbit.stick_fraction, 6)
    0.239661
    >>> sorted(orbit.to_dict())[:3]
    ['events', 'half_range', 'multipliers']
    >>> len(orbit.to_xarray().data_vars) > 0
    True
    >>> ax = orbit.plot()
    """

    period: float
    start: np.ndarray
    half_range: np.ndarray
    x_max: np.ndarray
    x_min: np.ndarray
    stick_time: float
    stick_fraction: float
    multipliers: np.ndarray = field(metadata=COMPLEX)
    trivial: int | None
    stable: bool
    events: tuple[Event, ...] = field(
        metadata=as_plain(lambda events, _: [[e.t, e.contact, e.before, e.after] for e in events])
    )
    names: tuple[str, ...]
    differentiable: bool
    base: Scene = field(repr=False)
    values: dict[str, float] = field(repr=False)
    _told = (
        "names",
        "period",
        "start",
        "half_range",
        "x_max",
        "x_min",
        "stick_time",
        "stick_fraction",
        "multipliers",
        "stable",
        "events",
    )

    @cached_property
    def scene(self) -> Scene:
        """The scene with the values, the start and the period of the orbit as its own."""
        states = dict(zip(self.base.system.states, self.start.tolist(), strict=True))
        return self.base.where(self.values).starting(states).until(self.period)

    @cached_property
    def run(self) -> Run:
        """The run over one period, with its trajectory."""
        return prepare(self.scene.wanting({"path": Trajectory()}), 1e-12).run()

    def to_xarray(self) -> "xr.Dataset":
        """Return the motion over one period; see `Run.to_xarray`.

        Returns
        -------
        xarray.Dataset
        """
        return self.run.to_xarray()

    def animate(
        self,
        path: "str | PathLike[str] | None" = None,
        *,
        periods: float = 2.0,
        seconds: float = 6.0,
        frames_per_second: int = 25,
    ) -> "FuncAnimation":
        """Return an animation of the orbit: the coordinates in time beside the phase portrait of the first one.

        Parameters
        ----------
        path : path, optional
            Where to save it, a ``.gif``, or with ffmpeg a ``.mp4``, ``.webm`` or ``.mov``.
        periods : float
            How many are shown.
        seconds : float
            Duration of the animation.
        frames_per_second : int

        Returns
        -------
        matplotlib.animation.FuncAnimation
            Keep it in a variable while it is shown; in a notebook, ``HTML(animation.to_jshtml())`` shows it.

        Raises
        ------
        SceneError
            If numbers are not positive, or the file cannot be written.

        Examples
        --------
        >>> import symfric as sf
        >>> import tempfile
        >>> orbit = sf.limit_cycle(sf.scenes.mass_on_belt(v_b=0.2))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     animation = orbit.animate(f"{folder}/orbit.gif", seconds=1.0, frames_per_second=5)
        """
        if not 0.0 < periods < np.inf:
            raise SceneError(f"an animation of {periods:g} periods; it must be a positive number")
        run = prepare(self.scene.until(periods * self.period).wanting({"path": Trajectory()}), 1e-12).run()
        return run.animate(path, seconds=seconds, frames_per_second=frames_per_second)

    def _draw(self, ax: Axes | None) -> Axes:
        from symfric.orbits.plotting import plot_orbit

        return plot_orbit(self, ax)

    def _repr_html_(self) -> str:
        said = partial(with_unit, units=self.base.units)
        names = [n + said(n) for n in self.names]
        rows = zip(names, self.start, self.half_range, self.x_min, self.x_max, strict=True)
        plain = {f"period{said('t')}": self.period, f"stick_time{said('t')}": self.stick_time}
        plain |= {n: getattr(self, n) for n in ("stick_fraction", "stable")}
        shown = {
            "states": columns(
                ("state", "start", "half range", "smallest", "largest"),
                ((n, *map(float, v)) for n, *v in rows),
            ),
            "multipliers": self.multipliers.astype(complex).tolist(),
            "events": changes_of_mode(self.events),
        }
        return html_table("Orbit", plain | shown)

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        return (
            f"Orbit({kind}, period={self.period:.12g}, half_range={self.half_range[0]:.9g}, "
            f"stick_fraction={self.stick_fraction:.6g})"
        )


@logged
def limit_cycle(
    scene: Scene, guess: Orbit | tuple[Sequence[float] | np.ndarray, float] | None = None, tolerance: float = 1e-13
) -> Orbit:
    """Find a periodic orbit of a scene by Newton's method on the map over a period (shooting).

    Parameters
    ----------
    scene : Scene
        Autonomous, or excited by sines and cosines of time with a common period. Its start and horizon matter only
        without a guess: then its motion is followed until it repeats itself, and leads to a stable cycle. Where it
        settles to no cycle, as on a torus or in chaos, the result is one near the motion, with ``stable`` False.
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
        If the motion settles to rest or steady sliding, ends early, or no cycle is found near the guess.
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
    reason, settling, unstable = "", False, None
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
    raise NotFound(reason)


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
    before = system.follow(z) if system.free else None
    closed = solve(system, z, _held(system, z))
    if before is not None and np.all(closed.passage.ranges <= _VANISHED * before.ranges):
        raise NotFound("no limit cycle near the guess: Newton's method leads to steady sliding")
    return orbit_of(scene, *_shortest(system, closed, guess.turns))


def _shortest(system: ShootingSystem, point: Point, turns: int) -> tuple[ShootingSystem, Point]:
    """Return the orbit with its least period."""
    start, period, values = system.unpack(point.z)
    for parts in (k for k in range(turns, 1, -1) if turns % k == 0):
        part = system.flow.run(start, values, period / parts)
        if np.all(np.abs(part.end - start) <= _SAME * point.passage.ranges):
            least = replace(system, multiple=system.multiple // parts)
            z = least.pack(start, period / parts, values)
            return least, solve(least, z, _held(least, z))
    return system, point


def _held(system: ShootingSystem, z: np.ndarray) -> np.ndarray | None:
    """Return the direction of the parameter among the unknowns, which Newton's method holds; None without one."""
    return np.append(np.zeros(z.size - 1), 1.0) if system.flow.parameters else None


def orbit_of(scene: Scene, system: ShootingSystem, point: Point) -> Orbit:
    """Compute the properties of a periodic orbit from a solution of its equations."""
    flow, passage = system.flow, point.passage
    start, period, values = system.unpack(point.z)
    multipliers, trivial = multipliers_of(passage, system.free)
    others = np.delete(multipliers, trivial) if trivial is not None else multipliers
    stops = {k for k in flow.openings if k >= len(flow.lines)}
    stick = stick_time(passage, period, stops)
    return Orbit(
        period=period,
        start=start.copy(),
        half_range=0.5 * (passage.high - passage.low),
        x_max=passage.high,
        x_min=passage.low,
        stick_time=stick,
        stick_fraction=stick / period,
        multipliers=multipliers,
        trivial=trivial,
        stable=bool(np.all(np.abs(others) < 1 + _NEUTRAL)),
        events=tuple(
            Event(t, flow.contacts[i], a, b)
            for t, i, a, b in passage.changes
            # a stick that lasts beyond the end of the period does not begin with it; the slip there is rounding
            if not (b == passage.modes[i] == 0 and t <= _AT_START * period)
        ),
        names=flow.states,
        differentiable=not passage.doubtful,
        base=scene,
        values={n: values[n] for n in flow.parameters},
    )


def multipliers_of(passage: Passage, free: bool) -> tuple[np.ndarray, int | None]:
    """Return the ordered eigenvalues of the monodromy matrix, and the index of the trivial one."""
    eigenvalues = np.linalg.eigvals(passage.by_start)
    eigenvalues = np.where(np.abs(eigenvalues) <= _ZERO * max(1.0, np.max(np.abs(eigenvalues))), 0.0, eigenvalues)
    eigenvalues = eigenvalues[np.argsort(-np.abs(eigenvalues), kind="stable")]
    if free:
        # zero on an exact orbit: the flow maps the rate onto itself
        shift = passage.by_start @ passage.rate - passage.rate
        k = int(np.argmin(np.abs(eigenvalues - 1.0)))
        shift, rate = shift / passage.ranges, passage.rate / passage.ranges
        if np.linalg.norm(shift) <= _CARRIED * np.linalg.norm(rate):
            eigenvalues = np.concatenate([eigenvalues[k : k + 1], np.delete(eigenvalues, k)])
    eigenvalues = eigenvalues.real if np.all(np.abs(eigenvalues.imag) == 0) else eigenvalues
    return eigenvalues, 0 if free else None


def stick_time(passage: Passage, period: float, stops: Collection[int] = ()) -> float:
    """Return the time during which at least one contact sticks; stops, which are closed, do not."""
    modes = [OPEN if k in stops else mode for k, mode in enumerate(passage.modes)]
    changes = [e for e in passage.changes if e[1] not in stops]
    for _, i, before, _ in reversed(changes):
        modes[i] = before
    total, last = 0.0, 0.0
    for t, i, _, after in changes:
        total += (t - last) * (0 in modes)
        modes[i], last = after, t
    return total + (period - last) * (0 in modes)
