"""Speed of the disc relative to the shaft while the car catches up within four seconds: it judders at the end."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
t = np.linspace(0, run.t_final, 6000)
ax.plot(t, run(t)[1], linewidth=0.8, label="disc")
ax.plot(t, 12 * (1 - t / 4), color="C1", label="slip of the clutch")
ax.axhline(0, color="0.6", linewidth=0.8)
ax.set(xlabel="time [s]", ylabel="speed [rad/s]")
ax.legend(frameon=False)
