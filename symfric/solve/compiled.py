"""What the compiled routes share: the numbers of a run, the loop around the compiled one, and what it leaves behind."""

from collections.abc import Callable, Mapping

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.model.names import Key, finite, name_of, nearest
from symfric.model.numeric import numeric
from symfric.model.scene import Scene
from symfric.solve.memory import Table
from symfric.solve.run import Path, Raw, Run
from symfric.solve.status import Status
from symfric.solve.wanted import RANGE, Row, Wanted
from symfric.solve.widened import widened

FINEST, COARSEST = 1e-16, 0.1  # tolerances
PATH_BYTES = 2**30  # of a trajectory; a run that needs more ends with a status
PAUSED, PATH_FULL, EVENTS_FULL = -1, -2, -3  # not ends of a run: call again, with more room where it is full
_STATUS = tuple(Status)


def check_tolerance(tolerance: float) -> float:
    """Return the tolerance as a float within what double precision can do, or say what is wrong with it."""
    tolerance = finite(tolerance, "tolerance")
    if not FINEST <= tolerance <= COARSEST:
        raise SceneError(f"tolerance is {tolerance}; it must lie between {FINEST:g} and {COARSEST:g}")
    return tolerance


def _range(row: Row, low: float, high: float) -> tuple[float, float]:
    return (max(low, -high, 0.0), max(-low, high)) if row.magnitude else (low, high)


class Numbers:
    """Start and parameters of a scene as arrays, and what changes of a run make of them."""

    def __init__(self, scene: Scene, parameters: tuple[sp.Symbol, ...], built_in: dict[str, float]):
        numbers = scene.numbers()
        self._scene, self._built_in = scene, built_in
        self.start = tuple(np.array([numbers[s] for s in symbols]) for symbols in (scene.system.states, parameters))
        self._place = {s.name: k for k, s in enumerate(parameters)}
        self._states = tuple(s.name for s in scene.system.states)
        moving = any(not isinstance(v, float) for v in scene.initial.values())
        starts = tuple(sp.sympify(v) for v in scene.initial.values())
        self._start_of = numeric(scene.parameters, starts) if moving else None
        equations = set().union(*(e.free_symbols for e in (*scene.system.expressions, *scene.contacts)))
        self._starters = {s.name for s in scene.parameters if s not in equations}

    def changed(self, values: Mapping[Key, float], initial: Mapping[Key, float]) -> tuple[np.ndarray, np.ndarray]:
        """Return start and parameters with the changes; the scene's own checks of names and numbers apply."""
        y, p = (a.copy() for a in self.start)
        for key, value in values.items():
            name = name_of(key)
            number = finite(value, "the value of ", name)
            if name in self._place:
                p[self._place[name]] = number
            elif name not in self._built_in:
                self._scene.parameter(key)  # raises, with the nearest known name
        if values and self._start_of:
            y = self._moved({name_of(k): v for k, v in values.items()})
        for key, value in initial.items():
            name = name_of(key)
            if name not in self._states:
                raise SceneError(f"{name} is no state{nearest(name, self._states)}")
            y[self._states.index(name)] = finite(value, "the initial value of ", name)
        return y, p

    def _moved(self, values: dict[str, float]) -> np.ndarray:
        """Return the start for other values; the scene checks those that its equations contain."""
        if not values.keys() <= self._starters:
            self._scene.where(values)
        numbers = self._start_of(*(values.get(s.name, v) for s, v in self._scene.values.items()))
        return np.array([finite(float(v), f"the start of {n}") for n, v in zip(self._states, numbers, strict=True)])


class Loop:
    """A compiled event loop and the arrays it works on.

    Parameters
    ----------
    launch : callable
        From `symfric.solve.door`; returns a status, or a reason to be called again.
    work : NamedTuple
        With the fields given_y, given_p, y, counts, clock, total, event_t, event_i, path_t, path_c and path_m.
    wanted : Wanted
    horizon : float
    """

    def __init__(self, launch: Callable, work, wanted: Wanted, horizon: float):
        self._launch, self.work, self._wanted, self._horizon = launch, work, wanted, horizon
        self._table, self._given = Table(work), (None, None)

    def drive(self, y: np.ndarray, p: np.ndarray, progress: Callable[[float], None] | None) -> Status:
        """Run to the end, from state y at t = 0 with parameters p."""
        w = self.work
        if self._given[0] is not y or self._given[1] is not p:  # those of the scene itself come again and again
            w.given_y[:], w.given_p[:] = y, p
            self._given = y, p
        code = self._launch(self._table, True)
        while code < 0:
            if code == PATH_FULL:
                w = w._replace(path_t=_double(w.path_t), path_c=_double(w.path_c), path_m=_double(w.path_m))
            elif code == EVENTS_FULL:
                w = w._replace(event_t=_double(w.event_t), event_i=_double(w.event_i))
            elif progress is not None:
                progress(min(1.0, float(w.y[-1]) / self._horizon))
            if w is not self.work:
                self.work, self._table = w, Table(w)
            code = self._launch(self._table, False)
        return _STATUS[code]

    def collect(self, n_x: int) -> tuple[np.ndarray, float, dict[str, float], Raw]:
        """Return the final values of the first n_x states, their time, counts, and what was kept, all copied."""
        w, wanted = self.work, self._wanted
        steps, events, kinks, grazes, kept, kept_events = w.counts[:6].tolist()
        path = log = None
        if wanted.path:
            path = Path(
                w.path_t[:kept, 0].copy(),
                w.path_t[:kept, 1].copy(),
                w.path_c[:kept, :n_x].copy(),
                w.path_m[:kept].copy(),
            )
        if wanted.events:
            log = (w.event_t[:kept_events].copy(), w.event_i[:kept_events].copy())
        ranges, integrals = {}, {}
        if wanted.row:
            total = w.total.tolist()
            for name, k in wanted.row.items():
                row, (low, high, value, _) = wanted.rows[k], total[k]
                if row.kind == RANGE:
                    ranges[name] = _range(row, low, high)
                else:
                    integrals[name] = value
        raw = Raw(ranges, integrals, w.clock.item(2), path, log)
        stats = {"steps": steps, "events": events, "kinks": kinks, "grazes": grazes}
        return w.y[:n_x].copy(), w.y.item(w.y.size - 1), stats, raw


class Compiled:
    """What the compiled routes share: a prepared scene that `run` repeats with other numbers.

    A route sets `scene`, `tolerance`, `built_in`, `general`, `remade`, `_numbers` and `_loop`; `_extra` joins the
    counts.
    """

    route = ""

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
        y, p = self._numbers.start
        if values or initial:
            general = widened(self, values)
            if general is not None:
                return general.run(values, initial, progress)
            y, p = self._numbers.changed(values, initial)
        status = self._loop.drive(y, p, progress)
        final, t_final, stats, raw = self._loop.collect(len(self.scene.system.states))
        stats.update(self._extra)
        return Run(
            self.scene, dict(values), dict(initial), self.route, self.tolerance, final, t_final, status, stats, raw
        )


def _double(array: np.ndarray) -> np.ndarray:
    return np.concatenate([array, np.zeros_like(array)])
