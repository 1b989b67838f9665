"""Part of the friction that is left over the ratio of sideways to sliding speed: closed form and computed points."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
line = np.linspace(0, 6, 200)
ax.plot(line, 2 / np.pi / np.sqrt(1 + line**2) * ellipk(line**2 / (1 + line**2)), label="closed form")
ax.plot(ratios, parts, "o", label="computed motion")
ax.set(xlabel="sideways speed over sliding speed", ylabel="friction left", ylim=(0, 1.05))
ax.legend(frameon=False)
