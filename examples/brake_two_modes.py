"""How can a brake squeal though its coefficient of friction is constant, and how far does it then move?

The smallest model of mode coupling (Hoffmann and others, Mechanics Research Communications 29, 2002, 197): a mass on a
belt, held by two springs that are not square to it; a third one is its contact, whose load varies as it deflects. The
frequencies meet where (K_11 - K_22)^2/4 + K_12 (K_12 - mu k) = 0.
"""

from math import cos, pi, sin, sqrt

import numpy as np
import sympy as sp

import symfric as sf

k = 4 / 3  # of the contact
frame = np.zeros((2, 2))
for stiffness, angle in ((0.2, 5 * pi / 6), (2.4, pi / 6)):
    frame += stiffness * np.outer([cos(angle), sin(angle)], [cos(angle), sin(angle)])
K = frame + np.diag([0.0, k])
brake = sf.structures.Structure(np.eye(2), K, friction=np.array([[0.0, -k], [0.0, 0.0]]))
first = sf.structures.flutter(brake, mu=(0.0, 2.0), count=2).critical[0]
told = ((K[0, 0] - K[1, 1]) ** 2 / 4 + K[0, 1] ** 2) / (K[0, 1] * k)
print(f"squeals from mu = {first.mu:.9f} on, at omega = {first.omega:.9f}")
print(f"closed form mu = {told:.9f}, omega = {sqrt((K[0, 0] + K[1, 1]) / 2):.9f}")

x, y, u, w = sp.symbols("x y u w", real=True)  # along the belt and into it
mu, v_b, d, N_0 = sp.symbols("mu v_b d N_0", positive=True)
load = sp.Max(0, N_0 + k * y)  # it may lift off
held = -sp.Matrix(frame) * sp.Matrix([x, y]) - d * sp.Matrix([u, w])
mass = sf.Scene(
    system=sf.System(q=[x, y], u=[u, w], mass=sp.eye(2), force=[held[0], held[1] + N_0 - load]),
    contacts=[sf.Contact("belt", slip=u - v_b, normal=load, law=sf.laws.coulomb(mu))],
    values={mu: 0.8, v_b: 2.0, d: 0.01, N_0: 1.0},
    initial={x: 0.5, y: -0.1, u: 0.0, w: 0.0},
    horizon=1000.0,
    outputs={"x": sf.HalfRange(x, after=900), "y": sf.HalfRange(y, after=900)},
)
for coefficient in (0.65, 0.8, 1.0):
    late = sf.simulate(mass.where({mu: coefficient})).checked()
    print(f"mu = {coefficient:g}: moves by +-{late['x']:.3f} along the belt and +-{late['y']:.3f} across it")
