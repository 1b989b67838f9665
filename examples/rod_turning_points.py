"""How much friction and how much damping has a rod, by the turning points of its decay?

A rod of 5.3 Hz, pressed on a disk with its weight, is let go at 10 mm; its turning points are read off to 0.01 mm.
"""

import numpy as np

import symfric as sf

f_n = 5.3
points = [10.00e-3, 7.06e-3, 4.00e-3, 0.77e-3]  # m, alternately to the one side and the other
fit = sf.theory.decay_record.from_turning_points(points, f_n=f_n)
print(f"friction {fit.mu_m:.3f}, damping ratio {fit.zeta:.4f}")

rod = sf.scenes.contact_damper(f_n=f_n, mu_m=fit.mu_m, zeta=fit.zeta)
run = sf.simulate(rod)
stops = [f"{1e3 * abs(float(run(event.t)[0])):.2f}" for event in run.events]
print(f"with these it turns at {', '.join(stops)} mm and rests after {run['stop_time']:.4f} s")

rng = np.random.default_rng(0)  # what does it cost to read them off less exactly?
for error in (0.01e-3, 0.1e-3):
    fits = [sf.theory.decay_record.from_turning_points(points + rng.normal(0, error, 4), f_n=f_n) for _ in range(500)]
    mu_m, zeta = np.std([e[:2] for e in fits], axis=0)
    print(f"read to {1e3 * error:g} mm: friction +-{mu_m:.4f}, damping ratio +-{zeta:.4f}")
