"""What a run of the route `integrators` keeps of its pieces: trajectory, ranges, values at given times."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symfric.lower.automaton import Automaton
from symfric.solve.integrators.dense_output.hermite import extremes, quintic
from symfric.solve.integrators.dense_output.refined_grid import cubics, extremes_of
from symfric.solve.integrators.integrated_piece import IntegratedPiece
from symfric.solve.integrators.motion import Motion
from symfric.solve.path import Path


@dataclass(frozen=True)
class Recorder:
    """Stores the pieces of a motion in it.

    Attributes
    ----------
    automaton : Automaton
    ranges : tuple of str
        Observables that are no integrals.
    times : mapping of str to ndarray
        Of those taken at given times.
    path : bool
        Whether the trajectory is kept.
    held : bool
        Whether modes are held between events, not evaluated.
    """

    automaton: Automaton
    ranges: tuple[str, ...]
    times: Mapping[str, np.ndarray]
    path: bool
    held: bool

    def keep(self, motion: Motion, piece: IntegratedPiece, p: np.ndarray) -> None:
        """Store trajectory, ranges and values of a piece."""
        t, nodes = np.unique(piece.t, return_index=True)  # in a piece of a few roundings of time some nodes coincide
        h, n_g = np.diff(t), self.automaton.layout.n_guards
        if self.ranges:
            rows = [e[n_g:, nodes] for e in piece.rows]
            if piece.cubic:
                low, high, at = extremes_of(t, rows[0])
                if motion.at is not None:
                    at = np.where([low < motion.low, high > motion.high], at, motion.at)
                motion.at = at
            else:
                low, high = extremes(h, *rows)
            motion.low = low if motion.low is None else np.minimum(motion.low, low)
            motion.high = high if motion.high is None else np.maximum(motion.high, high)
            self._keep_values(motion, t, rows, piece.cubic)
        if self.path:
            mode = np.tile(self.automaton.layout.modes(motion.m), (h.size, 1))
            if not self.held:
                mode = self._directions(t, piece.state[: motion.y.size, nodes], p)
            states = piece.state[: motion.y.size, nodes], piece.first[:, nodes], piece.second[:, nodes]
            motion.pieces.append(Path(t[:-1], h, cubics(t, states[0]) if piece.cubic else quintic(h, *states), mode))

    def _directions(self, t: np.ndarray, state: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return the direction of slip of every contact at the middle of the intervals, for motions without events."""
        middle = self.automaton.gauge((state[:, 1:] + state[:, :-1]) / 2, ((t[1:] + t[:-1]) / 2)[None, :], p)[0]
        return np.where(np.array(middle).reshape(-1, t.size - 1).T < 0, -1, 1)

    def _keep_values(self, motion: Motion, t: np.ndarray, rows: list[np.ndarray], cubic: bool) -> None:
        """Store the outputs at times within a piece."""
        between = cubics(t, rows[0]) if cubic and self.times else None
        for k, name in enumerate(self.ranges):
            times = self.times.get(name, np.zeros(0))
            for j in np.flatnonzero((t[0] <= times) & (times <= t[-1])):
                i = min(int(np.searchsorted(t, times[j], side="right")), t.size - 1) - 1
                if between is None:
                    c = quintic(np.diff(t[i : i + 2]), *(e[k : k + 1, i : i + 2] for e in rows))[0, 0]
                else:
                    c = between[i, k]
                motion.values[name][j] = np.polynomial.polynomial.polyval(times[j] - t[i], c)
