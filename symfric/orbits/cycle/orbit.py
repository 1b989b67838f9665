"""A periodic orbit as a result: its numbers, its motion, its pictures."""

from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from symfric.axes import Axes
from symfric.errors import SceneError
from symfric.model.notebook import changes_of_mode, columns, html_table
from symfric.model.outputs import Trajectory
from symfric.model.results import COMPLEX, Drawable, Result, as_plain
from symfric.model.scene import Scene
from symfric.model.units import with_unit
from symfric.solve.routes import prepare
from symfric.solve.run import Event, Run
from symfric.spelling import spelt

if TYPE_CHECKING:
    from os import PathLike

    import xarray as xr
    from matplotlib.animation import FuncAnimation


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

    @spelt
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
