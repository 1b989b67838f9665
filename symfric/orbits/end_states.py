"""Modes of the contacts and rates of the states at the end of a run, from the equations of a scene."""

import threading
from typing import Any

import casadi as ca
import numpy as np

from symfric.lower.automaton import Automaton
from symfric.lower.mode_layout import OPEN


class EndStates:
    """Modes and rates of a scene, for short runs that are repeated often; may be used from any thread.

    Parameters
    ----------
    automaton : Automaton
    """

    def __init__(self, automaton: Automaton):
        layout, field = automaton.layout, automaton.field
        self._lines, self._directions = len(layout.lines), layout.directions.start
        self._shown = layout.shown
        self._openings = list(zip(layout.openings, layout.shown_openings, strict=True))
        self.contacts = frozenset((*range(self._lines), *layout.shown_openings))
        arguments = [ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in())]
        self._rate = ca.Function("rate", arguments, [ca.densify(field(*arguments)[0])])
        self._own = threading.local()

    def modes(self, m: np.ndarray) -> tuple[int, ...]:
        """Evaluate `symfric.lower.mode_layout.ModeLayout.modes` for numbers."""
        values, n = m.tolist(), self._lines
        modes = [0 if values[i] > 0.5 else int(values[self._directions + i]) for i in range(n)]
        modes += [int(values[k]) for k in self._shown]
        for place, number in self._openings:
            modes[number] = OPEN if values[place] > 0.5 else (modes[number] if number < n else 0)
        return tuple(modes)

    def rate(self, y: np.ndarray, t: float, p: np.ndarray, m: np.ndarray) -> np.ndarray:
        """Return the rates of the states, shape (n_x,); of each vector the equations take the first entries."""
        inputs, out, evaluate, _ = self._memory()
        for held, given in zip(inputs, (y, t, p, m), strict=True):
            held[:] = given[: held.size] if isinstance(given, np.ndarray) else given
        evaluate()
        result: np.ndarray = out.copy()
        return result

    def _memory(self) -> tuple[list[np.ndarray], np.ndarray, Any, Any]:
        """Return this thread's buffers: arguments, result, the call, and the object that owns their memory."""
        if not hasattr(self._own, "kept"):
            made: Any = self._rate.buffer()  # CasADi's annotations of it are wrong
            buffer, evaluate = made
            inputs = [np.zeros(self._rate.nnz_in(i)) for i in range(self._rate.n_in())]
            out = np.zeros(self._rate.nnz_out(0))
            for i, held in enumerate(inputs):
                buffer.set_arg(i, held.data)
            buffer.set_res(0, out.data)
            self._own.kept = inputs, out, evaluate, buffer
        kept: tuple[list[np.ndarray], np.ndarray, Any, Any] = self._own.kept
        return kept
