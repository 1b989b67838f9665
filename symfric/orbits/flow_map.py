"""Flow map of a scene: the state after a given time, with derivatives by the start, the parameters and the time."""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.lower.automaton import Automaton, lower
from symfric.lower.mode_layout import backward, forward, slip_gap
from symfric.lower.relaxed_guards import lifted, n_lifts
from symfric.model.constant_parameters import vanishing
from symfric.model.excitation import excitation_of
from symfric.model.outputs import End, Trajectory
from symfric.model.rows import RANGE, Row
from symfric.model.scene import Scene
from symfric.model.springs import in_order
from symfric.model.symbols import TIME
from symfric.orbits.passages import Passage, runs_of
from symfric.orbits.stiff_runs import StiffRuns
from symfric.solve.integrators.stiffness import pays
from symfric.solve.lowered import LoweredScene
from symfric.solve.program import Numbers, check_tolerance
from symfric.solve.protocol import Program
from symfric.solve.routes import prepare
from symfric.solve.run import Run

_STRETCHED = 1e-9  # relative difference up to which a spring was stretched by the slip alone
_PEAK = 1e-9  # relative excess of the static over the kinetic coefficient that counts as one
_JUST = 1e-8  # of the time until an event: how long before it derivatives are taken that jump there
_ROUGH = 1e-8  # tolerance of a run that serves as a guess
# largest gap between end and start of a periodic orbit, relative to the range of a state, unless the tolerance of the
# motion is larger, since its steps change with the start; the second one by an implicit integrator
_CLOSED, _CLOSED_IMPLICIT = 1e-12, 1e-8
_MOST_FLOWS, _MOST_MOTIONS = 16, 8  # most programs kept in memory
_FLOWS: dict[tuple[Any, ...], "FlowMap"] = {}  # compiled flow maps by their equations


class Guard(NamedTuple):
    """Value of a guard at one time, and its first and second time derivatives.

    Attributes
    ----------
    left, rate, bend : float
    size : float
        Unit of the guard: for a reserve of static friction, twice the bound; for a slip 1.
    """

    left: float
    rate: float
    bend: float
    size: float


