"""Speed of the bit over two cycles at 120 rpm of the top: it stands still, breaks loose and turns twice as fast."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
t = np.linspace(0, 2 * orbit.period, 1200)
ax.plot(t, (orbit.run(t % orbit.period)[1] + top) * 30 / np.pi)
ax.axhline(rpm, color="0.6", linewidth=0.8)
ax.set(xlabel="time [s]", ylabel="speed of the bit [rpm]")
