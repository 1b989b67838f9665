"""Where does a block stop that is pushed across a slope?

It slides on a slope of 20 degrees at 1 m/s, across. Friction opposes the velocity, a vector, so that the block bends
down while it slows down. Against the closed form for constant friction, and at the limit mu = tan(slope) the half of
the first speed, which textbooks ask for: there the block never stops and ends up sliding straight down at 0.5 m/s.
"""

from math import radians, tan

import sympy as sp

import symfric as sf

x, y, u, w = sp.symbols("x y u w", real=True)  # across and down the slope
mu, alpha, g = sp.symbols("mu alpha g", positive=True)
slope = sf.System(q=[x, y], u=[u, w], mass=sp.eye(2), force=[0, g * sp.sin(alpha)])
board = sf.Contact("board", slip=(u, w), normal=g * sp.cos(alpha), law=sf.laws.coulomb(mu))
angle = radians(20.0)
values = {mu: 1.5 * tan(angle), alpha: angle, g: 9.81}
scene = sf.Scene(slope, [board], values, {x: 0, y: 0, u: 1.0, w: 0}, 1.0)

run = sf.simulate(scene, tolerance=1e-12)
told = sf.theory.plane.incline_stop(angle, values[mu], speed=1.0)
stop = next(event for event in run.events if event.kind == "stick")
print(f"stops after {stop.t:.10f} s, closed form {told.time:.10f} s")
across, down = 100 * run["x"][-1], 100 * run["y"][-1]
print(f"{across:.4f} cm across ({100 * told.cross:.4f}), {down:.4f} cm down ({100 * told.downslope:.4f})")

limit = sf.simulate(scene.where({mu: tan(angle)}).until(30.0), tolerance=1e-12)
print(f"with mu = tan(slope) it ends at {limit['w'][-1]:.6f} m/s")
