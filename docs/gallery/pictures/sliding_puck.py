"""The ratio of sliding to spin over the time: two starts tend to the same value as the puck stops."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
for spin, run in motions.items():
    t = np.linspace(0, run.t_final, 400)
    ax.plot(t / run.t_final, run(t)[3] / (R * run(t)[5]), label=f"{spin:g} rad/s")
ax.axhline(sf.theory.plane.disc_stop_ratio(), color="0.6", linewidth=0.8)
ax.set(xlabel="time over the time of the stop", ylabel="v/(R omega)")
ax.legend(frameon=False)
