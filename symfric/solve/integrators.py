"""The route `integrators`: CasADi's own integrators, as an independent check of the other routes.

The law with its jump runs through `erk` or `rosenbrock` with their native events: one integration per mode, which ends
where the first guard falls; the next mode is decided by the forces (`next_mode`). Continuous laws may also run through
`cvodes`, `idas` and `collocation`, with the signs of kinks evaluated instead of held.
"""

import contextlib
import io
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symfric.errors import SceneError
from symfric.lower.automaton import Automaton, lower, vanishing
from symfric.model.names import Key, finite, name_of
from symfric.model.outputs import Events, Integral, ScalarOfExpression, Trajectory
from symfric.model.scene import Scene
from symfric.solve.hermite import extremes, middle_error, quintic
from symfric.solve.next_mode import Rule, along, make_rule, next_mode, numbers, starting_mode
from symfric.solve.run import Path, Raw, Run
from symfric.solve.status import Status

ONE_STEP = ("erk", "rosenbrock")  # their events work; those of cvodes and idas are wrong in silence
CONTINUOUS = ("cvodes", "idas", "collocation")
FINEST, COARSEST = 1e-14, 0.1  # tolerances
_SAFETY = 0.1  # of the local tolerance: the errors of the steps and of the event times add up
_STALLED = 200  # events without time advancing
_MOST_NODES = 2**15  # of the dense output between two events


@dataclass(frozen=True)
class Integrators:
    """Settings of the route `integrators`.

    Attributes
    ----------
    plugin : str
        "erk" or "rosenbrock" for any scene; "cvodes", "idas" or "collocation" for scenes without sticking.
    max_step : float
        Longest step of the adaptive plugins; a guard that falls and rises again within a step is not seen.
    elements : int
        Number of equal steps of "collocation", which does not control its error.
    max_events, max_steps : int
        Budgets.
    """

    plugin: str = "erk"
    max_step: float = math.inf
    elements: int = 20_000
    max_events: int = 1_000_000
    max_steps: int = 100_000_000

    def __post_init__(self):
        if self.plugin not in ONE_STEP + CONTINUOUS:
            raise SceneError(f"no integrator {self.plugin!r}; there are {', '.join(ONE_STEP + CONTINUOUS)}")
        if not self.max_step > 0:
            raise SceneError(f"max_step is {self.max_step}; it must be positive")
        if min(self.elements, self.max_events, self.max_steps) < 1:
            raise SceneError("elements and the budgets max_events and max_steps must be positive")


def declines(automaton: Automaton, settings: Integrators) -> str:
    """Return why the route does not take the scene; empty if it does."""
    if settings.plugin in CONTINUOUS and any(automaton.sticks):
        return (
            f"declines: {settings.plugin} has no events that work, and a contact can stick; "
            "use scene.regularised(v_s), or the plugin 'erk' or 'rosenbrock'"
        )
    return ""


@dataclass
class _Motion:
    """A run while it is computed."""

    t: float
    y: np.ndarray
    total: np.ndarray
    m: np.ndarray
    status: Status = Status.OK
    rest: float = math.nan
    events: list[tuple[float, int, int, int]] = field(default_factory=list)
    counts: dict[str, int] = field(
        default_factory=lambda: dict.fromkeys(("integrations", "events", "kinks", "grazes"), 0)
    )
    pieces: list[Path] = field(default_factory=list)
    low: np.ndarray | None = None
    high: np.ndarray | None = None


