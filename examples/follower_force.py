"""At which load does a column flutter whose load follows its end?

Friction at a brake pad feeds energy from one mode into another as a load does that follows the end of a column: the
stiffness is not symmetric. Ziegler's double pendulum (Ingenieur-Archiv 20, 1952, 49), with masses 2 m and m, flutters
from P l/k = 7/2 - sqrt(2) on; with damping d, equal in both joints, already from 41/28 + d^2/2 on, and so with the
least of it from 41/28 (Herrmann and Jong, Journal of Applied Mechanics 32, 1965, 592).
"""

from math import sqrt

import numpy as np

import symfric as sf

bars = sf.structures.Structure(
    M=np.array([[3.0, 1.0], [1.0, 1.0]]),  # m l^2
    K=np.array([[2.0, -1.0], [-1.0, 1.0]]),  # k
    friction=np.array([[-1.0, 1.0], [0.0, 0.0]]),  # P l, which takes the place of mu
)
found = sf.structures.flutter(bars, mu=(0.0, 3.0), count=2)
print(f"without damping: P l/k = {found.critical[0].mu:.9f}, Ziegler {3.5 - sqrt(2):.9f}")

for d in (0.1, 0.01, 0.001):
    damped = sf.structures.Structure(bars.M, bars.K, C=d * bars.K, friction=bars.friction)
    first = sf.structures.flutter(damped, mu=(0.0, 3.0), count=2).critical[0].mu
    print(f"with damping {d:g}: {first:.9f}, Herrmann and Jong {41 / 28 + d**2 / 2:.9f}")
