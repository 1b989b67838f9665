"""The fixed-step scheme of the study of scaled rolling isolation, for comparison."""

import numpy as np
from numba import njit


@njit
def fixed_step(a: np.ndarray, dt: float, lam: float, friction: float) -> tuple[float, float, float, float]:
    """March one mass on a rough floor through a sampled acceleration by the scheme of the source.

    Parameters
    ----------
    a : ndarray, shape (n,)
        Acceleration of the ground, m/s^2.
    dt : float
        s.
    lam, friction : float
        Damping over mass, 1/s, and ``mu g``, m/s^2.

    Returns
    -------
    peak_acceleration, peak_velocity, peak_displacement, residual : float
        As the outputs of `sf.scenes.rolling_isolator`.

    Notes
    -----
    Section 2.4: explicit steps; the mass rolls while ``v_s != v_e``, and stops when the velocity left and the driving
    acceleration are both within the friction of one step. First order.
    """
    u = w = peak_a = peak_w = peak_u = 0.0
    for k in range(a.size - 1):
        if w == 0.0 and abs(a[k]) <= friction:
            acceleration = -a[k]
        else:
            side = np.sign(w) if w != 0.0 else -np.sign(a[k])
            acceleration = -side * friction - lam * w - a[k]
        peak_a = max(peak_a, abs(acceleration + a[k]))
        w += acceleration * dt if w != 0.0 or abs(a[k]) > friction else 0.0
        u += w * dt
        if abs(w - lam * w * dt) <= friction * dt and abs(a[k + 1] + lam * w) <= friction:
            w = 0.0
        peak_w, peak_u = max(peak_w, abs(w)), max(peak_u, abs(u))
    return peak_a, peak_w, peak_u, u
