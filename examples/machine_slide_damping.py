"""How much damping keeps the slide of a machine tool from sticking and slipping at its slowest feed?

A slide of 400 kg on a feed drive of 20 kN/mm; its friction falls by 120 N over 5 mm/s and rises slowly beyond, and
starts 160 N higher from rest. Feeds from 6 to 60 mm/s. The damper sits between slide and drive.
The least damping follows from Guida's closed form of the largest difference of friction without stick-slip.
"""

from math import sqrt

from scipy.optimize import brentq

import symfric as sf

m, k = 400.0, 2.0e7  # kg, N/m
v_star, fall, rise, jump = 0.005, 120.0, 800.0, 160.0  # m/s, N, N s/m, N
slowest = 0.006  # m/s, the feed that decides
omega = sqrt(k / m)
unit = m * omega * v_star  # of forces, N


def spare(sigma: float, feed: float = slowest) -> float:
    """Return the difference of friction that would make it stick and slip, less the one there is."""
    mu1 = -fall / v_star / (2 * m * omega) + sigma  # half the slopes below and above v_star, damper included
    mu2 = rise / (2 * m * omega) + sigma
    return sf.theory.drive.threshold(mu1, mu2, v_star / feed - 1) - jump / unit


print(f"natural frequency {omega / 6.283185:.1f} Hz; without a damper: {'smooth' if spare(0) > 0 else 'stick-slip'}")
sigma = brentq(spare, 0.0, 0.9)
print(f"damping ratio {sigma:.4f}, c = {2 * sigma * sqrt(k * m) / 1e3:.1f} kN s/m, keeps {1e3 * slowest:g} mm/s smooth")
