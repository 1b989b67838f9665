"""Modes followed over a parameter by their shapes."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sps
from scipy.optimize import linear_sum_assignment

from symfric.structures.complex_modes import eigenpairs

if TYPE_CHECKING:
    from symfric.structures.structure import Structure

_ALIKE = 0.8  # modal assurance below which a step is halved
_HALVINGS = 4  # most of one step: where two modes merge, no step is short enough
_DISTANCE = 0.3  # weight of the distance from the prediction, in units of the spread of the eigenvalues


@dataclass(frozen=True, eq=False)
class Followed:
    """Eigenvalues and shapes along a parameter.

    Attributes
    ----------
    mu : ndarray, shape (n_mu,)
        Increasing.
    values : ndarray of complex, shape (count, n_mu)
    shapes : list of ndarray, shape (n, count)
        One for each mu.
    """

    mu: np.ndarray
    values: np.ndarray
    shapes: list[np.ndarray]


def assurance(M: sps.csr_array, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the modal assurance criterion between the columns of a and b, weighted with the mass.

    ``|a^H M b|^2 / (a^H M a  b^H M b)``, 1 for the same shape (Allemang, Sound and Vibration 37, 2003).
    """
    image = M @ b
    cross = np.abs(a.conj().T @ image) ** 2
    own = np.real(np.sum(a.conj() * (M @ a), axis=0))
    other = np.real(np.sum(b.conj() * image, axis=0))
    return np.asarray(cross / np.outer(own, other))


def follow(structure: "Structure", mu: np.ndarray, count: int, near: complex) -> Followed:
    """Follow the modes nearest to a point at the first mu.

    A step over which a shape changes too much to be recognised is halved, at most `_HALVINGS` times: where two modes
    merge, it always does.
    """
    n = structure.n
    extra = min(n, count + max(4, count // 2))  # others may come nearer to the point than those followed
    values, shapes = eigenpairs(structure.pencil(mu[0]), min(count, n), near)
    steps = [(float(mu[0]), values, shapes)]
    before: tuple[float, np.ndarray] | None = None

    def step(to: float, halvings: int) -> None:
        nonlocal before
        at, values, shapes = steps[-1]
        guess = values
        if before is not None and at > before[0]:
            guess = values + (values - before[1]) * (to - at) / (at - before[0])
        new, others = eigenpairs(structure.pencil(to), extra, near)
        like = assurance(structure.M, shapes, others)
        spread = max(float(np.ptp(np.abs(values))), float(np.max(np.abs(values))) / values.size, 1e-300)
        apart = np.abs(new[None, :] - guess[:, None]) / spread
        # one to one, so that two modes are never followed into the same one; far away only the shape decides
        rows, columns = linear_sum_assignment(_DISTANCE * np.minimum(apart, 3.0) - like)
        if halvings and np.min(like[rows, columns]) < _ALIKE:
            step(0.5 * (at + to), halvings - 1)
            step(to, halvings - 1)
            return
        before = at, values
        steps.append((to, new[columns], others[:, columns]))

    for to in mu[1:]:
        step(float(to), _HALVINGS)
    mus, all_values, all_shapes = zip(*steps, strict=True)
    return Followed(np.array(mus), np.array(all_values).T, list(all_shapes))
