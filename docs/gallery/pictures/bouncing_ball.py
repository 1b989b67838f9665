"""The orbit of the driven mass that strikes its stop once in a period: at the impact its velocity is turned back."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
points = orbit.run(np.linspace(0, orbit.period, 1000))
ax.plot(points[0], points[1])
ax.axvline(0, color="0.6", linewidth=0.8)
ax.set(xlabel="displacement", ylabel="velocity")
