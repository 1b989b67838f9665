"""Paths of the mass over one period: a circle in the plane, a smaller rounded square of both directions alone."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
for name, (a, b) in paths.items():
    ax.plot(a, b, label=name)
ax.set_aspect("equal")
ax.set(xlabel="x [m]", ylabel="y [m]")
ax.legend(frameon=False, loc="upper left", bbox_to_anchor=(1, 1))
