"""Displacement of the pad against time at 50 mm/s: it grows until the pad sticks to the disc once in every period."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
path = sf.simulate(pad.wanting({"path": sf.Trajectory()}).until(0.15))
ax.plot(1e3 * path.t, 1e3 * path.x[0])
ax.set(xlabel="time [ms]", ylabel="displacement of the pad [mm]")
