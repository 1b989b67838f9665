"""A scene in steps of fixed length: its functions with the names of their inputs and outputs."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.export.step_function import LOST_CONTACT, MANY_EVENTS, NOT_FINITE, OK, StepFunctions, step_functions
from symfric.locks import SYMBOLIC, alone
from symfric.model.held import Held
from symfric.model.in_plane import refuse_planes
from symfric.model.outputs import OF_CONTACTS, Trajectory, friction_force, slip
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import TIME, Key, expression, finite, name_of, nearest, shortened
from symfric.model.system import Contact
from symfric.model.units import attributes_of
from symfric.solve.routes import simulate

if TYPE_CHECKING:
    import xarray

_MOST_STEPS, _MOST_ASKED = 50_000, 10_000_000  # up to the horizon of the scene, and up to a time that is asked for
_MOST_EVENTS = 100  # of one step, each with its own code
_TOLERANCE = 1e-11  # of the event-driven solution that steps are compared with
_LATE = 1e-12  # relative to the end, by which a time may be rounded
#: What the status of a step says.
MEANING = {
    OK: "right",
    MANY_EVENTS: "more events in a step than it can resolve; the rest of the step is of first order",
    LOST_CONTACT: "a normal load became negative: the surfaces would separate",
    NOT_FINITE: "the state is not finite: the step is too long for the fastest motion, or more values of a held "
    "variable are on their way than it has room for (waiting)",
}


@dataclass(frozen=True, eq=False)
class Stepper:
    """A scene simulated in steps of fixed length; made by `stepper`.

    Attributes
    ----------
    scene : Scene
    step : float
        Length of a step, in units of time.
    states, parameters, inputs, contacts : tuple of str
        Names, in the order of the arrays.
    outputs : dict of str to Expr
        What a step shows besides the states.
    start, advance, look : casadi.Function
        ``(y, t, p, v, dv) -> (y, m)``, the modes at a state; ``(y, m, t, p, v, dv, h) -> (y, m, status)``, a time h
        later; ``(y, m, t, p, v) -> (outputs, modes)``. y is the state, m the memory between steps, p the parameters, v
        and dv the sampled inputs and their slopes. Status 0 is right; see `write_c` for the others.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.export.stepper(sf.scenes.mass_on_belt(v_b=0.2), step=0.05)
    >>> belt
    Stepper(step 0.05; states x, u; parameters v_b, beta, gamma2, a, Omega; outputs belt.slip, belt.friction)
    >>> run = belt.run(until=10.0)
    >>> dict(run.sizes)
    {'state': 2, 't': 201, 'contact': 1}
    >>> belt.error(until=10.0) < 1e-6
    True
    """

    scene: Scene
    step: float
    states: tuple[str, ...]
    parameters: tuple[str, ...]
    inputs: tuple[str, ...]
    contacts: tuple[str, ...]
    outputs: Mapping[str, sp.Expr]
    start: ca.Function = field(repr=False)
    advance: ca.Function = field(repr=False)
    look: ca.Function = field(repr=False)

    @property
    def values(self) -> np.ndarray:
        """The scene's own values of the parameters."""
        own = {s.name: v for s, v in self.scene.parameter_values().items()}
        return np.array([own[n] for n in self.parameters])

    @property
    def initial(self) -> np.ndarray:
        """The scene's own start."""
        numbers = self.scene.numbers()
        return np.array([numbers[s] for s in self.scene.system.states])

    def run(
        self,
        values: Mapping[Key, float] | None = None,
        initial: Mapping[Key, float] | None = None,
        until: float | None = None,
    ) -> "xarray.Dataset":
        """Run step by step, with the numbers that the C code computes.

        Parameters
        ----------
        values, initial : mapping of symbol or name to number
            Changes to the scene's own.
        until : float, optional
            End of the run; the scene's horizon unless given, rounded to whole steps.

        Returns
        -------
        xarray.Dataset
            ``x`` (state, t), ``mode`` (contact, t), every output (t), and ``status`` (t) of the step that ended there.

        Raises
        ------
        SceneError
            If a name is unknown.

        Examples
        --------
        >>> import symfric as sf
        >>> run = sf.export.stepper(sf.scenes.mass_on_belt(v_b=0.2), step=0.05).run({"v_b": 0.3}, until=5.0)
        >>> int(run.status.max())
        0
        """
        import xarray as xr

        p = _changed(self.values, self.parameters, values, "parameter")
        y = _changed(self.initial, self.states, initial, "state")
        t, x, memory, status = self._march(y, p, self._steps(until))
        shown = [self.look(x[:, k], memory[:, k], t[k], p, self._inputs(t[k])) for k in range(t.size)]
        rows = np.array([np.array(e[0]).ravel() for e in shown]).reshape(t.size, -1)
        modes = np.array([np.array(e[1]).ravel() for e in shown], dtype=int).reshape(t.size, -1)
        units = self.scene.units
        data: dict[str, Any] = {"x": (("state", "t"), x), "mode": (("contact", "t"), modes.T), "status": ("t", status)}
        for k, (name, e) in enumerate(self.outputs.items()):
            data[name] = ("t", rows[:, k], {"units": units.of(e)} if units.of(e) else {})
        times = ("t", t, attributes_of("t", units))
        return xr.Dataset(data, {"t": times, "state": list(self.states), "contact": list(self.contacts)})

    def error(self, until: float | None = None) -> float:
        """Return the largest difference from the event-driven solution, over the largest magnitude of each state.

        Parameters
        ----------
        until : float, optional
            End of the comparison; the scene's horizon unless given, and at most 50000 steps.

        Returns
        -------
        float
            Infinite if the steps leave the finite numbers.

        Raises
        ------
        RunFailed
            If the event-driven solution fails.

        Examples
        --------
        >>> import symfric as sf
        >>> scene = sf.scenes.mass_on_belt(v_b=0.2)
        >>> coarse, fine = (sf.export.stepper(scene, h).error(until=10.0) for h in (0.1, 0.05))
        >>> 12 < coarse / fine < 20
        True
        """
        n = self._steps(until)
        end, late = n * self.step, 0.0
        if self.scene.clocks:  # a step ends after the samples of the same instant
            end, late = end + 0.5 * self.step, _LATE * end
        run = simulate(self.scene.until(end, {"path": Trajectory()}), _TOLERANCE).checked()
        t, x, _, _ = self._march(self.initial, self.values, n)
        t, x = t[1:], x[:, 1:]  # at the start a crossing may be to come
        exact = run(t + late)
        if not np.all(np.isfinite(x)):
            return math.inf
        sizes = np.maximum(np.max(np.abs(exact), axis=1), 1e-300)
        return float(np.max(np.max(np.abs(x - exact), axis=1) / sizes))

    def _steps(self, until: float | None) -> int:
        if until is None:
            return min(max(1, round(self.scene.horizon / self.step)), _MOST_STEPS)
        end = finite(until, "until")
        if not 0 < end / self.step <= _MOST_ASKED:
            raise SceneError(
                f"until is {end:g}, {end / self.step:.6g} steps; it must be positive, and at most {_MOST_ASKED} steps"
            )
        return max(1, round(end / self.step))

    def _inputs(self, t: float) -> np.ndarray:
        return np.array([float(s(t)) for s in self.scene.inputs.values()])

    def _slopes(self, t: float, v: np.ndarray) -> np.ndarray:
        """Return the slopes of the inputs over the step from t, where they are v; those that are held have none."""
        held = np.array([s.hold for s in self.scene.inputs.values()], dtype=bool)
        return np.where(held, 0.0, (self._inputs(t + self.step) - v) / self.step)

    def _march(self, y: np.ndarray, p: np.ndarray, n: int) -> tuple[np.ndarray, ...]:
        """Return times, states, memories and statuses of n steps; inputs are linear over each step, or held."""
        h, v = self.step, self._inputs(0.0)
        dv = self._slopes(0.0, v)
        first, m = (np.array(e).ravel() for e in self.start(y, 0.0, p, v, dv))
        t, x = h * np.arange(n + 1), np.empty((n + 1, y.size))
        memory, status = np.empty((n + 1, m.size)), np.zeros(n + 1)
        x[0], memory[0] = first, m
        buffer: tuple[Any, Any] = self.advance.buffer()
        evaluate, call = buffer
        now, state, kept = np.zeros(1), first.copy(), m.copy()
        after, later, code = np.empty_like(state), np.empty_like(kept), np.zeros(1)
        slots: tuple[Any, ...] = (state, kept, now, p, v, dv, np.array([h]))
        for k, array in enumerate(slots):
            evaluate.set_arg(k, memoryview(array))
        results: tuple[Any, ...] = after, later, code
        for k, array in enumerate(results):
            evaluate.set_res(k, memoryview(array))
        for k in range(n):
            now[0] = t[k]
            if v.size:
                v[:] = self._inputs(t[k])
                dv[:] = self._slopes(t[k], v)
            call()
            x[k + 1], memory[k + 1], status[k + 1] = after, later, code[0]
            state[:], kept[:] = after, later
        return t, x.T, memory.T, status.astype(int)

    def __repr__(self) -> str:
        parts = [f"step {self.step:g}", f"states {', '.join(self.states)}"]
        named = {"parameters": self.parameters, "inputs": self.inputs, "outputs": tuple(self.outputs)}
        parts += [f"{kind} {', '.join(names)}" for kind, names in named.items() if names]
        return f"Stepper({'; '.join(parts)})"


