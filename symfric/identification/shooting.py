"""Multiple shooting: least squares over pieces of the records that must join."""

from typing import NamedTuple

import numpy as np
from scipy.linalg import null_space

from symfric.identification.local_fit import Problem
from symfric.identification.pieces import Linearised, Pieces

TIGHTNESS = 10.0 ** np.arange(-1, 6)  # of the joints, one after the other; 1 weighs gaps like the whole records
TRIALS, GAIN = 60, 1e-6  # steps at one tightness, and the relative gain that ends them
JOINED = 1e-7  # largest gap of an accepted solution, relative to the size of the states
DAMPING = (1e-3, 1e-12, 1e8)  # at the start, smallest, largest


class Joined(NamedTuple):
    """Where multiple shooting ended.

    Attributes
    ----------
    values : ndarray, shape (n_p,)
    cost : float
        Half the weighted sum of squares; infinite if the pieces do not join.
    y : ndarray, shape (n,)
        Predictions of the pieces.
    information : ndarray, shape (n_p, n_p)
        A matrix R with ``(R'R)^-1`` the covariance of the values for unit variance, the nodes eliminated.
    step : ndarray, shape (n_p,)
        Step of Gauss and Newton that is left without bounds, not zero where a value is at its bound.
    evaluations : int
    """

    values: np.ndarray
    cost: float
    y: np.ndarray
    information: np.ndarray
    step: np.ndarray
    evaluations: int


class _State(NamedTuple):
    point: np.ndarray  # coordinates of values, then nodes over their sizes
    linearised: Linearised
    residuals: np.ndarray
    gaps: np.ndarray


def join(problem: Problem, pieces: Pieces, start: np.ndarray) -> Joined | None:
    """Minimise the residuals of all pieces subject to their joining, from some values; None if no run succeeds.

    Parameters
    ----------
    problem : Problem
    pieces : Pieces
    start : ndarray, shape (n_p,)

    Notes
    -----
    The gaps are further residuals, weighted more and more until the pieces join, by steps of Levenberg and Marquardt.
    The covariance is that of the constrained problem, by the null space of the joints: H. G. Bock,
    Randwertproblemmethoden zur Parameteridentifizierung in Systemen nichtlinearer Differentialgleichungen (1987).
    """
    return _Shooting(problem, pieces, start).solve()


class _Shooting:
    def __init__(self, problem: Problem, pieces: Pieces, start: np.ndarray):
        self.problem, self.pieces = problem, pieces
        self.n_p = problem.predictor.unknowns.size
        inner = np.clip(problem.predictor.unknowns.inner(start), 1e-6, 1 - 1e-6)
        nodes = pieces.first_nodes(start)
        self.sizes = self._sizes(nodes)
        self.begin = np.concatenate([inner, nodes / self.sizes])
        self.evaluations = 0

    def _sizes(self, nodes: np.ndarray) -> np.ndarray:
        """Return the size of every node's number: the largest of its state over the nodes."""
        sizes = np.ones(nodes.size)
        for label, names in self.pieces.states.items():
            begin, n_x = self.pieces.places[label], len(names)
            table = np.abs(nodes[begin : begin + (self.pieces.count - 1) * n_x].reshape(-1, n_x))
            largest = np.max(table, axis=0)
            sizes[begin : begin + table.size] = np.tile(np.where(largest > 0, largest, 1.0), len(table))
        return sizes

    def at(self, point: np.ndarray) -> _State | None:
        """Return the linearised problem at a point, None if a run fails."""
        self.evaluations += 1
        problem, unknowns = self.problem, self.problem.predictor.unknowns
        linearised = self.pieces.linearised(unknowns.outer(point[: self.n_p]), point[self.n_p :] * self.sizes)
        if linearised is None:
            return None
        return _State(point, linearised, problem.weight * (linearised.y - problem.y), linearised.gaps / self.sizes)

    def slopes(self, state: _State) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivatives of residuals and gaps by the coordinates."""
        linearised, unknowns = state.linearised, self.problem.predictor.unknowns
        stretch = np.concatenate([unknowns.stretch(unknowns.outer(state.point[: self.n_p])), self.sizes])
        J = self.problem.weight[:, None] * np.hstack([linearised.by_values, linearised.by_nodes]) * stretch
        C = np.hstack([linearised.gaps_by_values, linearised.gaps_by_nodes]) * stretch / self.sizes[:, None]
        return J, C

    def solve(self) -> Joined | None:
        """Return where the pieces join, None if no run succeeds."""
        state = self.at(self.begin)
        if state is None:
            return None
        weighted = self.problem.weight * self.problem.y
        unit = float(np.sqrt(np.sum((weighted - np.mean(weighted)) ** 2) / max(1, state.gaps.size)))
        for tightness in TIGHTNESS:
            state = self._relaxed(state, tightness * unit)
        return self._result(state)

    def _relaxed(self, state: _State, penalty: float) -> _State:
        """Return the minimum of the residuals with the gaps as further ones."""
        damping, merit = DAMPING[0], self._merit(state, penalty)
        for _ in range(TRIALS):
            J, C = self.slopes(state)
            both, rest = np.vstack([J, penalty * C]), np.concatenate([state.residuals, penalty * state.gaps])
            size = np.linalg.norm(both, axis=0)
            size = np.maximum(size, 1e-12 * np.max(size))
            damped = np.vstack([both / size, np.sqrt(damping) * np.eye(size.size)])
            step = -np.linalg.lstsq(damped, np.concatenate([rest, np.zeros(size.size)]), rcond=1e-15)[0] / size
            moved = self.at(self._clipped(state.point + step))
            reached = np.inf if moved is None else self._merit(moved, penalty)
            if moved is None or not reached < merit:
                damping *= 8
                if damping > DAMPING[2]:
                    break
                continue
            damping, gain = max(damping / 5, DAMPING[1]), 1 - reached / merit
            state, merit = moved, reached
            if gain < GAIN:
                break
        return state

    def _merit(self, state: _State, penalty: float) -> float:
        return 0.5 * float(state.residuals @ state.residuals + penalty**2 * (state.gaps @ state.gaps))

    def _clipped(self, point: np.ndarray) -> np.ndarray:
        return np.concatenate([np.clip(point[: self.n_p], 0.0, 1.0), point[self.n_p :]])

    def _result(self, state: _State) -> Joined:
        unknowns = self.problem.predictor.unknowns
        values = unknowns.outer(state.point[: self.n_p])
        J, C = self.slopes(state)
        free = null_space(C) if C.size else np.eye(J.shape[1])
        inverse = free @ np.linalg.pinv(free.T @ (J.T @ J) @ free) @ free.T
        spread, step = inverse[: self.n_p, : self.n_p], -(inverse @ (J.T @ state.residuals))[: self.n_p]
        sizes, axes = np.linalg.eigh(np.linalg.pinv(spread))
        root = np.sqrt(np.maximum(sizes, 0.0))[:, None] * axes.T / unknowns.stretch(values)
        gap = np.max(np.abs(state.gaps), initial=0.0)
        cost = 0.5 * float(state.residuals @ state.residuals) if gap < JOINED else np.inf
        return Joined(values, cost, state.linearised.y, root, step * unknowns.stretch(values), self.evaluations)
