"""How stiff must the rock around a fault be, so that it creeps and makes no earthquakes?

A block on a spring that is drawn slowly, with rate-and-state friction. Ruina (Journal of Geophysical Research 88,
1983, 10359) found steady creep unstable below the stiffness N (b - a)/D_c; Rice and Ruina (Journal of Applied
Mechanics 50, 1983, 343) added the inertia, which raises it by the factor 1 + m V^2/(N a D_c).
"""

import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
k, V, m, N = sp.symbols("k V m N", positive=True)
a, b, D_c = 0.010, 0.015, 1e-5  # laboratory values, D_c in m
law = sf.laws.rate_and_state(0.6, a, b, D_c, V0=1e-6, smooth=False)
fault = sf.Contact("fault", slip=u + V, normal=N, law=law)
values = {k: 600.0, V: 1e-4, m: 1.0, N: 1.0}
block = sf.System(q=[x], u=[u], mass=[[m]], force=[-k * x])
scene = sf.Scene(block, [fault], values, {x: 0.0, u: 0.0}, 1.0)

for load, speed, mass in ((1.0, 1e-4, 0.1), (1.0, 1e-3, 0.1), (4.0, 1e-3, 1.0)):
    point = sf.hopf(scene.where({N: load, V: speed, m: mass}), k, bracket=(50.0, 20000.0))
    slow = load * (b - a) / D_c
    told = slow * (1 + mass * speed**2 / (load * a * D_c))
    print(f"N = {load:g}, V = {speed:g}, m = {mass:g}: creeps above k = {point.value:.6f}, published {told:.6f}")
