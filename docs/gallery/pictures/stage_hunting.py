"""Position of the stage about its target over three periods of the hunting: it rests, breaks away and slips past."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
t = np.linspace(0, 3 * cycle.period, 1500)
ax.plot(t, 1e3 * cycle.run(t % cycle.period)[0])
ax.axhline(0, color="0.6", linewidth=0.8)
ax.set(xlabel="time", ylabel="position from the target / 1000")