def _changed(own: np.ndarray, names: tuple[str, ...], given: Mapping[Key, float] | None, kind: str) -> np.ndarray:
    numbers = own.copy()
    for key, value in (given or {}).items():
        name = name_of(key)
        if name not in names:
            raise SceneError(f"{name} is no {kind}{nearest(name, names)}")
        numbers[names.index(name)] = finite(value, f"the value of {name}")
    return numbers


@alone(SYMBOLIC)
def stepper(scene: Scene, step: float, outputs: Mapping[str, sp.Expr] | None = None, events: int = 4) -> Stepper:
    """Make a stepper of a scene: steps of fixed length, for real time, C code and co-simulation.

    Parameters
    ----------
    scene : Scene
    step : float
        Length of a step, > 0, in units of time; short against the fastest motion of the scene.
    outputs : mapping of str to Expr, optional
        What a step shows besides the states; slip and friction force of every contact unless given.
    events : int
        Most events in one step, from 1 to 100, which bounds the time that it takes.

    Returns
    -------
    Stepper

    Raises
    ------
    SceneError
        If the step is not positive, a value is missing, an output has an unknown symbol, contacts can hold the same
        motion, a friction profile jumps, a law has an infinite slope (as averaged ones have), or more samples of a
        held variable fall into a step than the events that it takes.

    Notes
    -----
    Between events Runge and Kutta's classical formula; the time of an event inside a step is found to rounding by the
    same formula, and there the mode changes. Errors fall with the fourth power of the step, through stick and slip, as
    long as the events of one contact are further apart than a step. Samples of held variables, dead times and resets
    happen at their instants, also within a step; those whose instant is the end of a step belong to it. Where an
    expression of a held variable or a reset crosses zero is found like every event; a bounce, which falls to zero and
    rises from it, takes two. The formula is explicit: of a motion with the fast frequency omega or rate r it needs
    ``step < 2.8 / omega`` or ``2.8 / r``. After the last event that is allowed, the rest of the step is of first
    order, and its status 1.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.mass_on_belt(v_b=0.2)
    >>> x = scene.system.q[0]
    >>> sf.export.stepper(scene, 0.05, {"spring": -x}).run(until=1.0).spring.shape
    (21,)
    """
    length = finite(step, "step")
    if length <= 0:
        raise SceneError(f"step is {length:g}; it must be positive")
    if not isinstance(events, int) or isinstance(events, bool) or not 1 <= events <= _MOST_EVENTS:
        raise SceneError(f"events is {shortened(events)}; give a whole number from 1 to {_MOST_EVENTS}")
    check_scene(scene)
    refuse_planes(scene.contacts, "an exported model")
    _check_clocks(scene, length, events)
    shown = _read_outputs(scene, outputs)
    f: StepFunctions = step_functions(scene, list(shown.values()), events)
    return Stepper(
        scene,
        length,
        tuple(s.name for s in scene.system.states),
        tuple(s.name for s in f.automaton.parameters),
        tuple(s.name for s in f.automaton.inputs),
        tuple(c.name for c in (*_along_lines(scene), *scene.contacts_behind_springs)),
        shown,
        f.start,
        f.advance,
        f.look,
    )


