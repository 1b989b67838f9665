"""Intervals of linear least squares with bounds."""

import numpy as np
from scipy.optimize import lsq_linear

from symfric.search import ROUNDING, zero


def bounded_interval(
    root: np.ndarray, step: np.ndarray, low: np.ndarray, high: np.ndarray, k: int, rise: float
) -> tuple[float, float]:
    """Return between which changes of unknown `k` half of ``|R (d - step)|^2`` rises by no more than some amount.

    Parameters
    ----------
    root : ndarray, shape (any, n_p)
        R, with ``(R'R)^-1`` the covariance for unit variance.
    step : ndarray, shape (n_p,)
        Where the sum would be zero without bounds, from the values of the fit.
    low, high : ndarray, shape (n_p,)
        Bounds less the values of the fit; the other unknowns are fitted between theirs.
    k : int
    rise : float
        Above the lowest value between the bounds.

    Returns
    -------
    (float, float)
        Changes from the values of the fit; an end that the bounds cut off is the bound.
    """
    others = [j for j in range(step.size) if j != k]

    def cost(change: float) -> float:
        aim = root @ step - root[:, k] * change
        if not others:
            return 0.5 * float(aim @ aim)
        return float(lsq_linear(root[:, others], aim, (low[others], high[others]), method="bvls").cost)

    centre = float(lsq_linear(root, root @ step, (low, high), method="bvls").x[k])
    least = cost(centre)
    ends = []

    def above(change: float) -> float:
        return cost(change) - least - rise

    for bound in (float(low[k]), float(high[k])):
        ends.append(bound if above(bound) <= 0 else zero(above, centre, bound, xtol=2e-12, rtol=ROUNDING))
    return ends[0], ends[1]
