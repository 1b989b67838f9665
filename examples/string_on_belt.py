"""How does a guitar string move that a running belt rubs as a bow would?

A string of 110 Hz, 0.65 m and 5 g/m as a sum of its modes; the belt of 0.1 m/s touches it at the fraction b of its
length. Helmholtz saw two straight lines with a corner that runs round, so that the string slips for the fraction b of
a period (Schelleng, Journal of the Acoustical Society of America 53, 1973, 26). The sum of n modes rounds the corner.
"""

import numpy as np

import symfric as sf

b, v, f, length, rho = 0.13, 0.1, 110.0, 0.65, 0.005  # -, m/s, Hz, m, kg/m
law = sf.laws.stribeck(0.8, 0.3, 0.1)
for n in (10, 20, 30):
    j = np.arange(1, n + 1)
    mass, omega = np.full(n, rho * length / 2), 2 * np.pi * f * j
    string = sf.structures.Structure(np.diag(mass), np.diag(mass * omega**2), np.diag(0.004 * mass * omega))
    belt = sf.structures.RowContact("belt", np.sin(np.pi * b * j), 0.5, law, speed=v)  # under 0.5 N
    scene = string.scene([belt], values={}, initial={}, horizon=0.2)
    turning = dict(zip(scene.system.u, 2 * v / (np.pi * b * j) * (-1.0) ** (j + 1), strict=True))  # as Helmholtz saw it
    run = sf.simulate(scene.starting(turning), 1e-8).checked()
    late = [event for event in run.events if event.t > 0.12]
    slips = np.array([event.t for event in late if event.kind == "slip"])
    sticks = np.array([event.t for event in late if event.kind == "stick" and event.t > slips[0]])
    period = np.mean(np.diff(slips))
    fraction = np.mean(sticks[: len(slips)] - slips[: len(sticks)]) / period
    print(f"{n} modes: {1 / period:.2f} Hz, slips for {fraction:.4f} of a period")
print(f"Helmholtz: {f:.2f} Hz, slips for {b:.4f} of a period")
