"""Passages of scenes with stiff laws with memory, by an implicit integrator with its derivatives.

Their contacts never stick, so there are no events, and the derivatives go on continuously where a slip turns. Extremes
are those of a run without derivatives.
"""

import math

import numpy as np

from symfric.errors import NotFound
from symfric.lower.automaton import Automaton, automaton_of
from symfric.model.outputs import HalfRange
from symfric.model.scene import Scene
from symfric.orbits.passages import Followed, Passage
from symfric.orbits.sizes import ranges_of
from symfric.solve.integrators.implicit.varied_motion import VariedMotion
from symfric.solve.integrators.program import IntegratorsProgram
from symfric.solve.integrators.route import Integrators
from symfric.solve.lowered import LoweredScene
from symfric.solve.status import Status, early_end

_FINEST = 1e-10  # tolerance below which the integrator does not become better
_EXTREMES = 1e-8  # tolerance of the extremes, which need many nodes


class StiffRuns:
    """Runs by an implicit integrator, with the derivatives in all directions.

    Parameters
    ----------
    scene : Scene
    automaton : Automaton
        Of the flow map.
    parameters : tuple of str
        Parameters to differentiate by.
    tolerance : float
    """

    def __init__(self, scene: Scene, automaton: Automaton, parameters: tuple[str, ...], tolerance: float):
        lowered = LoweredScene(scene, frozenset(parameters))
        self._lifted, self._automaton = automaton, automaton_of(lowered.dynamics, [])
        self._scene, self._parameters, self._tolerance = scene, parameters, max(tolerance, _FINEST)
        self._motion = VariedMotion(self._automaton, lowered, (*automaton.states, *parameters), 0, self._tolerance)
        ranges = lowered.wanting({s.name: HalfRange(s) for s in scene.system.states})
        self._plain = IntegratorsProgram(ranges, max(self._tolerance, _EXTREMES), Integrators("cvodes"))

    def follow(self, y: np.ndarray, p: np.ndarray, time: float) -> Followed:
        """See `symfric.orbits.passages.Runs`."""
        own = p[: len(self._automaton.parameters)]
        names = [s.name for s in self._automaton.parameters]
        n_x, moving = y.size, np.array([own[names.index(name)] for name in self._parameters])
        values = dict(zip(names, own.tolist(), strict=True))
        plain = self._plain.follow(values, dict(zip(self._lifted.states, y.tolist(), strict=True)), horizon=time)
        low, high = plain.low, plain.high
        if plain.status != Status.OK or low is None or high is None:
            raise NotFound(early_end("the motion from this start", plain.status))
        sizes = ranges_of(low, high, self._automaton.n_q)
        unit = np.concatenate([np.maximum(np.abs(y), sizes), np.where(moving == 0, 1.0, np.abs(moving))])
        V = np.eye(n_x, n_x + len(self._parameters))
        followed = self._motion.follow(y, V, unit, own, np.zeros(0), time, Integrators().max_steps)
        if followed.status != Status.OK:
            raise NotFound(early_end("the motion from this start", followed.status))
        m = np.ones(self._lifted.layout.n_mode)
        m[self._lifted.layout.sticking] = 0.0
        slips = np.array(self._automaton.gauge(followed.final, time, own)[0]).ravel()
        m[self._lifted.layout.directions] = np.where(slips < 0, -1.0, 1.0)
        n_g = self._lifted.layout.n_gaps
        passage = Passage(
            end=followed.final,
            by_start=followed.slopes[:, :n_x],
            by_value=followed.slopes[:, n_x:],
            rate=np.array(self._lifted.field(followed.final, time, p, m)[0]).ravel(),
            events=(),
            modes=tuple(self._lifted.layout.modes(m).tolist()),
            gaps=np.full(n_g, math.inf),
            gaps_by_start=np.zeros((n_g, n_x)),
            gaps_by_value=np.zeros((n_g, len(self._parameters))),
            low=low,
            high=high,
            ranges=sizes,
            doubtful=False,
        )
        return passage, p, m
