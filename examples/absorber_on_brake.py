"""Does a small tuned mass quieten a brake that groans? The best tuning and damping, by the growth rate.

The pad of brake_groan_speed.py at 50 mm/s, with a fifth of its mass on a spring and a damper.
The pad alone grows at (N |mu'(v_b)| - c)/(2 m).
"""

import itertools
from math import exp

import numpy as np
import sympy as sp

import symfric as sf

x1, x2, u1, u2 = sp.symbols("x1 x2 u1 u2", real=True)
m, k, c, N, v_b, ratio, tuning, damping = sp.symbols("m k c N v_b ratio tuning damping", positive=True)
m2 = ratio * m
w2 = tuning * sp.sqrt(k / m)
link = m2 * w2**2 * (x2 - x1) + 2 * damping * m2 * w2 * (u2 - u1)
brake = sf.Scene(
    system=sf.System(q=[x1, x2], u=[u1, u2], mass=[[m, 0], [0, m2]], force=[-k * x1 - c * u1 + link, -link]),
    contacts=[sf.Contact("disc", slip=u1 - v_b, normal=N, law=sf.laws.stribeck(0.50, 0.38, 0.12))],
    values={m: 0.6, k: 6e5, c: 60.0, N: 300.0, v_b: 0.05, ratio: 0.2, tuning: 1.0, damping: 1e-6},
    initial={x1: 0.0, x2: 0.0, u1: 0.0, u2: 0.0},
    horizon=0.5,
)
free = sf.stability(brake.where({"tuning": 1e-3}))
told = (300.0 * exp(-0.05 / 0.12) - 60.0) / (2 * 0.6)
print(f"without it vibration grows at {-free.margin:.3f} 1/s, closed form {told:.3f} 1/s")

grid = itertools.product(np.linspace(0.8, 1.0, 6), np.linspace(0.1, 0.3, 5))
found = {(t, d): sf.stability(brake.where({"tuning": t, "damping": d})).margin for t, d in grid}
(best, damper), margin = max(found.items(), key=lambda item: item[1])
words = f"decays at {margin:.1f} 1/s" if margin > 0 else f"still grows at {-margin:.1f} 1/s"
print(f"tuned to {best:.3f} of the pad's frequency with damping ratio {damper:.2f}, it {words}")
