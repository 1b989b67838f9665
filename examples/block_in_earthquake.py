"""How strong may an earthquake be before a cabinet rocks, and before it falls over?

A uniform cabinet, 2.0 m high and 0.5 m wide, stands free on a rough floor (friction 0.8).
"""

from math import atan2, hypot, pi, tan

import symfric as sf

half_width, half_height = 0.25, 1.0  # m
alpha = atan2(half_width, half_height)
quake = sf.motions.synthetic(duration=10.0, dt=0.02, seed=3, pga=1.0, unit="g")
block = sf.scenes.rocking_block(R=hypot(half_width, half_height), alpha=alpha, motion=quake, mu=0.8)
print(f"rocks above {tan(alpha):.2f} g at the peak")

program = sf.prepare(block)
runs = {pga: program.run({"amplitude": pga}) for pga in (0.2, 0.4, 0.8)}
for pga, run in runs.items():
    tilt = run["largest_tilt"]
    words = f"tilts by {tilt / alpha:.2f} of the angle at which it falls" if tilt > 1e-9 else "stands still"
    words = "falls over" if tilt > pi / 2 - 0.01 else words
    print(f"{pga:.1f} g: {words}")
