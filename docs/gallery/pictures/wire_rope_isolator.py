"""Force of the strands over the displacement in a cycle at 12 Hz; dots: tips of the closed form."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
moved, _, part = orbit.run(np.linspace(0, orbit.period, 600))
ax.plot(1e3 * moved, 150.0 * part)
ax.plot([-1e3 * X, 1e3 * X], [-150.0 * Z, 150.0 * Z], "o", color="C1", markersize=4)
ax.set(xlabel="displacement of the cabinet [mm]", ylabel="force of the strands [N]")
