"""Position of the table after the drive has stopped: it overruns, swings and is held by friction."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
path = sf.simulate(scene.wanting({"path": sf.Trajectory()}))
ax.plot(1e3 * path.t / omega, 1e6 * length * path.x[0])
ax.set(xlabel="time [ms]", ylabel="displacement of the spring [um]", xlim=(0, 20))
