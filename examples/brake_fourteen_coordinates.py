"""Which of the patterns of a ring brake squeals first? Fourteen coordinates: seven blocks, each along and across.

Every block is the smallest model of mode coupling; its neighbours are coupled by springs along the ring and square to
it. A pattern with n waves adds 2 s (1 - cos(2 pi n/7)) to each stiffness, s that of its coupling, so that it couples
where (K_11 - K_22)^2/4 + K_12 (K_12 - mu k) = 0 with its own K_11 and K_22.
"""

from math import cos, pi

import numpy as np

import symfric as sf

K_11, K_12, K_22, k = 1.9, 0.95, 2.0, 4 / 3
along, across = 0.5, 0.9  # stiffness of the coupling
ring = 2 * np.eye(7) - np.roll(np.eye(7), 1, axis=0) - np.roll(np.eye(7), -1, axis=0)
block = np.array([[K_11, K_12], [K_12, K_22]])
brake = sf.structures.Structure(
    M=np.eye(14),
    K=np.kron(block, np.eye(7)) + np.kron(np.diag([along, across]), ring),
    friction=np.kron(np.array([[0.0, -k], [0.0, 0.0]]), np.eye(7)),
)
found = sf.structures.flutter(brake, mu=(0.0, 3.0), count=14).critical
told = []
for waves in range(4):  # around the ring; those with one and more waves come in pairs
    stiffer = 2 * (1 - cos(2 * pi * waves / 7))
    apart = (K_11 + along * stiffer - K_22 - across * stiffer) ** 2 / 4
    told.append(((apart + K_12**2) / (K_12 * k), waves))
for point, (mu, waves) in zip(found, sorted(told), strict=True):
    print(f"mu = {point.mu:.7f}: squeals at omega = {point.omega:.4f}; closed form {mu:.7f} (waves: {waves})")
