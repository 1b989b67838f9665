"""The route `integrators`: CasADi's own integrators, as an independent check of the other routes.

The law with its jump runs through `erk` or `rosenbrock` with their native events: one integration per mode, which ends
where the first guard falls; the next mode is decided by the forces (`next_mode`). Continuous laws may also run through
`cvodes`, `idas` and `collocation`, with the signs of kinks evaluated instead of held.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symfric.errors import NoRoute, SceneError
from symfric.lower.automaton import Automaton, lower, vanishing
from symfric.model.names import Key, finite, name_of
from symfric.model.outputs import Events, Integral, ScalarOfExpression, Trajectory
from symfric.model.scene import Scene
from symfric.solve.hermite import extremes, first_dip, middle_error, quintic
from symfric.solve.next_mode import Rule, make_rule, next_mode, numbers, starting_mode
from symfric.solve.one_mode import ONE_STEP, Integrators, mode_integrator, node_function, signs_evaluated
from symfric.solve.run import Path, Raw, Run
from symfric.solve.segments import segments
from symfric.solve.status import Status

FINEST, COARSEST = 1e-14, 0.1  # tolerances
_SAFETY = {"cvodes": 1e-3, "idas": 1e-3}  # of the local tolerance: the errors of steps and event times add up, and
_SAFETY_ONE_STEP = 0.1  # those of the multistep methods at kinks are far above their own estimate
_STALLED = 200  # events without time advancing
_MOST_NODES = 2**15  # of the dense output between two events
_DEPTH = 60  # how often an integration is shortened because an event was stepped over
_CHECK = 1e-6  # accuracy of the dense output that looks for events the integrator stepped over


def declines(automaton: Automaton, settings: Integrators, on_the_way: bool) -> str:
    """Return why the route does not take the scene; empty if it does.

    `on_the_way` says whether more than the end and integrals is wanted.
    """
    if settings.plugin in ONE_STEP:
        return ""
    if any(automaton.sticks):
        return (
            f"{settings.plugin} has no events that work, and a contact can stick; use scene.regularised(v_s), or the "
            "plugin 'erk' or 'rosenbrock'"
        )
    if on_the_way and automaton.n_switches:
        return (
            f"{settings.plugin} steps over kinks, so only the end and integrals are right; want those alone, or use "
            "the plugin 'erk' or 'rosenbrock'"
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


@dataclass(frozen=True)
class _Samples:
    """States and their derivatives at nodes, shape (n_x, n + 1), and the same of guards and wanted rows."""

    t: np.ndarray
    value: np.ndarray
    first: np.ndarray
    second: np.ndarray
    rows: list[np.ndarray]
    error: float


class IntegratorsProgram:
    """A scene prepared for one tolerance and one integrator; `run` repeats it with other numbers."""

    route = "integrators"

    def __init__(self, scene: Scene, tolerance: float, settings: Integrators, varied: frozenset[str] = frozenset()):
        self.scene, self.tolerance, self.settings = scene, check_tolerance(tolerance), settings
        self._varied, self._local = varied, max(_SAFETY.get(settings.plugin, _SAFETY_ONE_STEP) * self.tolerance, FINEST)
        scalars = {n: o for n, o in scene.outputs.items() if isinstance(o, ScalarOfExpression)}
        self._integrals = {n: o.expr for n, o in scalars.items() if isinstance(o, Integral)}
        self._ranges = {n: o.expr for n, o in scalars.items() if not isinstance(o, Integral)}
        self._keep_path = any(isinstance(o, Trajectory) for o in scene.outputs.values())
        self._keep_events = self._keep_path or any(isinstance(o, Events) for o in scene.outputs.values())
        self.automaton = lower(scene, [*self._integrals.values(), *self._ranges.values()], varied, tested=True)
        refusal = declines(self.automaton, settings, self._keep_path or bool(self._ranges))
        if refusal:
            raise NoRoute(f"the route 'integrators' declines: {refusal}")
        self._held = settings.plugin in ONE_STEP
        self._field = self.automaton.field if self._held else signs_evaluated(self.automaton)
        self._rule: Rule = make_rule(self.automaton, self.automaton.n_q, max(1e-12, 10 * self._local))
        self._elements = min(2000, settings.elements)
        self._advance = self._integrator(0)
        self._nodes = node_function(self._field, len(self._integrals))
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
        times, inputs = segments([scene.inputs[s] for s in self.automaton.inputs], scene.horizon)
        for k, row in enumerate(inputs):
            p, end = np.concatenate([parameters, row]), min(times[k + 1], scene.horizon)
            self._settle(motion, p, frozenset(), first=k == 0)
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
        _, _, _, load, margin = (numbers(e) for e in self.automaton.gauge(motion.y, motion.t, p)[:5])
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

    def _integrate(self, motion: _Motion, p: np.ndarray, end: float, depth: int = 0) -> None:
        """Go on to `end` or to the next event; again and shorter if a guard dipped within a step."""
        if self.automaton.autonomous and not np.any(numbers(self._field(motion.y, motion.t, p, motion.m)[0])):
            motion.rest = motion.t if math.isnan(motion.rest) else motion.rest
        span = end - motion.t
        state = np.concatenate([motion.y, motion.total, [1.0, -1.0, 1.0]])
        try:
            result = self._result(state, np.concatenate([p, motion.m, [motion.t, span]]))
        except RuntimeError:
            motion.status = Status.INTEGRATOR
            return
        motion.counts["integrations"] += 1
        n_x, (elapsed, index, live) = motion.y.size, result[-3:]
        begin, fired = motion.t, live == 0
        t = min(motion.t + elapsed * span, end) if fired else end
        if t > begin and (self._held or self._keep_path or self._ranges):
            samples = self._sample(motion, p, t, result[:n_x])
            missed = self._missed(samples) if self._held else None
            if missed is not None:
                if depth == _DEPTH:
                    motion.status = Status.INTEGRATOR
                    return
                peak, dip = missed  # a guard that starts at zero cannot fire; from its peak it can
                self._integrate(motion, p, peak if peak > begin else dip, depth + 1)
                return
            self._keep(motion, samples)
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

    def _result(self, state: np.ndarray, data: np.ndarray) -> np.ndarray:
        """Return the state at the end; raise RuntimeError if the integrator gives up."""
        if self.settings.plugin != "collocation":
            return numbers(self._advance(x0=state, p=data)["xf"])
        before = None
        while self._elements <= self.settings.elements:
            found = numbers(self._integrator(1)(x0=state, p=data)["xf"])
            if before is not None and np.all(np.abs(found - before) <= self.tolerance * np.maximum(1, np.abs(found))):
                self._elements //= 2
                return found
            before = found
            self._elements *= 2
        raise RuntimeError("the result still changes with the number of elements")

    def _integrator(self, nodes: int) -> ca.Function:
        counts = (self._elements, nodes)
        return mode_integrator(
            self._field, len(self._integrals), self.settings, self._local, self.scene.horizon, *counts
        )

    def _sample(self, motion: _Motion, p: np.ndarray, t: float, last: np.ndarray) -> _Samples:
        """Integrate from `motion.t` to t again, with as many nodes as the quintics between them need."""
        span, n_x, n = t - motion.t, motion.y.size, 8
        wanted = 50 * self.tolerance if self._keep_path or self._ranges else max(50 * self.tolerance, _CHECK)
        state = np.concatenate([motion.y, motion.total, [1.0, -1.0, 1.0]])
        data = np.concatenate([p, motion.m, [motion.t, span]])
        while True:
            if n not in self._samplers:
                self._samplers[n] = self._integrator(n)
            times = motion.t + span * np.linspace(0, 1, n + 1)
            found = np.array(self._samplers[n](x0=state, p=data)["xf"])[:n_x]
            value = np.column_stack([motion.y, found[:, :-1], last])
            first, second, *rows = (np.array(e) for e in self._nodes(value, times[None, :], p, motion.m))
            error = middle_error(times, value, first, second)
            if error <= wanted or n >= _MOST_NODES:
                return _Samples(times, value, first, second, rows, error)
            n *= 2

    def _missed(self, samples: _Samples) -> tuple[float, float] | None:
        """Return the times of the peak and the dip of a guard that fell unseen within a step."""
        n_g = self.automaton.n_guards
        guards = [e[:n_g] for e in samples.rows]
        below = max(1e3 * self.tolerance, samples.error) * np.max(np.abs(guards[0]), axis=1, initial=0)
        return first_dip(samples.t, *guards, below) if n_g else None

    def _keep(self, motion: _Motion, samples: _Samples) -> None:
        h, n_g = np.diff(samples.t), self.automaton.n_guards
        if self._ranges:
            low, high = extremes(h, *(e[n_g:] for e in samples.rows))
            motion.low = low if motion.low is None else np.minimum(motion.low, low)
            motion.high = high if motion.high is None else np.maximum(motion.high, high)
        if self._keep_path:
            mode = np.tile(_signs(motion.m, len(self.automaton.contacts)), (h.size, 1))
            coefficients = quintic(h, samples.value, samples.first, samples.second)
            motion.pieces.append(Path(samples.t[:-1], h, coefficients, mode))

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
