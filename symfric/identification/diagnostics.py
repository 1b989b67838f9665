"""Whether the residuals of a fit look like noise."""

from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, ndtr

LEAST = 20  # samples below which nothing is said
DOUBTFUL = 0.001  # probability below which residuals are not taken for white noise


class Diagnostics(NamedTuple):
    """Statistics of the residuals of one record.

    Attributes
    ----------
    rms : float
        Root of the mean square, in the unit of the record.
    autocorrelation : float
        Of neighbouring samples, -1 to 1.
    white : float
        Probability that white noise shows as much autocorrelation (Ljung and Box 1978); NaN for few samples.
    runs : float
        Probability that white noise changes its sign as seldom or as often (Wald and Wolfowitz 1940).
    """

    rms: float
    autocorrelation: float
    white: float
    runs: float

    @property
    def is_white(self) -> bool:
        """Whether nothing speaks against white noise."""
        return not (self.white < DOUBTFUL or self.runs < DOUBTFUL)


def diagnose(residuals: np.ndarray, unknowns: int = 0) -> Diagnostics:
    """Return the diagnostics of residuals in the order of time.

    Parameters
    ----------
    residuals : ndarray, shape (n,)
    unknowns : int
        How many were fitted.

    Notes
    -----
    Ljung and Box, Biometrika 65 (1978) 297: ``Q = n (n + 2) sum_k rho_k^2/(n - k)`` over the first h = min(10, n/5)
    lags is chi-square distributed with h degrees of freedom. The fit takes some of them; with h kept, the test is a
    little too lenient, which is the safe side for a warning.
    """
    n = residuals.size
    rms = float(np.sqrt(np.mean(residuals**2)))
    centred = residuals - np.mean(residuals)
    total = float(centred @ centred)
    if n < max(LEAST, 2 * unknowns) or total == 0:
        return Diagnostics(rms, float("nan"), float("nan"), float("nan"))
    lags = min(10, n // 5)
    rho = np.array([centred[k:] @ centred[: n - k] / total for k in range(1, lags + 1)])
    q = n * (n + 2) * np.sum(rho**2 / (n - np.arange(1, lags + 1)))
    return Diagnostics(rms, float(rho[0]), float(chdtrc(lags, q)), _runs(centred))


def _runs(centred: np.ndarray) -> float:
    """Return the two-sided probability of the number of runs of one sign."""
    above = centred > 0
    a, b = int(np.count_nonzero(above)), int(np.count_nonzero(~above))
    n = a + b
    if not a or not b:
        return 0.0
    mean = 1 + 2 * a * b / n
    spread = (mean - 1) * (mean - 2) / (n - 1)
    runs = 1 + np.count_nonzero(above[1:] != above[:-1])
    return float(2 * ndtr(-abs(runs - mean) / np.sqrt(spread))) if spread > 0 else 1.0
