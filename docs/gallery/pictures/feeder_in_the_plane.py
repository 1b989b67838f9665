"""Speed of the creep over the tilt: closed form and computed points."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
line = np.linspace(0.2, 12, 100)
ax.plot(line, [1e3 * closed_form(radians(e)) for e in line], label="closed form")
for f, speeds in creep.items():
    ax.plot(angles, 1e3 * np.array(speeds), "o", label=f"computed, {f} Hz")
ax.set(xlabel="tilt [deg]", ylabel="speed down the side [mm/s]", ylim=(0, None))
ax.legend(frameon=False)
