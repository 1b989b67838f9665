"""Displacement of the string under the bow at 0.2 m/s: the teeth of stick and slip."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
run = sf.simulate(string)
late = run.t > 0.48
ax.plot(1e3 * run.t[late], 1e3 * run.x[0][late])
ax.set(xlabel="time [ms]", ylabel="displacement of the string [mm]")
