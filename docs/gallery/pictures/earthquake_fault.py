"""Slip speed over time with a stiffness 2 % above and 2 % below the critical one: creep comes back or not."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
slow = scene.where({N: 1.0, V: 1e-4, m: 0.1})
critical = sf.hopf(slow, k, bracket=(50.0, 20000.0)).value
for factor, label in ((1.02, "2 % stiffer"), (0.98, "2 % softer")):
    at = slow.where({k: factor * critical})
    rest = sf.equilibrium(at).x
    names = [s.name for s in at.system.states]
    start = {n: float(v) for n, v in zip(names, rest, strict=True)}
    start["x"] *= 1.0 + 1e-4
    run = sf.simulate(at.starting(start).until(20.0))
    t = np.linspace(0.1, run.t_final, 2000)
    ax.plot(t, (run(t)[1] + 1e-4) * 1e3, label=label, linewidth=0.9)
ax.set(xlabel="time [s]", ylabel="slip speed [mm/s]")
ax.legend(frameon=False)
