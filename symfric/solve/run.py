"""Result of a run: numbers, status, and the trajectory if it is an output."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from symfric.errors import RunFailed, SceneError
from symfric.lower.mode_layout import OPEN
from symfric.model.notebook import changes_of_mode, html_table
from symfric.model.results import ArrayResult, Labelled
from symfric.model.scene import Scene
from symfric.model.springs import in_order
from symfric.model.symbols import Key, name_of, nearest, numbers_of
from symfric.model.units import attributes_of, output_unit, with_unit
from symfric.solve.path import Path
from symfric.solve.sensitivities import Derivatives
from symfric.solve.status import ADVICE, Status, early_end
from symfric.spelling import spelt

if TYPE_CHECKING:
    from os import PathLike

    from matplotlib.animation import FuncAnimation

    from symfric.solve.protocol import Route


@dataclass(frozen=True)
class Event:
    """A change of the mode of one contact; what held variables and resets do is in `Run.jumps`.

    Attributes
    ----------
    t : float
    contact : str
    before, after : int
        Modes: -1 slips backward, 0 sticks, +1 slips forward, 2 is open.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> sf.simulate(belt).events[0]
    Event(t=0.6138824896007392, contact='belt', kind='stick', before=-1, after=0)
    """

    t: float
    contact: str
    before: int
    after: int

    @property
    def kind(self) -> str:
        """'stick', 'slip' (a release), 'reverse', 'open', 'close', or 'impact' (of a contact that opens again)."""
        if OPEN in (self.before, self.after):
            return "impact" if self.before == self.after else "open" if self.after == OPEN else "close"
        if self.after == 0:
            return "stick"
        return "slip" if self.before == 0 else "reverse"

    def __repr__(self) -> str:
        modes = f"before={self.before}, after={self.after}"
        return f"Event(t={self.t!r}, contact={self.contact!r}, kind={self.kind!r}, {modes})"


class Raw(NamedTuple):
    """Unprocessed result of a route; a tuple, because one is created at every call.

    Attributes
    ----------
    rows : dict of str to value
        The accumulated observable of each output of an expression; see `symfric.model.outputs.OutputOfExpression`.
    rest : float
        Time since which the system has been at rest, NaN if it moves.
    path : Path or None
    events : tuple of arrays (n,), (n, 3), or None
        Times; contact, mode before, mode after.
    derivatives : Derivatives or None
    """

    rows: dict[str, Any]
    rest: float
    path: Path | None
    events: tuple[np.ndarray, np.ndarray] | None
    derivatives: Derivatives | None = None


@dataclass(frozen=True, eq=False, init=False)
class Run(ArrayResult):
    """Result of one simulation.

    Attributes
    ----------
    base : Scene
        The prepared scene; `scene` is the same with the values and the start of this run.
    values, initial : dict
        Changes of this run.
    settings : Exact, Taylor or Integrators
        Solver settings; `route` is the name of the route.
    tolerance : float
    final : ndarray, shape (n_x,)
        State ``[q; u; z]`` at `t_final`.
    t_final : float
    status : Status
        OK, or why it ended early; see `advice`.
    stats : dict
        Counts of steps, events, kinks and grazes; a graze is an event or an instant that changes no mode.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> run = sf.simulate(belt).checked()
    >>> run.t_final, run.status.name, run.route
    (100.0, 'OK', 'taylor')
    >>> run.energy_residual() < 1e-6
    True
    >>> run["x"].shape == run.t.shape
    True
    >>> sorted(run.to_dict())[:3]
    ['final', 'outputs', 'route']
    >>> list(run.to_xarray().data_vars)
    ['x', 'u', 'mode_belt']
    >>> ax = run.plot()
    """

    base: Scene = field(repr=False)
    values: dict[Key, float]
    initial: dict[Key, float]
    settings: "Route"
    tolerance: float
    final: np.ndarray
    t_final: float
    status: Status
    stats: dict[str, float]
    raw: Raw = field(repr=False)

    def _labelled(self) -> Labelled:
        units = self.base.units
        data: dict = {n: ("t", row, attributes_of(n, units)) for n, row in zip(self.names, self.x, strict=True)}
        data |= {f"mode_{c.name}": ("t", row) for c, row in zip(self.base.contacts, self.mode, strict=True)}
        times = {"t": ("t", self.t, attributes_of("t", units))}
        return data, times, {"status": self.status.name, "route": self.route}

    def __init__(
        self,
        base: Scene,
        values: dict[Key, float],
        initial: dict[Key, float],
        settings: "Route",
        tolerance: float,
        final: np.ndarray,
        t_final: float,
        status: Status,
        stats: dict[str, float],
        raw: Raw,
    ) -> None:
        # all fields at once: setting them one by one, as frozen dataclasses do, takes 5 % of the time of a short run
        fields = {
            "base": base,
            "values": values,
            "initial": initial,
            "settings": settings,
            "tolerance": tolerance,
            "final": final,
            "t_final": t_final,
            "status": status,
            "stats": stats,
            "raw": raw,
        }
        object.__setattr__(self, "__dict__", fields)

    @cached_property
    def scene(self) -> Scene:
        """The scene with the values and the start of this run."""
        scene = self.base.where(self.values) if self.values else self.base
        return scene.starting(self.initial) if self.initial else scene

    @property
    def route(self) -> str:
        """Name of the route."""
        return self.settings.name

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the states, in the order of the rows of `x`."""
        return tuple(s.name for s in self.base.system.states)

    @property
    def advice(self) -> str:
        """What to do about the status; empty if all is well."""
        if self.status == Status.NO_DERIVATIVE and self.raw.derivatives is not None:
            void = ", ".join(("the final state", *self.raw.derivatives.void))
            return f"{ADVICE[self.status]}; void are those of {void}"
        return ADVICE[self.status]

    def checked(self) -> "Run":
        """Return self; raise `RunFailed` with advice if the run ended before its horizon.

        Returns
        -------
        Run

        Raises
        ------
        RunFailed
            If the status is not OK; says what to do.
        """
        if self.status != Status.OK:
            raise RunFailed(f"{self.status.name} at t = {self.t_final:.9g}: {self.advice}")
        return self

    @property
    def path(self) -> Path:
        """The trajectory as piecewise polynomials; raises `SceneError` if it was not stored."""
        if self.raw.path is None:
            raise SceneError(
                "no motion was kept; add 'path': sf.Trajectory() to the outputs, with scene.wanting({...})"
            )
        return self.raw.path

    @cached_property
    def t(self) -> np.ndarray:
        """Times of the steps and of every event, shape (n_t,)."""
        path = self.path
        return np.append(path.t, self.t_final)

    @cached_property
    def x(self) -> np.ndarray:
        """States at the times `t`, shape (n_x, n_t)."""
        return np.column_stack([self.path.coefficients[:, :, 0].T, self.final])

    @cached_property
    def _numbered(self) -> list[str]:
        """Names of the contacts as the loops number them."""
        return [c.name for c in in_order(self.base.contacts)]

    @cached_property
    def mode(self) -> np.ndarray:
        """Modes from each time on, shape (n_contacts, n_t): -1 slips backward, 0 sticks, +1 forward, 2 is open."""
        places = [self._numbered.index(c.name) for c in self.base.contacts]
        mode = self.path.mode.T[places]
        return np.column_stack([mode, mode[:, -1:]]) if mode.shape[1] else mode

    def __call__(self, t: npt.ArrayLike) -> np.ndarray:
        """Return the state at times t by dense output, shape (n_x, ...).

        At a jump of a held variable or a reset it is the state after it, as in `x`; `before` is the one before it.

        Raises
        ------
        SceneError
            If the trajectory is not an output, or a time lies outside the run.
        """
        t = self._within(t)
        return self.path(t) if self.path.t.size else self._still(t)

    def before(self, t: npt.ArrayLike) -> np.ndarray:
        """Return the state just before times t, shape (n_x, ...); only at jumps it differs from `run(t)`.

        Parameters
        ----------
        t : array_like of float
            Such as `jumps`.

        Returns
        -------
        ndarray

        Raises
        ------
        SceneError
            If the trajectory is not an output, or a time lies outside the run.

        Examples
        --------
        >>> import sympy as sp
        >>> import symfric as sf
        >>> x, u = sp.symbols("x u", real=True)
        >>> kick = sf.Reset(at=[1.0], set={u: u + 3})
        >>> scene = sf.Scene(sf.System([x], [u], [[1]], [0]), [], {}, {x: 0, u: 1}, 2.0, resets=[kick])
        >>> run = sf.simulate(scene)
        >>> run.before(1.0)[1].item(), run(1.0)[1].item(), run.jumps
        (1.0, 4.0, array([1.]))
        """
        t = self._within(t)
        return self.path.before(t) if self.path.t.size else self._still(t)

    @property
    def jumps(self) -> np.ndarray:
        """Times at which any state jumps, shape (n,): held variables that change, and resets."""
        return self.path.t[self.path.jumps]

    def jumps_of(self, state: Key) -> np.ndarray:
        """Return the times at which one state jumps: its resets, or the changes of a held variable.

        Parameters
        ----------
        state : Symbol or str

        Returns
        -------
        ndarray, shape (n,)
            Changes below a millionth of the largest value are none.

        Raises
        ------
        SceneError
            If there is no such state.

        Examples
        --------
        >>> import sympy as sp
        >>> import symfric as sf
        >>> x, u = sp.symbols("x u", real=True)
        >>> bounce = sf.Reset(guard=x, set={u: -u / 2})
        >>> ball = sf.Scene(sf.System([x], [u], [[1]], [-1]), initial={x: 0.5, u: 0}, horizon=2.4, resets=[bounce])
        >>> sf.simulate(ball).jumps_of("u")
        array([1., 2.])
        """
        name = name_of(state)
        if name not in self.names:
            raise SceneError(f"{name!r} is no state{nearest(name, self.names)}")
        return self.path.t[self.path.jumps_of(self.names.index(name))]

    def _within(self, t: npt.ArrayLike) -> np.ndarray:
        """Return times as an array; raise on one outside the run."""
        times = numbers_of(t, "t")
        if times.size and not (np.min(times) >= 0 and np.max(times) <= self.t_final * (1 + 1e-15)):
            raise SceneError(f"the run covers 0 to {self.t_final:g}; asked for {np.min(times):g} to {np.max(times):g}")
        return times

    def _still(self, t: np.ndarray) -> np.ndarray:
        """Return the states of a run that failed in its first step."""
        return np.multiply.outer(self.final, np.ones(t.shape))

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Changes of mode in the order of time, without the initial mode.

        Raises
        ------
        SceneError
            If neither `Trajectory` nor `Events` is an output; their number is in `stats` in any case.
        """
        if self.raw.events is None:
            raise SceneError("no events were kept; want them with outputs={'events': sf.Events()}")
        contacts = self._numbered
        rows = sorted(zip(*self.raw.events, strict=True), key=lambda row: float(row[0]))  # the end of bounces is late
        return tuple(Event(float(t), contacts[i], int(a), int(b)) for t, (i, a, b) in rows)

    @cached_property
    def outputs(self) -> dict[str, Any]:
        """The outputs of the scene, by name."""
        return {name: output.value(self, name) for name, output in self.base.outputs.items()}

    def __getitem__(self, name: str) -> Any:
        """Return an output by its name, or a state's values at the times `t`."""
        if name in self.base.outputs:
            return self.base.outputs[name].value(self, name)
        if name in self.names:
            return self.x[self.names.index(name)]
        raise SceneError(f"{name!r} is neither an output nor a state{nearest(name, [*self.base.outputs, *self.names])}")

    @property
    def sensitivities(self) -> dict[str, np.ndarray]:
        """Derivatives of the final state, shape (n_x,), by parameters or by initial values of states."""
        return self._derivatives().final

    @cached_property
    def output_sensitivities(self) -> dict[str, dict[str, float]]:
        """Derivatives of the scalar outputs, indexed as ``[output][name]`` or ``[name][output]``."""
        rows = self._derivatives().outputs
        columns = {name: {o: row[name] for o, row in rows.items()} for name in self.sensitivities}
        return {**columns, **rows}

    @property
    def second_sensitivities(self) -> dict[tuple[str, str], np.ndarray]:
        """Second derivatives of the final state, shape (n_x,), by pairs of names; NaN if an event occurred."""
        return self._derivatives().second

    @property
    def second_output_sensitivities(self) -> dict[str, dict[tuple[str, str], float]]:
        """Second derivatives of integrals and of values at a time, by output and by pairs of names."""
        return self._derivatives().second_outputs

    def _derivatives(self) -> Derivatives:
        if self.raw.derivatives is None:
            raise SceneError("no derivatives were computed; ask for them with simulate(..., sensitivities=['name'])")
        return self.raw.derivatives

    def energy_residual(self) -> float:
        """Return the relative imbalance of energy, dimensionless; see `symfric.solve.energy`.

        Returns
        -------
        float
        """
        from symfric.solve.energy import energy_residual

        return energy_residual(self)

    def to_dict(self) -> dict[str, Any]:
        told = {"route": self.route, "status": self.status.name, "t_final": self.t_final}
        final = dict(zip(self.names, self.final.tolist(), strict=True))
        scalars = {k: v for k, v in self.outputs.items() if isinstance(v, float)}
        return {**told, "final": final, "outputs": scalars, "stats": dict(self.stats)}

    @spelt
    def plot(self, ax: Any = None, units: Mapping[str, str] | None = None) -> Any:
        """Draw the coordinates against time; return the Axes.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw; a new figure unless given.
        units : mapping of str to str, optional
            Of coordinates and of t, for the axes; those of the scene unless given.

        Returns
        -------
        matplotlib Axes
        """
        from symfric.solve.plotting import plot_run

        return plot_run(self, ax, self.base.units if units is None else units)

    @spelt
    def animate(
        self,
        path: "str | PathLike[str] | None" = None,
        *,
        begin: float = 0.0,
        end: float | None = None,
        seconds: float = 6.0,
        frames_per_second: int = 25,
    ) -> "FuncAnimation":
        """Return an animation of the motion: the coordinates in time beside the phase portrait of the first one.

        Parameters
        ----------
        path : path, optional
            Where to save it, a ``.gif``, or with ffmpeg a ``.mp4``, ``.webm`` or ``.mov``.
        begin, end : float
            Part of the run that is shown; all of it unless given.
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
            If no trajectory was stored, the part is outside the run, or the file cannot be written.

        Examples
        --------
        >>> import symfric as sf
        >>> import tempfile
        >>> run = sf.simulate(sf.scenes.mass_on_belt(v_b=0.2, horizon=30.0))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     animation = run.animate(f"{folder}/belt.gif", begin=20.0, seconds=1.0, frames_per_second=5)
        """
        from symfric.solve.animation import animate_run

        return animate_run(self, path, begin, self.t_final if end is None else end, seconds, frames_per_second)

    def _repr_html_(self) -> str:
        shown: dict[str, Any] = self.to_dict()
        units = self.base.units
        named = {n: output_unit(units, o) for n, o in self.base.outputs.items()}
        final, outputs = (shown.pop(k) for k in ("final", "outputs"))
        shown[f"t_final{with_unit('t', units)}"] = shown.pop("t_final")
        shown["final"] = {n + with_unit(n, units): v for n, v in final.items()}
        shown["outputs"] = {n + with_unit(n, named): v for n, v in outputs.items()}
        return html_table("Run", {**shown, "events": changes_of_mode(self.events)})

    def __repr__(self) -> str:
        events = int(self.stats.get("events", 0))
        return f"Run({self.status.name}, {self.route}, t_final={self.t_final:g}, {events} events)"


def finished(run: Run) -> Run:
    """Return a run inside another function; raise `RunFailed` with what the caller of that function can do.

    Parameters
    ----------
    run : Run
    """
    if run.status != Status.OK:
        raise RunFailed(f"{early_end('a run', run.status)} (at t = {run.t_final:.9g})")
    return run
