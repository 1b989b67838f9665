"""How fast may a cam turn before its follower lifts off, and how hard does it strike beyond that?

A follower of 0.5 kg is pressed on a cam of 20 mm lift by a spring of 400 N/m with 20 mm of deflection at the bottom.
"""

from math import pi, sqrt

import symfric as sf

m, k, preload, h = 0.5, 400.0, 0.02, 0.01  # kg, N/m, m, half of the lift in m
cam = sf.scenes.cam_follower(m=m, k=k, preload=preload, h=h, Omega=50.0, e=0.3, c=2.0)
limit = sqrt(k * (2 * h + preload) / (m * h))  # without damping
print(f"lifts off above {60 * limit / (2 * pi):.0f} rpm without damping")

turning = sf.prepare(cam.wanting({"least": sf.Min(sf.normal_force("cam"))}), 1e-11)
low, high = 0.8 * limit, 1.5 * limit
for _ in range(40):  # with damping: where the least normal force becomes zero
    middle = 0.5 * (low + high)
    low, high = (middle, high) if turning.run({"Omega": middle})["least"] > 1e-9 else (low, middle)
print(f"with the damping of 2 N s/m above {60 * low / (2 * pi):.0f} rpm")

run = sf.simulate(cam.where({"Omega": 1.2 * low}))
hits = [event for event in run.events if event.kind == "impact"]
print(f"20 % faster it strikes {len(hits)} times in 20 turns")
