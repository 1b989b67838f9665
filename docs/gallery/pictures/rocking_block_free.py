"""Tilt of the block over time, in parts of the angle at which it would fall: each impact takes some of the swing."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
for alpha, (run, row) in motions.items():
    t = np.linspace(0, run.t_final, 800)
    ax.plot(t, run(t)[row] / alpha, label=f"alpha = {alpha:g}")
ax.set(xlabel="time [s]", ylabel="tilt over alpha")
ax.legend(frameon=False)
