"""Phase portrait of the last periods, 10 % above the force at which the orbit touches the stop."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
t, x, _ = run.path.line(np.linspace(390 * period, 400 * period, 4000))
ax.plot(x[0], x[1], linewidth=0.8)
ax.axvline(1.0, color="0.6", linewidth=0.8)
ax.set(xlabel="x", ylabel="x'")
