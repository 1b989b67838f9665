"""Path of the mass at mu = 1 in the end: along the belt and into it."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
last = sf.simulate(mass.where({mu: 1.0}).wanting({"path": sf.Trajectory()}))
along, into = last(np.linspace(950, 1000, 4000))[:2]
ax.plot(along, into, linewidth=0.8)
ax.axhline(-1 / k, color="0.6", linewidth=0.8)
ax.annotate("no contact below", (along.max(), -1.02 / k), va="top", ha="right", color="0.4")
ax.set(xlabel="displacement along the belt", ylabel="displacement into the belt")
