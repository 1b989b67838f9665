"""Paths of the block on the slope for three friction coefficients: the less friction, the further down it bends."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
for factor in (1.05, 1.5, 3.0):
    path = sf.simulate(scene.where({mu: factor * tan(angle)}).until(4.0))
    points = path(np.linspace(0, path.t_final, 400))
    ax.plot(100 * points[0], -100 * points[1], label=f"mu = {factor:g} tan(slope)")
    ax.plot(100 * path["x"][-1], -100 * path["y"][-1], "ko", markersize=4)
ax.set(xlabel="across the slope [cm]", ylabel="up the slope [cm]", ylim=(-70, 5))
ax.legend(frameon=False)