class FlowMap:
    """The compiled flow map of a scene; may be evaluated from any thread.

    Parameters
    ----------
    scene : Scene
        Without sampled inputs; its horizon, start and outputs are not used.
    parameters : sequence of str
        Parameters to differentiate by.
    tolerance : float

    Attributes
    ----------
    closed : float
        Largest gap between end and start of a periodic orbit, relative to the ranges of the states.
    springs : dict of int to ndarray
        Slopes of the slips (n,) that stretch the springs of contacts, by the places of these among the states.
    lines : tuple of Contact
        Those along lines; one in the plane is there twice, once for each component of its slip.
    planes : frozenset of int
        Indices of those in the plane among `lines`.
    openings : tuple of int
        Numbers, in events, of the contacts that open, in the order of the last rows of `Passage.gaps`.
    n_lifts : int
        Number of guard shifts.
    period : callable or None
        From parameter values by name to the period of the excitation; None if nothing depends on time.
    period_by : callable or None
        The same for its derivatives by the parameters of the flow map, (n_p,).
    """

    @alone(SYMBOLIC)
    def __init__(self, scene: Scene, parameters: Sequence[str] = (), tolerance: float = 1e-13):
        excitation = excitation_of(scene, frozenset(parameters))
        if excitation.note:
            raise SceneError(excitation.note)
        self.scene = scene.wanting({"end": End()})
        self.parameters = tuple(parameters)
        self.states = tuple(s.name for s in scene.system.states)
        self.contacts = tuple(c.name for c in in_order(scene.contacts))
        self.lines = tuple(c for c in in_order(scene.contacts) if c.along_line)
        self.planes = frozenset(i for i, c in enumerate(self.lines) if c.in_plane)
        self.tolerance = tolerance
        self.springs = _springs_of(scene)
        rows = [Row(RANGE, s) for s in scene.system.states]
        self._automaton: Automaton = lifted(lower(self.scene, [r.expr for r in rows], frozenset(self.parameters)))
        stiff = is_stiff(self.scene)
        self.closed = _CLOSED_IMPLICIT if stiff else max(_CLOSED, tolerance)
        self._runs = (StiffRuns if stiff else runs_of)(self.scene, self._automaton, self.parameters, tolerance)
        self.n_lifts, self.openings = n_lifts(self._automaton), tuple(self._automaton.layout.shown_openings)
        own = self._automaton.parameters[: len(self._automaton.parameters) - self.n_lifts]
        self._numbers = Numbers(self.scene, own, {s.name: v for s, v in vanishing(self.scene).items()})
        self._guards = _guard_rates(self._automaton)
        self._motions: dict[float, Program] = {}
        self.period: Callable[[Mapping[str, float]], float] | None = None
        self.period_by: Callable[[Mapping[str, float]], np.ndarray] | None = None
        if excitation:
            self.period, self.period_by = excitation.period, partial(excitation.period_by, parameters=self.parameters)

    def motion(self, scene: Scene, horizon: float) -> Run:
        """Simulate a scene that has the equations of this flow map, at a coarse tolerance, with its trajectory."""
        with SYMBOLIC:
            if horizon not in self._motions:
                if len(self._motions) == _MOST_MOTIONS:
                    self._motions.pop(next(iter(self._motions)))
                self._motions[horizon] = prepare(scene.until(horizon, {"path": Trajectory()}), _ROUGH)
            program = self._motions[horizon]
        numbers = scene.numbers()
        initial = {s.name: numbers[s] for s in scene.system.states}
        run: Run = program.run({s.name: v for s, v in scene.parameter_values().items()}, initial)
        return run

    def slips(self, y: np.ndarray, values: dict[str, float]) -> np.ndarray:
        """Return the slip of every contact at a state and t = 0, shape (n_c,)."""
        _, p = self._numbers.changed(values, {})
        return np.array(self._automaton.gauge(y, 0.0, np.append(p, np.zeros(self.n_lifts)))[0]).ravel()

    def guard(
        self, y: np.ndarray, values: dict[str, float], time: float, contact: int, way: int, sticks: bool
    ) -> Guard:
        """Return what is left, at a time, until a contact that slips in direction `way` stops, or one that sticks slips
        in the other direction.

        Raises
        ------
        NotFound
            If the contact slides in the plane: it has no other direction.
        """
        if contact in self.planes:
            raise NotFound("a contact in the plane does not slip in one of two directions")
        passage, p, mode = self._follow(y, values, time, None)
        self._put(mode, contact, way, sticks)
        parts = [np.array(e).ravel() for e in self._guards(passage.end, time, p, mode)]
        row = forward(contact) if sticks and way < 0 else backward(contact)
        size = float(np.sum(np.abs(parts[0][[backward(contact), forward(contact)]]))) if sticks else 1.0
        left, rate, bend = (float(e[row] / max(size, 1e-300)) for e in parts)
        return Guard(left, rate, bend, size)

    def _put(self, mode: np.ndarray, contact: int, way: int, sticks: bool) -> None:
        """Let a contact, and those of the same slip, slip in a direction or stick."""
        parallels = self._automaton.parallels
        alike = [k for k, root in enumerate(parallels) if root == parallels[contact] and self._automaton.sticks[k]]
        mode[self._automaton.layout.direction(contact)] = way
        mode[alike] = [(1.0 if k == parallels[contact] else 3.0) if sticks else 0.0 for k in alike]

    def reserve_slopes(
        self, y: np.ndarray, values: dict[str, float], time: float, contact: int, way: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivatives of what `guard` leaves of static friction where a slip ends, at a time that moves.

        By the state y (n_x,) and by the parameters (n_p,). The motion is followed until just before that time, since
        its derivatives jump there; the slip w ends at ``dt = -(dw/dy V + dw/ds)/w'``.
        """
        before = (1.0 - _JUST) * time
        passage, p, mode = self._follow(y, values, before, None)
        n, rate = y.size, passage.rate

        def along(end: np.ndarray, at: float, seed: np.ndarray) -> tuple[np.ndarray, float]:
            """Return derivatives of slips and guards with given weights: at a fixed time, and by time on the motion."""
            row = np.array(self._felt(end, at, p, mode, seed)).ravel()
            by_all = np.append(row[:n] @ passage.by_start, row[:n] @ passage.by_value + row[n + 1 :])
            return by_all, float(row[:n] @ rate + row[n])

        n_c, seed = len(self._automaton.parallels), np.zeros(self._felt.nnz_in(4))
        seed[contact] = 1.0
        gain, speed = along(passage.end, before, seed)
        later = -gain / speed if speed else np.full(gain.size, np.nan)
        end = passage.end + (time - before) * rate
        self._put(mode, contact, way, sticks=True)
        both = [backward(contact), forward(contact)]
        g = np.array(self._guards(end, time, p, mode)[0]).ravel()[both]
        size, row = max(float(np.sum(np.abs(g))), 1e-300), int(way < 0)
        seed = np.zeros(seed.size)
        seed[[n_c + k for k in both]] = -np.sign(g) * g[row] / size**2
        seed[n_c + both[row]] += 1.0 / size
        gain, speed = along(end, time, seed)
        by = gain + speed * later
        return by[:n], by[n:]

    @cached_property
    def _felt(self) -> ca.Function:
        """``(y, t, p, m, weights) -> (d/dy, d/dt, d/ds)`` of the weighted sum of slips and guards of contacts."""
        with SYMBOLIC:
            automaton = self._automaton
            y, t, p, m = (ca.SX.sym(name, automaton.field.nnz_in(i)) for i, name in enumerate("ytpm"))
            sums = ca.vertcat(automaton.gauge(y, t, p)[0], automaton.field(y, t, p, m)[1][automaton.layout.slips])
            seed, names = ca.SX.sym("seed", sums.numel()), [s.name for s in automaton.parameters]
            row = ca.jtimes(sums, ca.vertcat(y, t, p), seed, True)
            first = y.numel() + 1
            picked = ca.vertcat(row[:first], *(row[first + names.index(name)] for name in self.parameters))
            return ca.Function("felt", [y, t, p, m, seed], [ca.densify(picked)])

    @alone(SYMBOLIC)
    def peaked(self, contact: int, values: dict[str, float]) -> bool:
        """Whether the static coefficient of a contact exceeds its kinetic one at rest; not of a stop."""
        if contact >= len(self.lines):
            return False
        law, numbers = self.lines[contact].law, {TIME: 0.0, **{s: values[s.name] for s in self.scene.values}}
        stick, rest = (float(sp.sympify(e).subs(numbers)) for e in (law.stick, law.at_rest))
        return stick - rest > _PEAK * abs(stick)

    def gap_of(self, contact: int) -> int:
        """Return the row of `Passage.gaps` of the gap of a contact that opens, by its number in events."""
        return slip_gap(len(self.lines)) + self.openings.index(contact)

    def opening_of(self, k: int) -> int | None:
        """Return the number, in events, of the contact whose gap is row k of `Passage.gaps`; None if it is no gap."""
        first = slip_gap(len(self.lines))
        return self.openings[k - first] if k >= first else None

    def run(self, y: np.ndarray, values: dict[str, float], time: float, lift: np.ndarray | None = None) -> Passage:
        """Evaluate the flow map from state y over a time.

        Parameters
        ----------
        y : ndarray, shape (n_x,)
        values : dict
            Parameter values that differ from the scene's.
        time : float
        lift : ndarray, shape (n_lifts,), optional
            Added to the guards of every contact while it slips and while it sticks, and to the gaps of those that open;
            see `symfric.lower.relaxed_guards`.

        Raises
        ------
        NotFound
            If the run ends early.
        """
        return self._follow(y, values, time, lift)[0]

    def _follow(
        self, y: np.ndarray, values: dict[str, float], time: float, lift: np.ndarray | None
    ) -> tuple[Passage, np.ndarray, np.ndarray]:
        """Return the passage, and the parameters and modes at its end in the order of the automaton."""
        _, p = self._numbers.changed(values, {})
        raised = np.zeros(self.n_lifts) if lift is None else lift
        passage, parameters, modes = self._runs.follow(y, np.concatenate([p, raised]), time)
        return passage._replace(idle=self._idle(passage)), parameters, modes

    def _idle(self, passage: Passage) -> tuple[int, ...]:
        """Return the springs that were stretched by the slip alone: ``z(T) = z(0) + r (q(T) - q(0))`` for any start."""
        idle, n, by = [], len(self.scene.system.q), passage.by_start
        for place, row in self.springs.items():
            stretched = row @ by[:n]
            stretched[:n] -= row
            stretched[place] += 1.0
            if np.max(np.abs(by[place] - stretched)) <= _STRETCHED * np.max(np.abs(stretched)):
                idle.append(place)
        return tuple(idle)


def is_stiff(scene: Scene) -> bool:
    """Whether the flow map of a scene is one of an implicit integrator."""
    remembers = any(c.law.memory for c in scene.contacts) and not scene.contacts_that_open
    return remembers and pays(LoweredScene(scene))


def _springs_of(scene: Scene) -> dict[int, np.ndarray]:
    """Return places of the springs of contacts among the states, and the slopes of their slips if these are numbers."""
    springs: dict[int, np.ndarray] = {}
    for contact in (c for c in scene.contacts if not c.along_line):
        slopes = scene.system.slopes(contact.slip)
        if isinstance(slopes, np.ndarray) or all(e.is_number for e in slopes):
            row = np.array(slopes, dtype=float)
            springs |= {scene.system.states.index(s): row for s in contact.states}
    return springs


def _guard_rates(automaton: Automaton) -> ca.Function:
    """Return ``(y, t, p, m) -> (g, g', g'')`` for both guards of every contact."""
    field = automaton.field
    y, t, p, m = (ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in()))
    rate, guards, _ = field(y, t, p, m)
    out = [guards[automaton.layout.slips] if automaton.contacts else ca.SX(0, 1)]
    for _ in range(2):
        out.append(ca.jtimes(out[-1], y, rate) + ca.jacobian(out[-1], t))
    return ca.Function("guards", [y, t, p, m], [ca.densify(e) for e in out])


@alone(SYMBOLIC)
def flow_of(scene: Scene, parameters: Sequence[str] = (), tolerance: float = 1e-13) -> FlowMap:
    """Return the compiled flow map of a scene, from a cache if one with the same equations exists.

    A cached one may hold the numbers of another scene: give all values to `Flow.run`.
    """
    tolerance = check_tolerance(tolerance)
    dropped = frozenset(s.name for s in vanishing(scene, frozenset(parameters)))
    integrals = any(c.law.kinetic.has(sp.Integral) for c in scene.contacts)
    key = scene.system, scene.contacts, scene.held, scene.resets, dropped, tuple(parameters), tolerance, is_stiff(scene)
    if scene.inputs or integrals:
        return FlowMap(scene, parameters, tolerance)
    if key not in _FLOWS:
        while len(_FLOWS) >= _MOST_FLOWS:
            _FLOWS.pop(next(iter(_FLOWS)))
        _FLOWS[key] = FlowMap(scene, parameters, tolerance)
    return _FLOWS[key]
