"""How fast does a vibratory conveyor carry a part, over the frequency, and when does the part begin to fly?

A level track shakes with 2 mm along a line at 30 degrees. The friction coefficient of part and track is 0.4; a part
that lands bounces a little (restitution 0.1).
"""

from math import pi, radians, sin, sqrt

import numpy as np

import symfric as sf

a, beta = 0.002, radians(30.0)  # m, rad
scene = sf.scenes.vibratory_conveyor(mu=0.4, a=a, Omega=60.0, beta=beta, e=0.1, horizon=4.0)
frequency = np.arange(6.0, 40.5, 1.0)  # Hz
table = sf.sweep(scene.wanting({"distance": sf.At(scene.system.q[0])}), {"Omega": 2 * pi * frequency})
speed = table["distance"].values / scene.horizon  # m/s
for f in (10.0, 20.0, 30.0, 40.0):
    print(f"{f:.0f} Hz: {1e3 * speed[list(frequency).index(f)]:.0f} mm/s")

flies = sqrt(9.81 / (a * sin(beta))) / (2 * pi)  # where the track falls away faster than the part
for factor in (0.98, 1.02):
    run = sf.simulate(scene.where({"Omega": 2 * pi * factor * flies}))
    print(f"{factor * flies:.2f} Hz: {sum(event.kind == 'open' for event in run.events)} flights in 4 s")
print(f"the part leaves the track above {flies:.2f} Hz")
