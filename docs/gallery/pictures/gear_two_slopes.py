"""Measured friction of the gear and the two lines through it: falling below the corner, rising above."""

import matplotlib.pyplot as plt

ax = fit.plot(plt.figure().add_subplot())
ax.set(xlabel="pitch line velocity [m/s]", ylabel="coefficient of friction")
