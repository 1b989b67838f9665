"""How much of the shaking of a deck reaches a cabinet on wire ropes, and how much do the ropes dissipate?

The strands of a rope slip on each other, so that force and displacement form a smooth loop (Wen, Journal of the
Engineering Mechanics Division 102, 1976, 249). With beta = gamma and n = 1 it unloads as a spring and loads as
F (1 - exp(-s/l)). So the loop of an amplitude X is closed: its tip is Z = 1 - exp(Z - 2 X/l), and it dissipates
2 F l (2 X/l - 2 Z - Z^2/2) in a cycle.
"""

from math import exp, pi

import sympy as sp
from scipy.optimize import brentq

import symfric as sf

x, u = sp.symbols("x u", real=True)  # of the cabinet relative to the deck
m, k, F, a, Omega = sp.symbols("m k F a Omega", positive=True)
l = 2e-3  # m, within which a rope yields
rope = sf.Contact("rope", slip=u, normal=F, law=sf.laws.bouc_wen(1 / l, 0.5 / l, 0.5 / l, 1))
cabinet = sf.Scene(
    system=sf.System(q=[x], u=[u], mass=[[m]], force=[-k * x - m * a * sp.sin(Omega * sf.TIME)]),
    contacts=[rope],
    values={m: 80.0, k: 3e4, F: 150.0, a: 4.0, Omega: 40.0},  # kg, N/m, N, m/s2, rad/s
    initial={x: 0.0, u: 0.0},
    horizon=20.0,
)
force = sf.friction_force("rope")
outputs = {"felt": sf.HalfRange((force - k * x) / m), "lost": sf.Integral(-force * u)}
for f in (4.0, 8.0, 12.0):
    shaken = cabinet.where({Omega: 2 * pi * f})
    orbit = sf.limit_cycle(shaken)
    cycle = shaken.starting(dict(zip(orbit.names, orbit.start, strict=True))).until(orbit.period, outputs)
    run = sf.simulate(cycle, 1e-10).checked()
    X = orbit.half_range[0]
    Z = brentq(lambda z, X=X: 1 - exp(z - 2 * X / l) - z, 1e-9, 1)
    told = 2 * 150.0 * l * (2 * X / l - 2 * Z - Z**2 / 2)
    print(f"{f:4.1f} Hz: moves by +-{1e3 * X:.3f} mm, feels {run['felt'] / 4.0:.3f} of the deck", end="; ")
    print(f"dissipates {run['lost']:.7f} J a cycle, closed form {told:.7f} J")
