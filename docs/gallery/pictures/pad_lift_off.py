"""Motion of the pad for the largest coupling, along the disc and away from it."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
t = np.linspace(150.0, 165.0, 1500)
path = sf.simulate(pad.wanting({"path": sf.Trajectory()}))
ax.plot(t, path(t)[0], label="along the disc")
ax.plot(t, 10 * path(t)[1], label="10 x away from it")
ax.set(xlabel="time", ylabel="displacement")
ax.legend()
