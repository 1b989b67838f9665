"""The route `taylor`: a scene compiled once, run many times."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symfric.errors import SceneError
from symfric.lower.automaton import Automaton, constants, lower
from symfric.model.names import Key, finite, name_of, nearest
from symfric.model.outputs import Events, Integral, ScalarOfExpression, Trajectory
from symfric.model.scene import Scene
from symfric.solve.run import Path, Raw, Run
from symfric.solve.segments import segments
from symfric.solve.status import Status
from symfric.solve.taylor.driver import EVENTS_FULL, PATH_FULL
from symfric.solve.taylor.entry import launch
from symfric.solve.taylor.jets import Series, expand, reach
from symfric.solve.taylor.jit import MachineCode, compile_functions
from symfric.solve.taylor.workspace import INTEGRAL, RANGE, Workspace, addresses, make_workspace
from symfric.solve.widened import widened

FINEST, COARSEST = 1e-16, 0.1  # tolerances
PATH_BYTES = 2**30  # of a trajectory; a run that needs more ends with a status
_NOTHING = np.zeros(0)
_STATUS = tuple(Status)
MARGIN = 0.2  # of the tolerance that a step may spend, so that the error of a run stays below it


@dataclass(frozen=True)
class Taylor:
    """Settings of the route `taylor`.

    Attributes
    ----------
    order : int or None
        Order of the Taylor series, from the tolerance unless given.
    max_steps, max_events : int
        Budgets; a run that needs more ends with a status.
    """

    order: int | None = None
    max_steps: int = 100_000_000
    max_events: int = 20_000_000

    def __post_init__(self):
        if self.order is not None and not 3 <= self.order <= 60:
            raise SceneError(f"the order of the Taylor series is {self.order}; it must lie between 3 and 60")
        if self.max_steps < 1 or self.max_events < 1:
            raise SceneError("the budgets max_steps and max_events must be positive")


def order_for(tolerance: float, n_states: int) -> int:
    """Return the order that costs least.

    Half the logarithm of the tolerance is best for long smooth runs (Jorba and Zou, 2005). Steps that end at events
    make more orders pay, by measurement 12 for one mass on a belt and 8 for ten, where a step costs more.
    """
    return math.ceil(-0.5 * math.log(tolerance)) + (12 if n_states <= 4 else 8)


class TaylorProgram:
    """A scene compiled for one tolerance; `run` repeats it with other numbers. Not to be shared between threads."""

    route = "taylor"

    def __init__(self, scene: Scene, tolerance: float, settings: Taylor, varied: frozenset[str] = frozenset()):
        self.scene, self.tolerance, self.settings = scene, check_tolerance(tolerance), settings
        self.varied = varied
        outputs = {n: o for n, o in scene.outputs.items() if isinstance(o, ScalarOfExpression)}
        rows = list(dict.fromkeys((INTEGRAL if isinstance(o, Integral) else RANGE, o.expr) for o in outputs.values()))
        self._row = {
            n: rows.index((INTEGRAL if isinstance(o, Integral) else RANGE, o.expr)) for n, o in outputs.items()
        }
        self.automaton: Automaton = lower(scene, [e for _, e in rows], varied)
        order = settings.order or order_for(self.tolerance, len(scene.system.states))
        sticker = self.automaton.sticks.index(True) if sum(self.automaton.sticks) == 1 else -1
        variants = _variants(self.automaton, order, sticker)
        functions = [f for v in variants for f in (v.prelude, v.series, v.probe)]
        self.code: MachineCode = compile_functions(
            [
                *functions,
                _joined_gauge(self.automaton.gauge),
                reach(len(scene.system.states), self.automaton.n_guards, order),
            ]
        )
        self.work: Workspace = make_workspace(
            self.automaton,
            variants,
            self.code.addresses,
            [k for k, _ in rows],
            segments([scene.inputs[i] for i in self.automaton.inputs], scene.horizon),
        )
        wanted = scene.outputs.values()
        keep_path = any(isinstance(o, Trajectory) for o in wanted)
        keep_events = keep_path or any(isinstance(o, Events) for o in wanted)
        self.work.clock[4:] = scene.horizon, MARGIN * self.tolerance
        room = PATH_BYTES // self.work.path_c[0].nbytes if keep_path else settings.max_steps
        self.work.limits[:] = (
            min(settings.max_steps, room),
            settings.max_events,
            1_000_000,
            keep_path,
            keep_events,
            self.automaton.n_q,
            not all(v.entire for v in variants),
            sticker,
        )
        self._table = addresses(self.work)
        self._keep_path, self._keep_events = keep_path, keep_events
        self.general: TaylorProgram | None = None
        numbers = scene.numbers()
        self._start = tuple(
            np.array([numbers[s] for s in symbols]) for symbols in (scene.system.states, self.automaton.parameters)
        )
        self._place = {s.name: k for k, s in enumerate(self.automaton.parameters)}
        self.built_in = {s.name: float(v) for s, v in constants(scene, varied).items()}
        self._moving_start = any(not isinstance(v, float) for v in scene.initial.values())

    def __reduce__(self):
        """Pickle as what it was prepared from; machine code is compiled, or loaded from the cache, where it arrives."""
        return TaylorProgram, (self.scene, self.tolerance, self.settings, self.varied)

    def run(
        self,
        values: Mapping[Key, float] | None = None,
        initial: Mapping[Key, float] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Run:
        """Run with other parameter values or another start.

        Parameters
        ----------
        values, initial : mapping of symbol or name to number
            Changes to the scene's own. The first change of a parameter that was zero, or that a law's mean over fast
            vibration contains, compiles again, for all values of it.
        progress : callable, optional
            Called with the fraction done, about once for every million steps.

        Returns
        -------
        Run
        """
        values = {} if values is None else values
        initial = {} if initial is None else initial
        y, p = self._start
        if values or initial:
            general = widened(self, values)
            if general is not None:
                return general.run(values, initial, progress)
            y, p = self._numbers(values, initial)
        status = self._drive(y, p, progress)
        return self._collect(values, initial, status)

    def _numbers(self, values: Mapping[Key, float], initial: Mapping[Key, float]) -> tuple[np.ndarray, np.ndarray]:
        """Return start and parameters with the changes; the scene's own checks of names and numbers apply."""
        y, p = (a.copy() for a in self._start)
        for key, value in values.items():
            name = name_of(key)
            number = finite(value, f"the value of {name}")
            if name in self._place:
                p[self._place[name]] = number
            elif name not in self.built_in:
                self.scene.parameter(key)  # raises, with the nearest known name
        if values and self._moving_start:
            numbers = self.scene.where(values).numbers()
            y = np.array([numbers[s] for s in self.scene.system.states])
        for key, value in initial.items():
            name = name_of(key)
            if name not in self.automaton.states:
                raise SceneError(f"{name} is no state{nearest(name, self.automaton.states)}")
            y[self.automaton.states.index(name)] = finite(value, f"the initial value of {name}")
        return y, p

    def _drive(self, y: np.ndarray, p: np.ndarray, progress) -> Status:
        w = self.work
        code = launch(self._table, y, p)
        while code < 0:
            if code == PATH_FULL:
                w = w._replace(path_t=_double(w.path_t), path_c=_double(w.path_c), path_m=_double(w.path_m))
            elif code == EVENTS_FULL:
                w = w._replace(event_t=_double(w.event_t), event_i=_double(w.event_i))
            elif progress is not None:
                progress(min(1.0, float(w.y[-1]) / self.scene.horizon))
            if w is not self.work:
                self.work, self._table = w, addresses(w)
            code = launch(self._table, _NOTHING, _NOTHING)
        return _STATUS[code]

    def _collect(self, values: Mapping, initial: Mapping, status: Status) -> Run:
        w = self.work
        n_x = w.y.size - 1
        steps, events, kinks, grazes, kept, kept_events = w.counts.tolist()[:6]
        final, t_final = w.y[:n_x].copy(), w.y.item(n_x)
        path = log = None
        if self._keep_path:
            path = Path(
                w.path_t[:kept, 0].copy(), w.path_t[:kept, 1].copy(), w.path_c[:kept].copy(), w.path_m[:kept].copy()
            )
        if self._keep_events:
            log = (w.event_t[:kept_events].copy(), w.event_i[:kept_events].copy())
        total = w.total.tolist() if self._row else []
        raw = Raw(
            ranges={n: (total[k][0], total[k][1]) for n, k in self._row.items()},
            integrals={n: total[k][2] for n, k in self._row.items()},
            rest=w.clock.item(2),
            path=path,
            events=log,
        )
        stats = {"steps": steps, "events": events, "kinks": kinks, "grazes": grazes, "order": w.c.shape[1] - 1}
        return Run(
            self.scene, dict(values), dict(initial), self.route, self.tolerance, final, t_final, status, stats, raw
        )