class IntegratorsProgram:
    """A scene prepared for one tolerance and one integrator; `run` repeats it with other numbers."""

    route = "integrators"

    def __init__(self, scene: Scene, tolerance: float, settings: Integrators, varied: frozenset[str] = frozenset()):
        self.scene, self.tolerance, self.settings = scene, check_tolerance(tolerance), settings
        self._varied, self._local = varied, max(_SAFETY * self.tolerance, FINEST)
        scalars = {n: o for n, o in scene.outputs.items() if isinstance(o, ScalarOfExpression)}
        self._integrals = {n: o.expr for n, o in scalars.items() if isinstance(o, Integral)}
        self._ranges = {n: o.expr for n, o in scalars.items() if not isinstance(o, Integral)}
        self._keep_path = any(isinstance(o, Trajectory) for o in scene.outputs.values())
        self._keep_events = self._keep_path or any(isinstance(o, Events) for o in scene.outputs.values())
        self.automaton = lower(scene, [*self._integrals.values(), *self._ranges.values()], varied)
        refusal = declines(self.automaton, settings)
        if refusal:
            raise SceneError(f"route 'integrators' {refusal}")
        self._held = settings.plugin in ONE_STEP
        self._field = self.automaton.field if self._held else _signs_evaluated(self.automaton)
        self._rule: Rule = make_rule(self.automaton, len(scene.system.q), max(1e-12, 10 * self._local))
        self._advance = self._integrator(0)
        self._nodes = _node_function(self._field, len(self._integrals))
        self._samplers: dict[int, ca.Function] = {}

    def run(
        self,
        values: Mapping[Key, float] | None = None,
        initial: Mapping[Key, float] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Run:
        """Run with other parameter values or another start; `progress` is called with the fraction done at events."""
        scene = self.scene.where(values) if values else self.scene
        scene = scene.starting(initial) if initial else scene
        dropped = {s.name for s in vanishing(self.scene, self._varied)} & {name_of(k) for k in values or {}}
        if any(scene.values[scene.parameter(name)] != 0 for name in dropped):
            wider = IntegratorsProgram(self.scene, self.tolerance, self.settings, self._varied | dropped)
            return wider.run(values, initial, progress)
        given = scene.numbers()
        start = np.array([given[s] for s in scene.system.states])
        parameters = np.array([given[s] for s in self.automaton.parameters])
        motion = _Motion(0.0, start, np.zeros(len(self._integrals)), np.ones(self.automaton.n_mode))
        for begin, end in _spans(scene, self.automaton):
            p = np.concatenate([parameters, _inputs(scene, self.automaton, begin, end)])
            self._settle(motion, p, frozenset(), first=begin == 0.0)
            while motion.t < end and motion.status == Status.OK:
                self._integrate(motion, p, end)
                if progress is not None:
                    progress(motion.t / scene.horizon)
            if motion.status != Status.OK:
                break
        return self._collect(motion, dict(values or {}), dict(initial or {}))

    def _settle(self, motion: _Motion, p: np.ndarray, hit: frozenset[int], first: bool = False) -> None:
        """Choose the mode at the present state, note what changed."""
        if not self._held:
            return
        if first:
            mode = starting_mode(self._rule, motion.y, motion.t, p)
        else:
            mode = next_mode(self._rule, motion.y, motion.t, p, motion.m, hit)
        if mode is None:
            motion.status = Status.UNDECIDED
            return
        _, _, _, load, margin = (numbers(e) for e in self.automaton.gauge(motion.y, motion.t, p))
        if np.any(load < 0) or np.any(margin < 0):
            motion.status = Status.LOST_CONTACT if np.any(load < 0) else Status.UNDECIDED
            return
        n_c = len(self.automaton.contacts)
        before, after = _signs(motion.m, n_c), _signs(mode, n_c)
        changed = np.flatnonzero(before != after) if not first else ()
        motion.events += [(motion.t, int(i), int(before[i]), int(after[i])) for i in changed]
        motion.counts["events"] += len(changed)
        motion.counts["kinks"] += int(np.sum(motion.m[2 * n_c :] != mode[2 * n_c :])) if not first else 0
        motion.counts["grazes"] += int(bool(hit) and np.array_equal(motion.m, mode))
        motion.m = mode

    def _integrate(self, motion: _Motion, p: np.ndarray, end: float) -> None:
        """Go on to `end` or to the next event."""
        if self.automaton.autonomous and not np.any(numbers(self._field(motion.y, motion.t, p, motion.m)[0])):
            motion.rest = motion.t if math.isnan(motion.rest) else motion.rest
        span = end - motion.t
        state = np.concatenate([motion.y, motion.total, [1.0, -1.0, 1.0]])
        try:
            result = numbers(self._advance(x0=state, p=np.concatenate([p, motion.m, [motion.t, span]]))["xf"])
        except RuntimeError:
            motion.status = Status.INTEGRATOR
            return
        motion.counts["integrations"] += 1
        n_x, (elapsed, index, live) = motion.y.size, result[-3:]
        begin, fired = motion.t, live == 0
        t = min(motion.t + elapsed * span, end) if fired else end
        if self._keep_path or self._ranges:
            self._sample(motion, p, t, result[:n_x])
        motion.t, motion.y, motion.total = t, result[:n_x], result[n_x:-3]
        if not np.all(np.isfinite(motion.y)):
            motion.status = Status.NOT_FINITE
        elif fired:
            self._at_event(motion, p, int(index), advanced=t - begin > 4e-16 * end)

    def _at_event(self, motion: _Motion, p: np.ndarray, index: int, advanced: bool) -> None:
        stalled = 0 if advanced else motion.counts.get("stalled", 0) + 1
        motion.counts["stalled"] = stalled
        motion.rest = math.nan
        if index >= 2 * len(self.automaton.contacts) + self.automaton.n_switches:
            motion.status = Status.LOST_CONTACT
        elif motion.counts["events"] >= self.settings.max_events:
            motion.status = Status.EVENT_BUDGET
        elif stalled > _STALLED:
            motion.status = Status.CHATTER
        else:
            self._settle(motion, p, frozenset({index}))

    def _integrator(self, n_nodes: int) -> ca.Function:
        """Return the integrator of one mode over a scaled time from 0 to 1.

        Its states are y, the integrals, the time and index of the event, and a flag that stops the motion there; with
        `n_nodes` it has that many equidistant outputs, and no events.
        """
        n_x, n_i = self._field.nnz_in(0), len(self._integrals)
        n_p, n_m = self._field.nnz_in(2), self._field.nnz_in(3)
        state, time = ca.SX.sym("state", n_x + n_i + 3), ca.SX.sym("time")
        data = ca.SX.sym("data", n_p + n_m + 2)
        p, m, begin, span = data[:n_p], data[n_p : n_p + n_m], data[-2], data[-1]
        rate, guards, rows = self._field(state[:n_x], begin + span * time, p, m)
        live = state[-1] > 0.5
        moving = ca.if_else(live, span * ca.vertcat(rate, rows[:n_i]), 0)
        dae = {"x": state, "t": time, "p": data, "ode": ca.vertcat(moving, 0, 0, 0)}
        options = {"abstol": self._local, "reltol": self._local, "max_num_steps": self.settings.max_steps}
        if self.settings.plugin == "collocation":
            options = {"number_of_finite_elements": max(1, self.settings.elements // max(1, n_nodes))}
        if self._held and not n_nodes and guards.numel():
            dae["zero"] = ca.if_else(live, guards, 1)
            index, z, u = ca.SX.sym("index"), ca.SX.sym("z", 0), ca.SX.sym("u", 0)
            after = ca.vertcat(state[:-3], time, index, 0)
            arguments = [index, time, state, z, data, u]
            options["transition"] = ca.Function("stop", arguments, [after, z], ca.event_in(), ca.event_out())
        if math.isfinite(self.settings.max_step) and self.settings.plugin != "collocation":
            options["max_step_size"] = self.settings.max_step / self.scene.horizon
        grid = list(np.linspace(0, 1, n_nodes + 1)[1:]) if n_nodes else [1.0]
        with contextlib.redirect_stderr(io.StringIO()):  # "Event support is experimental"
            return ca.integrator("mode", self.settings.plugin, dae, 0.0, grid, options)

    def _sample(self, motion: _Motion, p: np.ndarray, t: float, last: np.ndarray) -> None:
        """Integrate from `motion.t` to t again, with as many nodes as the quintics between them need."""
        span, n_x = t - motion.t, motion.y.size
        if not span > 0:
            return
        state = np.concatenate([motion.y, motion.total, [1.0, -1.0, 1.0]])
        data = np.concatenate([p, motion.m, [motion.t, span]])
        n = 8
        while True:
            if n not in self._samplers:
                self._samplers[n] = self._integrator(n)
            times = motion.t + span * np.linspace(0, 1, n + 1)
            found = np.array(self._samplers[n](x0=state, p=data)["xf"])[:n_x]
            value = np.column_stack([motion.y, found[:, :-1], last])
            nodes = [np.array(e) for e in self._nodes(value, times[None, :], p, motion.m)]
            if n >= _MOST_NODES or middle_error(times, value, nodes[0], nodes[1]) <= 50 * self.tolerance:
                break
            n *= 2
        h = np.diff(times)
        if self._ranges:
            low, high = extremes(h, *nodes[2:])
            motion.low = low if motion.low is None else np.minimum(motion.low, low)
            motion.high = high if motion.high is None else np.maximum(motion.high, high)
        if self._keep_path:
            mode = np.tile(_signs(motion.m, len(self.automaton.contacts)), (n, 1))
            motion.pieces.append(Path(times[:-1], h, quintic(h, value, nodes[0], nodes[1]), mode))

    def _collect(self, motion: _Motion, values: dict, initial: dict) -> Run:
        motion.counts.pop("stalled", None)
        path = log = None
        if self._keep_path and motion.pieces:
            parts = [(p.t, p.h, p.coefficients, p.mode) for p in motion.pieces]
            path = Path(*(np.concatenate(column) for column in zip(*parts, strict=True)))
        if self._keep_events:
            log = (
                np.array([e[0] for e in motion.events]),
                np.array([e[1:] for e in motion.events], dtype=np.int64).reshape(-1, 3),
            )
        raw = Raw(
            final=motion.y,
            t_final=motion.t,
            status=motion.status,
            ranges={n: (motion.low[k], motion.high[k]) for k, n in enumerate(self._ranges) if motion.low is not None},
            integrals=dict(zip(self._integrals, motion.total.tolist(), strict=True)),
            rest=motion.rest,
            path=path,
            events=log,
        )
        return Run(
            base=self.scene,
            values=values,
            initial=initial,
            route=self.route,
            tolerance=self.tolerance,
            final=motion.y,
            t_final=motion.t,
            status=motion.status,
            stats=dict(motion.counts),
            raw=raw,
        )


def check_tolerance(tolerance: float) -> float:
    """Return the tolerance as a float within what the integrators can do, or say what is wrong with it."""
    tolerance = finite(tolerance, "tolerance")
    if not FINEST <= tolerance <= COARSEST:
        raise SceneError(f"tolerance is {tolerance}; the route 'integrators' takes {FINEST:g} to {COARSEST:g}")
    return tolerance


def _signs(m: np.ndarray, n_c: int) -> np.ndarray:
    """Modes of the contacts: -1, 0, +1."""
    return np.where(m[:n_c] > 0.5, 0, m[n_c : 2 * n_c]).astype(np.int64)


def _signs_evaluated(automaton: Automaton) -> ca.Function:
    """Return the field with every direction and switch computed from the state, for laws without a jump."""
    field = automaton.field
    n_c, n_s = len(automaton.contacts), automaton.n_switches
    y, t, p = ca.SX.sym("y", field.nnz_in(0)), ca.SX.sym("t"), ca.SX.sym("p", field.nnz_in(2))
    m = ca.SX.sym("m", field.nnz_in(3))
    sign = lambda e: ca.if_else(e < 0, -1, 1)  # noqa: E731
    mode = [ca.SX(0)] * n_c + [sign(w) for w in ca.vertsplit(automaton.gauge(y, t, p)[0])] + [ca.SX(1)] * n_s
    for k in range(2 * n_c, 2 * n_c + n_s):  # a switch may depend on the ones before it
        mode[k] = sign(field(y, t, p, ca.vertcat(*mode))[1][k])
    return ca.Function("field", [y, t, p, m], list(field(y, t, p, ca.vertcat(*mode))))


def _node_function(field: ca.Function, n_i: int) -> ca.Function:
    """Return ``(y, t, p, m) -> (y', y'', rows, rows', rows'')`` for the dense output; rows without the integrals."""
    y, t = ca.SX.sym("y", field.nnz_in(0)), ca.SX.sym("t")
    p, m = ca.SX.sym("p", field.nnz_in(2)), ca.SX.sym("m", field.nnz_in(3))
    rate, _, rows = field(y, t, p, m)
    rows = rows[n_i:]
    first = along(rows, rate, y, t)
    return ca.Function("nodes", [y, t, p, m], [rate, along(rate, rate, y, t), rows, first, along(first, rate, y, t)])


def _spans(scene: Scene, automaton: Automaton) -> list[tuple[float, float]]:
    """Return the intervals on which every input is a straight line."""
    edges = [np.array([0.0, scene.horizon])]
    for symbol in automaton.inputs:
        signal = scene.inputs[symbol]
        edges.append(signal.t0 + signal.dt * np.arange(signal.samples.size))
    times = np.unique(np.concatenate(edges))
    times = times[(times >= 0) & (times <= scene.horizon)]
    return list(zip(times[:-1].tolist(), times[1:].tolist(), strict=True))


def _inputs(scene: Scene, automaton: Automaton, begin: float, end: float) -> np.ndarray:
    """Return start, value and slope of every input on an interval, from two points inside it."""
    data = []
    for symbol in automaton.inputs:
        low, high = (float(scene.inputs[symbol](begin + part * (end - begin))) for part in (0.25, 0.75))
        slope = (high - low) / (0.5 * (end - begin))
        data += [begin, low - 0.25 * (high - low) / 0.5, slope]
    return np.array(data)
