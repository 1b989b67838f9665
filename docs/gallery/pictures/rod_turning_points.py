"""Decay of the rod with the friction and damping found; circles are the turning points that were read off."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
path = sf.simulate(rod.wanting({"path": sf.Trajectory()}))
ax.plot(path.t, 1e3 * path.x[0])
times = 0.5 / f_n * np.arange(4)
ax.plot(times, 1e3 * np.array(points) * (-1.0) ** np.arange(4), "o", fillstyle="none")
ax.set(xlabel="time [s]", ylabel="displacement [mm]")
