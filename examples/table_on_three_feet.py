"""How far does an instrument table walk and turn on a shaking floor that is not level, with one worn foot of three?

The floor shakes along x and falls by 1.5 degrees along y; the feet carry equal loads. With equal feet the table slides
without turning, once the shaking and the fall together exceed the friction. With a worn foot it gives way earlier, and
turns: in the motion in which the largest friction forces do the least work for that of shaking and weight. At rest the
forces of the single feet are not unique; this motion, and when it starts, are.
"""

from math import cos, pi, radians, sin

import numpy as np
import sympy as sp
from scipy.optimize import minimize

import symfric as sf

q = x, y, turn = sp.symbols("x y phi", real=True)
u = v_x, v_y, omega = sp.symbols("v_x v_y omega", real=True)
worn, shaken = sp.symbols("mu_worn a", positive=True)
m, radius, inertia, g, mu, rate = 60.0, 0.45, 5.5, 9.81, 0.6, 2 * pi * 2.0  # kg, m, kg m^2, m/s^2, -, rad/s
weight, load = m * g * sin(radians(1.5)), m * g * cos(radians(1.5)) / 3  # along the floor; of a foot
PLACES = [(radius * cos(radians(k)), radius * sin(radians(k))) for k in (150, 270, 30)]


def slips(a, b):
    """Return the velocity of the foot at (a, b) on the table, relative to the floor."""
    c, s = sp.cos(turn), sp.sin(turn)
    return v_x - omega * (a * s + b * c), v_y + omega * (a * c - b * s)


law = sf.laws.coulomb
feet = [sf.Contact("worn", slips(*PLACES[0]), load, law(worn))]
feet += [sf.Contact(f"foot {k}", slips(*PLACES[k]), load, law(mu)) for k in (1, 2)]
push = [-m * shaken * sp.sin(rate * sf.TIME), weight, 0]  # in the frame of the floor
table = sf.System(q, u, sp.diag(m, m, inertia), push)
outputs = {"start": sf.Events(), "end": sf.End(), "path": sf.Trajectory()}
values = {worn: 0.3, shaken: 6.5}
scene = sf.Scene(table, feet, values, dict.fromkeys([*q, *u], 0), 3.0, outputs)


def gives_way(coefficients):
    """Return the least acceleration of the floor, m/s^2, that moves the table."""

    def needed(motion):
        v, w = motion  # of the centre down the floor and about the vertical, where it goes at 1 m/s against x
        slips = [np.hypot(1 + w * b, v + w * a) for a, b in PLACES]
        return load * np.dot(coefficients, slips) - weight * v

    return minimize(needed, (0.1, 0.1), method="Nelder-Mead", options={"xatol": 1e-12, "fatol": 1e-13}).fun / m


program = sf.prepare(scene)
runs = {c: program.run({worn: c}).checked() for c in (mu, 0.3)}
for c, run in runs.items():
    began = 6.5 * sin(rate * run.events[0].t)
    print(f"foot of {c}: moves at {began:.6f} m/s2, by the least work at {gives_way((c, mu, mu)):.6f}")
    print(f"  after 3 s: {1e3 * run.final[1]:.2f} mm down the floor, turned by {np.degrees(run.final[2]):.3f} degrees")
