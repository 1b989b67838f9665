"""Transport speed over the frequency of the track: the part slides forward, then flies."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
ax.plot(frequency, 1e3 * speed, "o-", markersize=3)
ax.axvline(flies, color="0.6", linewidth=0.8)
ax.set(xlabel="frequency [Hz]", ylabel="transport speed [mm/s]")
