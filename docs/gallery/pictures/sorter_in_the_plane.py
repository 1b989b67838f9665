"""Paths of the parcel in the hall: a parabola until it rests on the belt, and that of both directions alone."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
for name, run in runs.items():
    path = run(np.linspace(0, run.t_final, 400))
    ax.plot(path[0], path[1], label=name)
ax.set(xlabel="along the belt [m]", ylabel="across the belt [m]")
ax.legend(frameon=False)
