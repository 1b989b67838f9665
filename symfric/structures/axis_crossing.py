"""The exact place where an eigenvalue of a large structure crosses the imaginary axis.

The matrix ``D(mu, omega) = K + mu F + i omega C - omega^2 M``, bordered by two vectors, is regular where D is singular.
The last entry g of the solution of

    [D   b] [x]   [0]
    [c^H 0] [g] = [1]

is zero where ``i omega`` is an eigenvalue. Newton's method for the two real unknowns mu and omega takes its derivatives
from the adjoint solution w: ``dg = -w^H dD x`` (Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria,
2000, chapter 3). It does not matter which of two eigenvalues that nearly merge belongs to which mode.
"""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sps
import scipy.sparse.linalg as spla

from symfric.structures.structure import Structure

_MOST = 25  # steps of Newton's method
_STEADY = 1e-10  # last step, relative to the range and the frequency; the next would be of the size of its square
_NEUTRAL = 1e-12  # of the frequency: change of the decay over the whole range that is rounding


class AxisCrossing(NamedTuple):
    """Where an eigenvalue is ``i omega``, and whether it grows from there on."""

    mu: float
    omega: float
    begins: bool


def axis_crossing(
    structure: Structure, mu: float, omega: float, shape: np.ndarray, span: tuple[float, float]
) -> AxisCrossing | None:
    """Return the crossing that Newton's method finds between two values of mu, None if it does not.

    Parameters
    ----------
    structure : Structure
        With damping.
    mu, omega : float
        First guess.
    shape : ndarray, shape (n,)
        Of the mode there.
    span : (float, float)
        Range of mu.
    """
    low, high = span
    friction, damping = structure.friction, structure.C
    assert friction is not None
    assert damping is not None
    right = shape / np.linalg.norm(shape)
    left = right
    for _ in range(_MOST):
        D = structure.pencil(mu).at(1j * omega)
        size = float(np.max(np.abs(D.diagonal())))
        bordered = sps.block_array([[D, size * left[:, None]], [right.conj()[None, :], None]])
        try:
            factors = spla.splu(sps.csc_matrix(bordered))
        except RuntimeError:  # exactly singular: another eigenvalue is there too
            return None
        unit = np.zeros(right.size + 1, complex)
        unit[-1] = 1.0
        solution, adjoint = factors.solve(unit), factors.solve(unit, "H")
        x, g, w = solution[:-1], solution[-1], adjoint[:-1]
        by_mu, by_omega = -np.vdot(w, friction @ x), -np.vdot(w, 1j * (damping @ x) - 2 * omega * (structure.M @ x))
        slopes = np.array([[by_mu.real, by_omega.real], [by_mu.imag, by_omega.imag]])
        if not np.all(np.isfinite(slopes)) or abs(by_omega) == 0.0:
            return None
        rate = (-1j * by_mu / by_omega).real  # of the real part of the eigenvalue by mu
        if abs(rate) * (high - low) <= _NEUTRAL * omega:
            return None
        step = np.linalg.solve(slopes, -np.array([g.real, g.imag]))
        mu, omega = mu + float(step[0]), omega + float(step[1])
        if not (low <= mu <= high and omega > 0):
            return None
        if abs(step[0]) <= _STEADY * (high - low) and abs(step[1]) <= _STEADY * omega:
            return AxisCrossing(mu, omega, bool(rate > 0))
        right, left = x / np.linalg.norm(x), w / np.linalg.norm(w)
    return None
