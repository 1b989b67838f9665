"""Programs of the route `integrators`: a scene prepared for one tolerance and one integrator."""

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from symfric.errors import NoRoute, SceneError
from symfric.locks import SYMBOLIC
from symfric.long_calls import long_call, tell_of_run
from symfric.model.outputs import OutputOfExpression
from symfric.model.rows import INTEGRAL, VALUES, Row
from symfric.model.symbols import Key, finite
from symfric.solve.input_segments import segments
from symfric.solve.integrators.implicit.implicit_pieces import ImplicitPieces
from symfric.solve.integrators.implicit.stretch import stretch_of
from symfric.solve.integrators.integrated_piece import SegmentStart
from symfric.solve.integrators.known_instants import KnownInstants
from symfric.solve.integrators.mode_functions import ONE_STEP, ModeEquations, signs_evaluated
from symfric.solve.integrators.mode_integrators import FINEST, ModeIntegrators
from symfric.solve.integrators.modes.mode_selection import (
    ROUNDING,
    NearlyParallel,
    make_rule,
    moving,
    next_mode,
    numbers,
    starting_mode,
)
from symfric.solve.integrators.motion import Motion
from symfric.solve.integrators.recorder import Recorder
from symfric.solve.integrators.refusals import declines, has_events, refuse_crossings, remembering
from symfric.solve.integrators.sizes import first_sizes, make_sizing, sizes_along
from symfric.solve.lowered import LoweredScene
from symfric.solve.path import Path
from symfric.solve.protocol import Program
from symfric.solve.run import Raw, Run
from symfric.solve.status import ADVICE, Status
from symfric.time_limit import check_time

if TYPE_CHECKING:
    from symfric.solve.integrators.route import Integrators

COARSEST = 0.1  # largest tolerance
_KEPT = 4  # most sets of integrators stored in a program
# number of consecutive events, each within this fraction of the horizon, that count as chatter
_STALLED, _LITTLE = 200, 1e-9
# a run stands still if so many pieces advance less than this part of it: the integrator fails over longer ones
_PIECES, _LEAST_PROGRESS = 2000, 1e-6

Flow = ModeIntegrators | ImplicitPieces


