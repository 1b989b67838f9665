"""Steps of linear equations with a constant part and few channels that vary, ``V' = (A0 + B D(t) R) V + s(t)``.

The constant part is followed exactly, by its eigenvalues. For the rest, Gauss's collocation is applied to ``exp(-A0 t)
V``: with the kernels ``R exp(A0 tau) B`` its equations hold the channels ``g = R V`` alone,

    g_i = R exp(A0 c_i h) V_0 + h sum_j a_ij R exp(A0 (c_i - c_j) h) (B D_j g_j + s_j),
    V_1 = exp(A0 h) V_0       + h sum_j b_j    exp(A0 (1 - c_j) h)   (B D_j g_j + s_j),

of order 16 with 8 nodes (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.7; the exponential
form is Lawson's, SIAM Journal on Numerical Analysis 4 (1967) 372). A step costs channels times states for each column.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from symfric.errors import NoRoute

NODES = 8  # order 16: that of Gauss's collocation is twice the number of nodes (Hairer and Wanner II, IV.5)
REACH = 4.0  # largest |eigenvalue| times step; the error of order 16 is then some 1e-13
_LOST = 1e-11  # largest relative error of a matrix made again from its eigenvectors
_DEPENDENT = "the eigenvectors of the free structure are nearly dependent"


@cache
def gauss() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return nodes c, weights b and matrix a of Gauss's collocation on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    c, b = 0.5 * (x + 1), 0.5 * w
    powers = np.vander(x, NODES, increasing=True)
    areas = 0.5 * np.array([(x ** (k + 1) - (-1.0) ** (k + 1)) / (k + 1) for k in range(NODES)]).T
    return c, b, np.linalg.solve(powers.T, areas.T).T


class Motion(NamedTuple):
    """Flow of ``y' = A0 y`` in real modal coordinates v, ``y = X v``, whose pairs it rotates and scales.

    Attributes
    ----------
    X, inverse : ndarray, shape (n_x, n_x)
    rate, turn : ndarray, shape (n_x,)
        Real part of every eigenvalue, and the imaginary one with the sign that belongs to the coordinate.
    partner : ndarray of int, shape (n_x,)
    """

    X: np.ndarray
    inverse: np.ndarray
    rate: np.ndarray
    turn: np.ndarray
    partner: np.ndarray

    def after(self, tau: Any, v: np.ndarray) -> np.ndarray:
        """Return the coordinates v, shape (n_x, k), after a time."""
        grow = np.exp(self.rate * tau)
        along, across = grow * np.cos(self.turn * tau), grow * np.sin(self.turn * tau)
        return np.asarray(along[:, None] * v + across[:, None] * v[self.partner])

    def before(self, taus: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Return rows (k, n_x) times the flow over each of some times, shape (n, k, n_x)."""
        grow = np.exp(self.rate * taus[:, None])
        along, across = grow * np.cos(self.turn * taus[:, None]), grow * np.sin(self.turn * taus[:, None])
        return np.asarray(rows * along[:, None, :] + (rows[None] * across[:, None, :])[:, :, self.partner])

    @property
    def fastest(self) -> float:
        """The largest magnitude of an eigenvalue."""
        return float(np.max(np.hypot(self.rate, self.turn), initial=0.0))


def motion_of(A: np.ndarray) -> Motion:
    """Return the flow of a matrix.

    Raises
    ------
    NoRoute
        If its eigenvectors are nearly dependent.
    """
    values, vectors = np.linalg.eig(A)
    n = len(values)
    X, rate, turn, partner = np.empty((n, n)), np.empty(n), np.zeros(n), np.arange(n)
    k = 0
    for i in np.argsort(-values.imag, kind="stable"):
        if values[i].imag > 0:
            # these two span the plane in which a conjugate pair turns, so the flow stays real
            X[:, k], X[:, k + 1] = vectors[:, i].real, vectors[:, i].imag
            rate[k : k + 2], turn[k], turn[k + 1] = values[i].real, values[i].imag, -values[i].imag
            partner[k], partner[k + 1] = k + 1, k
            k += 2
        elif values[i].imag == 0:
            X[:, k], rate[k] = vectors[:, i].real, values[i].real
            k += 1
    try:
        motion = Motion(X, np.linalg.inv(X), rate, turn, partner)
    except np.linalg.LinAlgError:
        raise NoRoute(_DEPENDENT) from None
    again = X @ (rate[:, None] * motion.inverse + turn[:, None] * motion.inverse[partner])
    if not np.all(np.max(np.abs(again - A), axis=1) <= _LOST * np.max(np.abs(A), axis=1)):
        raise NoRoute(_DEPENDENT)
    return motion


class Coupling(NamedTuple):
    """What varies over the nodes of some equal steps.

    Attributes
    ----------
    rows : ndarray, shape (n_xi, n_x)
        R X.
    pushes : ndarray, shape (n_x, n_phi)
        ``X^-1 B``.
    slopes : ndarray, shape (n, NODES, n_phi, n_xi)
        D.
    source : ndarray, shape (n, NODES, n_x, n_s) or None
        ``X^-1 s``, of the last n_s columns of V.
    """

    rows: np.ndarray
    pushes: np.ndarray
    slopes: np.ndarray
    source: np.ndarray | None


def advance(motion: Motion, h: float, coupling: Coupling, V: np.ndarray) -> np.ndarray:
    """Return V, in the coordinates of the motion, after equal steps of length h."""
    c, b, a = gauss()
    rows, pushes, slopes, source = coupling
    n_xi, n_phi, n_x = len(rows), pushes.shape[1], len(V)
    begin = motion.before(c * h, rows).reshape(NODES * n_xi, n_x)  # R exp(A0 c_i h)
    between = motion.before(((c[:, None] - c) * h).ravel(), rows).reshape(NODES, NODES, n_xi, n_x)
    kernel = h * a[:, :, None, None] * (between @ pushes)  # (i, j, xi, phi)
    ahead = np.stack([motion.after((1 - e) * h, pushes) for e in c])  # (j, x, phi)
    for k in range(len(slopes)):
        g = begin @ V
        if source is not None:
            n_s = source.shape[3]
            forced = np.einsum("ijcx,jxs->ics", h * a[:, :, None, None] * between, source[k])
            g[:, -n_s:] += forced.reshape(NODES * n_xi, n_s)
        felt = np.einsum("ijcp,jpd->icjd", kernel, slopes[k]).reshape(NODES * n_xi, NODES * n_xi)
        g = np.linalg.solve(np.eye(len(felt)) - felt, g).reshape(NODES, n_xi, V.shape[1])
        push = (h * b[:, None, None] * (slopes[k] @ g)).transpose(1, 0, 2).reshape(n_phi * NODES, V.shape[1])
        new = motion.after(h, V) + ahead.transpose(1, 2, 0).reshape(n_x, n_phi * NODES) @ push
        if source is not None:
            for j in range(NODES):
                new[:, -n_s:] += h * b[j] * motion.after((1 - c[j]) * h, source[k, j])
        V = new
    return V
