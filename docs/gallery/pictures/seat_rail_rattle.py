"""Place of the slide in its rail at 22 m/s²: it strikes both ends in every period."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
t = np.linspace(2.9, 3.0, 2000)
ax.plot(1e3 * (t - 2.9), 1e3 * run(t)[0])
for end in (-1, 1):
    ax.axhline(end, color="0.6", linewidth=0.8)
ax.set(xlabel="time [ms]", ylabel="place in the rail [mm]")
