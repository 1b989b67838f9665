"""Poincare sections: the states of a motion once in every period of the excitation, or where it crosses a surface."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from symfric.axes import Axes
from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import logged
from symfric.model.arguments import is_one_of
from symfric.model.excitation import periodic
from symfric.model.numeric import numeric_function
from symfric.model.outputs import Trajectory, slip
from symfric.model.results import ArrayResult, Drawable, Labelled
from symfric.model.scene import Scene
from symfric.model.symbols import TIME, expression, finite, name_of, nearest, shortened
from symfric.model.units import attributes_of
from symfric.orbits.crossings import crossings
from symfric.orbits.sizes import over_time
from symfric.solve.routes import prepare
from symfric.solve.run import Run, finished

_LATE = 1e-12  # fraction of a period by which a run may end before the last section and still include it


@dataclass(frozen=True, eq=False)
class PoincareSection(ArrayResult, Drawable):
    """A Poincare section: the points of a trajectory on a surface.

    `plot` draws the first velocity against the first coordinate.

    Attributes
    ----------
    times : ndarray, shape (n,)
    states : ndarray, shape (n_x, n)
    names : tuple of str
        Of the states.
    about : str
        Description of the surface.
    drawn : (str, str)
        The first coordinate and the first velocity.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> section = sf.poincare(sf.simulate(belt), "u", after=50.0)
    >>> len(section.times) > 3
    True
    >>> sorted(section.to_dict())
    ['section', 'states', 'times']
    >>> len(section.to_xarray().data_vars) > 0
    True
    >>> ax = section.plot()
    """

    times: np.ndarray
    states: np.ndarray
    names: tuple[str, ...]
    about: str
    drawn: tuple[str, str]
    units: Mapping[str, str] = field(default_factory=dict, repr=False)

    def _labelled(self) -> Labelled:
        data = {n: ("t", row, attributes_of(n, self.units)) for n, row in zip(self.names, self.states, strict=True)}
        return data, {"t": ("t", self.times, attributes_of("t", self.units))}, {"section": self.about}

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the values of a state, shape (n,)."""
        if name not in self.names:
            raise SceneError(f"{name!r} is no state{nearest(name, self.names)}")
        return np.asarray(self.states[self.names.index(name)])

    def _draw(self, ax: Axes | None) -> Axes:
        from symfric.orbits.plotting import plot_section

        return plot_section(self, ax)

    def to_dict(self) -> dict[str, Any]:
        states = dict(zip(self.names, self.states.tolist(), strict=True))
        return {"section": self.about, "times": self.times.tolist(), "states": states}

    def __repr__(self) -> str:
        return f"PoincareSection({self.about}; {self.times.size} points)"


@dataclass(frozen=True)
class Cut:
    """Definition of a section: a surface in the state space, or a phase of the excitation; made by `cut_of`.

    Attributes
    ----------
    about : str
    period : callable or None
        From parameter values by name to the period of the excitation.
    phase : float
        Phase of the excitation as a fraction of its period.
    function : callable or None
        Of the states, time, and the parameters, in the order of the scene.
    direction : int
    """

    about: str
    period: Callable[..., Any] | None
    phase: float
    function: Callable[..., Any] | None = field(repr=False)
    direction: int

    def times(self, values: Mapping[str, float], after: float, end: float) -> np.ndarray:
        """Return when the excitation has the phase of the section, from a time on; for sections of that kind only."""
        assert self.period is not None
        period = self.period(values)
        first, last = after / period - self.phase, end / period - self.phase
        turns = np.arange(max(0, np.ceil(first - _LATE)), np.floor(last + _LATE) + 1)
        return np.asarray(np.minimum((turns + self.phase) * period, end))

    def points(self, run: Run, after: float) -> tuple[np.ndarray, np.ndarray]:
        """Return times (n,) and states (n_x, n) of a run on the section, from a time on."""
        values = {s.name: v for s, v in run.base.parameter_values().items()}
        values |= {name_of(k): v for k, v in run.values.items()}
        if self.period:
            times = self.times(values, after, run.t_final)
            return times, run(times)
        assert self.function is not None
        numbers, height = [values[s.name] for s in run.base.parameters], self.function
        largest = np.max(np.abs(run.x), axis=1)
        sizes = over_time(largest, len(run.base.system.q), run.t_final)
        return crossings(run.path, lambda x, t: height(*x, t, *numbers), self.direction, after, sizes)