def _check_clocks(scene: Scene, step: float, events: int) -> None:
    """Raise if more samples and resets may fall into a step than it takes."""
    numbers = scene.numbers()
    counts = []
    for part in scene.clocks:
        if part.every is not None:
            count = math.ceil(step / float(sp.sympify(part.every).subs(numbers)) * (1 - _LATE))
            counts.append(count * (2 if isinstance(part, Held) and part.late else 1))
    most = max(counts, default=0)
    if most > events:
        raise SceneError(
            f"a step of {step:g} is longer than the periods of held variables and resets: {most} of their instants "
            f"fall into it, and it takes events={events}; give a shorter step, or more events"
        )


def _along_lines(scene: Scene) -> list[Contact]:
    return [c for c in scene.contacts if c.along_line]


def _read_outputs(scene: Scene, outputs: Mapping[str, sp.Expr] | None) -> dict[str, sp.Expr]:
    if outputs is None:
        kinds = {"slip": slip, "friction": friction_force}
        return {f"{c.name}.{word}": make(c.name) for c in scene.contacts for word, make in kinds.items()}
    if not isinstance(outputs, Mapping):
        raise SceneError(f"outputs is {shortened(outputs)}; give a mapping of names to expressions, {{'pull': -k*x}}")
    known = {s.name for s in (*scene.system.states, *scene.system.rows, *scene.parameters, *scene.inputs, TIME)}
    known |= {make(c.name).name for c in scene.contacts for make in OF_CONTACTS.values()}
    shown = {}
    for name, given in outputs.items():
        shown[name] = e = expression(given, f"output {name!r}")
        strange = next((s.name for s in e.free_symbols if s.name not in known), None)
        if strange:
            raise SceneError(f"output {name!r} contains {strange}, which the scene lacks{nearest(strange, known)}")
    return shown
