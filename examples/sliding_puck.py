"""How does a puck stop that slides and spins?

Every element of its bottom slides in its own direction, so that spin takes friction from the sliding and sliding from
the spin. Whatever the start, both end at the same instant, with one ratio of the speeds: v/(R omega) = 0.653 for a
disc of even pressure, computed and measured by Farkas, Bartels, Unger and Wolf (Physical Review Letters 90, 2003,
248302).
"""

import sympy as sp

import symfric as sf

x, y, angle, u, w, omega = sp.symbols("x y angle u w omega", real=True)
R, mu, g = 0.04, 0.2, 9.81  # m, -, m/s^2
forces = sf.theory.plane.disc_expressions(u, w, omega, R)
inertia = R**2 / 2  # over the mass
puck = sf.System(q=[x, y, angle], u=[u, w, omega], mass=sp.diag(1, 1, inertia), force=[mu * g * f for f in forces])

motions = {}
for spin in (10.0, 40.0):  # rad/s
    stop = sf.theory.plane.disc_stop(v=1.0, omega=spin, R=R, m=1.0, mu=mu)
    start = {x: 0, y: 0, angle: 0, u: 1.0, w: 0, omega: spin}
    run = sf.simulate(sf.Scene(puck, values={}, initial=start, horizon=(1 - 1e-5) * stop.time)).checked()
    motions[spin] = run
    print(
        f"{spin:.0f} rad/s: {run.final[0]:.4f} m in {stop.time:.4f} s, at the end v/(R omega) = "
        f"{run.final[3] / (R * run.final[5]):.4f}"
    )
print(f"closed form {sf.theory.plane.disc_stop_ratio():.6f}")
