"""Instants of held variables and resets at known times, at which the integration ends and begins again."""

import numpy as np

from symfric.lower.automaton import Automaton
from symfric.lower.mode_layout import JUST_AFTER
from symfric.solve.integrators.modes.mode_selection import numbers


class KnownInstants:
    """The clocks of a scene; the guard of each is the time left.

    Parameters
    ----------
    automaton : Automaton
    horizon : float
        Relative to which instants are the same.

    Attributes
    ----------
    any : bool
        Whether there are clocks.
    """

    def __init__(self, automaton: Automaton, horizon: float):
        layout = automaton.layout
        self.any = layout.first_clock < layout.n_guards
        self._automaton, self._horizon = automaton, horizon
        self._first, self._others = layout.first_clock, layout.first_clock - layout.first_other

    def due(self, y: np.ndarray, t: float, p: np.ndarray, m: np.ndarray) -> np.ndarray:
        """Return, for every guard of contacts that do not slip along a line, whether it is that of a clock due now."""
        left = self._left(y, t, p, m)
        return np.concatenate([np.zeros(self._others), left <= self._soon(t)])

    def next_time(self, y: np.ndarray, t: float, p: np.ndarray, m: np.ndarray) -> float:
        """Return the time of the next instant."""
        return t + float(np.min(self._left(y, t, p, m)))

    def same(self, one: float, other: float) -> bool:
        """Whether two times are one instant, to rounding."""
        return abs(one - other) <= self._soon(one)

    def _soon(self, t: float) -> float:
        return JUST_AFTER * (abs(t) + self._horizon)

    def _left(self, y: np.ndarray, t: float, p: np.ndarray, m: np.ndarray) -> np.ndarray:
        return numbers(self._automaton.field(y, t, p, m)[1])[self._first :]
