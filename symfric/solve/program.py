"""What the compiled routes share: the numbers of a run, and programs that run again with others."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.model.numeric import numeric
from symfric.model.scene import Scene
from symfric.model.symbols import Key, finite, name_of, nearest
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.run import Run
from symfric.solve.widened import widened

FINEST, COARSEST = 1e-16, 0.1  # tolerances


def check_tolerance(tolerance: float) -> float:
    """Return the tolerance as a float within what double precision can do, or say what is wrong with it."""
    tolerance = finite(tolerance, "tolerance")
    if not FINEST <= tolerance <= COARSEST:
        raise SceneError(f"tolerance is {tolerance}; it must lie between {FINEST:g} and {COARSEST:g}")
    return tolerance


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
            y = self._moved(self._start_of, {name_of(k): v for k, v in values.items()})
        for key, value in initial.items():
            name = name_of(key)
            if name not in self._states:
                raise SceneError(f"{name} is no state{nearest(name, self._states)}")
            y[self._states.index(name)] = finite(value, "the initial value of ", name)
        return y, p

    def _moved(self, start_of: Callable, values: dict[str, float]) -> np.ndarray:
        """Return the start for other values; the scene checks those that its equations contain."""
        if not values.keys() <= self._starters:
            self._scene.where(values)
        numbers = start_of(*(values.get(s.name, v) for s, v in self._scene.values.items()))
        return np.array([finite(float(v), f"the start of {n}") for n, v in zip(self._states, numbers, strict=True)])


class Compiled:
    """What the compiled routes share: a prepared scene that `run` repeats with other numbers, from any thread.

    A route sets the attributes declared here, and `built_in`, `varied`, `wider` and `remade`, which `widened` uses. The
    entries of `_extra` are added to the counts of a run.
    """

    settings: Any
    scene: Scene
    tolerance: float
    _numbers: Numbers
    _model: CompiledModel
    _extra: Mapping[str, float]

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
        status, (final, t_final, stats, raw) = self._model.run(y, p, progress)
        stats.update(self._extra)
        return Run(
            self.scene, dict(values), dict(initial), self.settings, self.tolerance, final, t_final, status, stats, raw
        )
