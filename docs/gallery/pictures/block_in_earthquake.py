"""Angle of the cabinet under the earthquake of 0.4 g: it rocks from one corner to the other and comes to rest."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
run = runs[0.4]
t = np.linspace(0, run.t_final, 2000)
ax.plot(t, run(t)[2] / alpha)
ax.set(xlabel="time [s]", ylabel="angle over that at which it falls")