class IntegratorsProgram(Program):
    """A scene prepared for one tolerance and one integrator; `run` repeats it with other numbers."""

    settings: "Integrators"

    def __init__(self, lowered: LoweredScene, tolerance: float, settings: "Integrators"):
        super().__init__(lowered, check_tolerance(tolerance), settings)
        scene = self.scene
        outputs = scene.outputs
        refuse_crossings(outputs)
        rows = {n: o.row(scene.horizon) for n, o in outputs.items() if isinstance(o, OutputOfExpression)}
        self._integrals = {n: r.expr for n, r in rows.items() if r.kind == INTEGRAL}
        self._ranges = {n: _whole(r) for n, r in rows.items() if r.kind != INTEGRAL}  # also values at given times
        self._times = {n: np.array(r.times) for n, r in rows.items() if r.kind == VALUES}
        self._starts = {n: r.start for n, r in rows.items() if r.start > 0.0}
        self._keep_path = any(o.keeps_path for o in outputs.values())
        self._only = None  # the times at which alone the motion is looked at, if there are such
        if self._times and len(self._times) == len(self._ranges) and not self._keep_path:
            self._only = np.unique(np.concatenate(list(self._times.values())))
        self._keep_events = any(o.keeps_events for o in outputs.values())
        self.automaton = lowered.automaton_with([*self._integrals.values(), *self._ranges.values()])
        refusal = declines(self.automaton, settings.plugin, scene)
        if refusal:
            raise NoRoute(f"the route 'integrators' declines: {refusal}")
        one_step = settings.plugin in ONE_STEP
        self._held = one_step or (remembering(scene) and has_events(self.automaton))
        self._recorder = Recorder(self.automaton, tuple(self._ranges), self._times, self._keep_path, self._held)
        if not one_step:
            self.automaton = replace(self.automaton, field=signs_evaluated(self.automaton))
        self._field, count = self.automaton.field, len(self._integrals)
        stretch = None if one_step else stretch_of(lowered.dynamics, self.automaton)
        self._make_flow: Callable[[], Flow] = partial(
            ImplicitPieces if self._held and not one_step else ModeIntegrators,
            ModeEquations(self._field, self.automaton, count, settings, self.tolerance, scene.horizon, stretch),
        )
        first = self._make_flow()
        self._sizing = make_sizing(self.automaton, self._field, count, scene.horizon)
        self._idle: deque[Flow] = deque([first], maxlen=_KEPT)  # an integrator can be used by one run at a time
        zero = max(1e-12, 10 * first.local)  # what the integrator's error leaves of a slip at an event
        self._rule = make_rule(self.automaton, zero, self.tolerance, scene.horizon, not one_step)
        self._clocks = KnownInstants(self.automaton, scene.horizon)

    def _run(
        self, values: dict[Key, float], initial: dict[Key, float], progress: Callable[[float], None] | None
    ) -> Run:
        with long_call("run"):
            return self.collect(self.follow(values, initial, progress), values, initial)

    def follow(
        self,
        values: Mapping[Key, float],
        initial: Mapping[Key, float],
        progress: Callable[[float], None] | None = None,
        horizon: float | None = None,
    ) -> Motion:
        """Return the motion with other values of free parameters, or another start, up to its end or to a horizon."""
        horizon = self.scene.horizon if horizon is None else horizon
        scene = self.scene.where(values) if values else self.scene
        scene = scene.starting(initial) if initial else scene
        given = scene.numbers()
        if len(scene.system.states) != len(self.automaton.states):
            raise SceneError(ADVICE[Status.QUEUE_FULL])
        start = np.array([given[s] for s in scene.system.states])
        parameters = np.array([given[s] for s in self.automaton.parameters])
        flow = self._lease()
        motion = Motion(
            0.0,
            start,
            np.zeros(len(self._integrals)),
            np.zeros(len(self._integrals)),
            np.ones(self.automaton.layout.n_mode),
            np.abs(start),
            np.zeros(0),
        )
        motion.values = {n: np.full(t.size, math.nan) for n, t in self._times.items()}
        times, inputs = segments([scene.inputs[s] for s in self.automaton.inputs], horizon)
        for k, row in enumerate(inputs):
            p, end = np.concatenate([parameters, row]), min(times[k + 1], horizon)
            self._select_mode(motion, p, frozenset(), first=k == 0)
            if k == 0:
                self._start_springs(motion, p)
                motion.size = self._sizes(flow, motion, p, horizon)
            while motion.t < end and motion.status == Status.OK:
                check_time()
                strike = self._strike(motion, p)
                if end < horizon and self._clocks.same(strike, end):  # it has the next values of the inputs
                    end = min(strike, end)
                begins = min((s for s in self._starts.values() if motion.t < s < end), default=end)
                self._integrate(flow, motion, p, min(begins, strike))
                if motion.t in self._starts.values():
                    self._start_counting(motion)
                tell_of_run(motion.t / horizon)
                if progress is not None:
                    progress(motion.t / horizon)
            if motion.status != Status.OK:
                if np.any(np.isnan(motion.m)):  # impossible instants, see `symfric.lower.clocks`
                    motion.status = Status.QUEUE_FULL
                break
        self._idle.append(flow)
        return motion

    def _start_counting(self, motion: Motion) -> None:
        """Forget what was accumulated of the observables that count from now on."""
        for k, name in enumerate(self._integrals):
            if self._starts.get(name) == motion.t:
                motion.before[k] = motion.total[k]
        for k, name in enumerate(self._ranges):
            if self._starts.get(name) == motion.t and motion.low is not None and motion.high is not None:
                motion.low[k], motion.high[k] = math.inf, -math.inf

    def _sizes(self, flow: Flow, motion: Motion, p: np.ndarray, horizon: float) -> np.ndarray:
        """Return the sizes of states and integrals from the start, or of continuous laws from a rough motion."""
        sizes = first_sizes(self._sizing, motion.y, 0.0, p, motion.m)
        if flow.rough is None:
            return sizes
        return sizes_along(flow.rough, sizes, motion.y, p, motion.m, horizon)

    def _lease(self) -> Flow:
        """Borrow a set of integrators for one run."""
        try:
            flow = self._idle.pop()
        except IndexError:
            with SYMBOLIC:
                flow = self._make_flow()
        flow.begin()
        return flow

    def _strike(self, motion: Motion, p: np.ndarray) -> float:
        """Let clocks act whose instant is now; return the time of the next one, infinite without clocks."""
        if not self._clocks.any:
            return math.inf
        hit = self._clocks.due(motion.y, motion.t, p, motion.m)
        if np.any(hit):
            self._transit(motion, p, hit)
            self._select_mode(motion, p, frozenset(), jumped=True)
        return self._clocks.next_time(motion.y, motion.t, p, motion.m)

    def _select_mode(
        self, motion: Motion, p: np.ndarray, hit: frozenset[int], first: bool = False, jumped: bool = False
    ) -> None:
        """Select the mode at the current state, and log the change."""
        if not self._held:
            return
        rule = replace(self._rule, farthest=motion.farthest)
        try:
            if first:
                mode = starting_mode(rule, motion.y, motion.t, p)
            else:
                before = moving(rule, motion.y, motion.t, p, motion.m) if jumped else motion.m
                mode = next_mode(rule, motion.y, motion.t, p, before, hit)
        except NearlyParallel:
            motion.status = Status.INTEGRATOR
            return
        if mode is None:
            motion.status = Status.UNDECIDED
            return
        gauge = dict(zip(self.automaton.gauge.name_out(), self.automaton.gauge(motion.y, motion.t, p), strict=True))
        load, margin, forces, coupling = (numbers(gauge[name]) for name in ("load", "margin", "forces", "coupling"))
        # rounding errors of cancelling terms count as zero
        lost = load * coupling[:: load.size + 1] < -ROUNDING * forces
        if np.any(lost) or np.any(margin < 0):
            motion.status = Status.LOST_CONTACT if np.any(lost) else Status.UNDECIDED
            return
        layout = self.automaton.layout
        before = layout.modes(motion.m)
        first = first or not motion.counts["pieces"]  # what happens at the start completes the first mode
        motion.counts["kinks"] += int(np.sum(motion.m[layout.signs] * mode[layout.signs] < 0)) if not first else 0
        motion.counts["grazes"] += int(bool(hit) and np.array_equal(motion.m, mode))
        motion.m, after = mode, layout.modes(mode)
        changed = np.flatnonzero(before != after) if not first else ()
        motion.events += [(motion.t, int(i), int(before[i]), int(after[i])) for i in changed]
        motion.counts["events"] += len(changed)

    def _start_springs(self, motion: Motion, p: np.ndarray) -> None:
        """Complete the first mode of contacts behind springs, whose sliders stick unless they are at their limits."""
        layout = self.automaton.layout
        guards, rates, _ = (numbers(e)[layout.first_other :] for e in self._rule.look(motion.y, motion.t, p, motion.m))
        fallen = (guards < 0) | ((guards == 0) & (rates < 0))
        fallen[layout.first_clock - layout.first_other :] = False
        if np.any(fallen):
            self._transit(motion, p, fallen.astype(float))

    def _transit(self, motion: Motion, p: np.ndarray, hit: np.ndarray) -> None:
        """Change state and mode at events of contacts behind springs."""
        assert self.automaton.transition is not None
        after = self.automaton.transition(motion.y, motion.t, p, motion.m, hit, np.zeros(hit.size))
        motion.y, motion.m = numbers(after[0]), numbers(after[1])

    def _integrate(self, flow: Flow, motion: Motion, p: np.ndarray, end: float) -> None:
        """Integrate to `end`, to the next event, or over a part of the way."""
        if self.automaton.autonomous and not np.any(numbers(self._field(motion.y, motion.t, p, motion.m)[0])):
            motion.rest = motion.t if math.isnan(motion.rest) else motion.rest  # without a rate it stays for ever
        state = np.concatenate([motion.y, motion.total])
        motion.size = np.maximum(motion.size, np.abs(state))
        start = SegmentStart(motion.t, state, p, motion.m, motion.size, motion.inner)
        piece = flow.advance(start, end, motion.reach, self._keep_path or bool(self._ranges), self._only)
        if piece is None:
            motion.status = Status.INTEGRATOR
            return
        self._recorder.keep(motion, piece, p)
        begin, last = motion.t, piece.state[:, -1]
        motion.t, motion.y, motion.total = piece.t.item(-1), last[: motion.y.size], last[motion.y.size :]
        motion.reach, motion.inner = piece.reach, piece.inner
        motion.farthest = np.maximum(motion.farthest, np.max(np.abs(piece.state[: motion.y.size]), axis=1))
        motion.counts["pieces"] += 1
        motion.counts["steps"] = flow.steps
        if not np.all(np.isfinite(motion.y)):
            motion.status = Status.NOT_FINITE
        elif piece.fell >= 0:
            self._at_event(motion, p, piece.fell, advanced=motion.t - begin > _LITTLE * self.scene.horizon)
        if motion.status == Status.OK and motion.counts["steps"] > self.settings.max_steps:
            motion.status = Status.STEP_BUDGET
        elif motion.status == Status.OK and motion.counts["pieces"] % _PIECES == 0:
            if motion.t - motion.marked < _LEAST_PROGRESS * self.scene.horizon:
                motion.status = Status.INTEGRATOR
            motion.marked = motion.t

    def _at_event(self, motion: Motion, p: np.ndarray, index: int, advanced: bool) -> None:
        stalled = 0 if advanced else motion.counts.get("stalled", 0) + 1
        motion.counts["stalled"] = stalled
        motion.rest = math.nan
        layout = self.automaton.layout
        if layout.first_load <= index < layout.first_other:
            motion.status = Status.LOST_CONTACT
        elif motion.counts["events"] >= self.settings.max_events:
            motion.status = Status.EVENT_BUDGET
        elif stalled > _STALLED:
            motion.status = Status.CHATTER
        elif index >= layout.first_other:
            k, variable = layout.other_guards[index - layout.first_other]
            before = motion.m[variable]
            self._transit(motion, p, (np.arange(layout.first_other, layout.n_guards) == index).astype(float))
            after = motion.m[variable]  # the same where one of several sliders starts to move
            motion.events.append((motion.t, len(layout.lines) + k, int(before), int(after)))
            motion.counts["events"] += 1
        else:
            self._select_mode(motion, p, frozenset({index}))

    def collect(self, motion: Motion, values: dict[Key, float], initial: dict[Key, float]) -> Run:
        """Return the result of a motion."""
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
        low, high = motion.low, motion.high
        ranges = dict.fromkeys(self._ranges, (math.nan, math.nan))
        if low is not None and high is not None:
            counted = {n: k for k, n in enumerate(self._ranges) if self._starts.get(n, 0.0) < motion.t}
            ranges |= {n: (low[k], high[k]) for n, k in counted.items()}
        integrals = dict(zip(self._integrals, (motion.total - motion.before).tolist(), strict=True))
        raw = Raw({**ranges, **integrals, **motion.values}, motion.rest, path, log)
        counts: dict[str, float] = dict(motion.counts)
        end = motion.y, motion.t, motion.status, counts
        return Run(self.scene, values, initial, self.settings, self.tolerance, *end, raw)


def check_tolerance(tolerance: float) -> float:
    """Return the tolerance as a float; raise unless the integrators can reach it."""
    tolerance = finite(tolerance, "tolerance")
    if not FINEST <= tolerance <= COARSEST:
        raise SceneError(f"tolerance is {tolerance}; the route 'integrators' takes {FINEST:g} to {COARSEST:g}")
    return tolerance


def _whole(row: Row) -> sp.Expr:
    """Return the expression of an observable, with its magnitude if required."""
    return sp.Abs(row.expr) if row.magnitude else row.expr