@alone(SYMBOLIC)
def cut_of(
    scene: Scene,
    section: sp.Expr | str | None,
    level: float,
    direction: int,
    phase: float,
    varied: frozenset[str] = frozenset(),
) -> Cut:
    """Check the arguments of `poincare` and return its section; `varied` are parameters that will not stay zero."""
    level, phase = finite(level, "level"), finite(phase, "phase")
    if not is_one_of(direction, (-1, 0, 1)):
        raise SceneError(f"direction is {shortened(direction)}; give 1 (rising), -1 (falling) or 0 (both)")
    if section is None:
        excitation = periodic(scene, varied)
        if excitation is None:
            u = scene.system.u[0]
            raise SceneError(f"nothing depends on time; give a section, such as section={u.name!r} for turning points")
        if not 0 <= phase < 1:
            raise SceneError(f"phase is {phase:g}; give a fraction of the period, at least 0 and below 1")
        return Cut(f"phase {phase:g} of the period of the excitation", excitation.period, phase, None, 0)
    surface = _read(scene, section)
    ways = {1: "rising", -1: "falling", 0: "either way"}
    symbols = *scene.system.states, TIME, *scene.parameters
    function = numeric_function(symbols, surface - level)
    return Cut(f"{surface} = {level:g}, {ways[direction]}", None, 0.0, function, direction)


def _read(scene: Scene, section: sp.Expr | str) -> sp.Expr:
    """Return the expression of a section in the scene's own symbols."""
    states = {s.name: s for s in scene.system.states}
    if isinstance(section, str):
        if section not in states:
            raise SceneError(f"the section {shortened(section)} is no state{nearest(section, states)}")
        return states[section]
    section = expression(section, "the section")
    section = section.xreplace({slip(c.name): c.slip for c in scene.contacts})
    known = states | {s.name: s for s in (TIME, *scene.parameters)}
    for s in sorted(section.free_symbols, key=str):
        if s.name not in known:
            raise SceneError(f"{s} in the section is neither a state nor a parameter{nearest(s.name, known)}")
    section = section.xreplace({s: known[s.name] for s in section.free_symbols})
    if not section.free_symbols & set(states.values()):
        raise SceneError(f"the section {section} holds no state; give an expression that the motion changes")
    return section


@logged
def poincare(
    motion: Run | Scene,
    section: sp.Expr | str | None = None,
    *,
    level: float = 0.0,
    direction: int = 1,
    phase: float = 0.0,
    after: float = 0.0,
    tolerance: float = 1e-9,
) -> PoincareSection:
    """Compute a Poincare section: the points of a trajectory on a surface or at a phase of the excitation.

    Parameters
    ----------
    motion : Run or Scene
        A run with its trajectory; a scene is run.
    section : expression or name of a state, optional
        Where it passes `level`; it may hold states, time, parameters and ``sf.slip("contact")``. A velocity is zero
        where its coordinate turns. Without it the motion is looked at once in every period of the excitation.
    level : float
        In units of the section.
    direction : int
        1 where the section rises, -1 where it falls, 0 for both.
    phase : float
        Phase of the excitation as a fraction of its period; without a section only.
    after : float
        Time that is left out, such as a transient.
    tolerance : float
        Of the run of a scene.

    Returns
    -------
    PoincareSection

    Raises
    ------
    SceneError
        If the section cannot be read, nothing depends on time and there is none, or the run kept no trajectory.
    RunFailed
        If the run of a scene ends early.

    Notes
    -----
    Crossings are roots of the dense output, to rounding, and none is missed; see `symfric.orbits.crossings`.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> section = sf.poincare(sf.simulate(belt), "u", after=50.0)
    >>> section.states.shape[0]
    2
    """
    if not isinstance(motion, Run | Scene):
        raise SceneError(f"{shortened(motion)} is neither a run nor an sf.Scene")
    cut = cut_of(motion.scene if isinstance(motion, Run) else motion, section, level, direction, phase)
    after = finite(after, "after")
    if isinstance(motion, Run):
        run = motion
    else:
        run = finished(prepare(motion.wanting({"path": Trajectory()}), tolerance).run())
    if not 0 <= after < run.t_final:
        raise SceneError(f"after is {after:g}; the run covers 0 to {run.t_final:g}")
    system = run.base.system
    times, states = cut.points(run, after)
    return PoincareSection(times, states, run.names, cut.about, (system.q[0].name, system.u[0].name), run.base.units)