def check_tolerance(tolerance: float) -> float:
    """Return the tolerance as a float within what double precision can do, or say what is wrong with it."""
    tolerance = finite(tolerance, "tolerance")
    if not FINEST <= tolerance <= COARSEST:
        raise SceneError(f"tolerance is {tolerance}; it must lie between {FINEST:g} and {COARSEST:g}")
    return tolerance


def _double(array: np.ndarray) -> np.ndarray:
    return np.concatenate([array, np.zeros_like(array)])


def _variants(automaton: Automaton, order: int, sticker: int) -> list[Series]:
    """Return one series for all modes; if one contact alone can stick, one for its slipping and one for its sticking.

    Two that choose nothing are faster than one in which the mode is data (by a quarter for one mass on a belt), but
    their number would double with every contact.
    """
    if sticker < 0:
        return [expand(automaton.field, order)]
    return [
        expand(_fixed(automaton.field, sticker, stick), order, name) for stick, name in ((0, "_slip"), (1, "_stick"))
    ]


def _fixed(field: ca.Function, entry: int, number: float) -> ca.Function:
    """Return the field with one entry of its mode fixed."""
    arguments = [ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in())]
    mode = ca.SX(arguments[3])
    mode[entry] = number
    return ca.Function("field", arguments, field(*arguments[:3], mode))


def _joined_gauge(gauge: ca.Function) -> ca.Function:
    """Return the gauge as a function of ([y; t], p) with one output, the calling convention of the machine code."""
    state, p = ca.SX.sym("y", gauge.nnz_in(0) + 1), ca.SX.sym("p", gauge.nnz_in(2))
    return ca.Function("gauge", [state, p], [ca.vertcat(*gauge(state[:-1], state[-1], p))])
