"""How wrong is it to compute a sliding isolator in two directions, each alone?

Friction opposes the velocity vector: a bearing that slides fast along x has hardly any friction left along y, as
Mosqueda, Whittaker and Fenves measured (Journal of Structural Engineering 130, 2004, 433-442). A rotating acceleration
of the size A shows it most clearly: the mass runs around a circle, with friction along the circle and the spring across
it, so that its radius is sqrt(A^2 - (mu g)^2)/|g/R - Omega^2|. Computed alone, each direction keeps the whole friction
force.
"""

from math import pi, sqrt

import numpy as np
import sympy as sp

import symfric as sf

x, y, u, w = sp.symbols("x y u w", real=True)
R, mu, g = 2.0, 0.06, 9.81  # m, -, m/s^2
Omega, A = 2 * pi * 0.6, 1.2  # rad/s, m/s^2
shaking = [-A * sp.cos(Omega * sf.TIME), -A * sp.sin(Omega * sf.TIME)]


def settled(slips):
    """Return the path of the isolator over the last period."""
    contacts = [sf.Contact(f"bearing {k}", slip, normal=g, law=sf.laws.coulomb(mu)) for k, slip in enumerate(slips)]
    system = sf.System([x, y], [u, w], sp.eye(2), [s - g / R * q for s, q in zip(shaking, (x, y), strict=True)])
    run = sf.simulate(sf.Scene(system, contacts, {}, dict.fromkeys((x, y, u, w), 0.0), horizon=200.0)).checked()
    return run(np.linspace(run.t_final - 2 * pi / Omega, run.t_final, 400))[:2]


paths = {"in the plane": settled([(u, w)]), "both directions alone": settled([u, w])}
for name, (a, b) in paths.items():
    print(f"{name}: peak along x {np.max(np.abs(a)):.5f} m, of the vector {np.max(np.hypot(a, b)):.5f} m")
print(f"radius of the circle in closed form {sqrt(A**2 - (mu * g) ** 2) / abs(g / R - Omega**2):.5f} m")
