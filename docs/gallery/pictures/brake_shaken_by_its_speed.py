"""Share of the friction that is left over the sliding speed: shaken always alike, or with the measured speed."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
speeds = np.linspace(0.1, 0.5, 81)
ax.plot(speeds, 100 * left(always, speeds), label="fixed intensity")
few = speeds[::4]
ax.plot(few, [100 * left(following.values["k"] * v, v) for v in few], label="intensity follows the speed")
ax.set(xlabel="sliding speed [m/s]", ylabel="friction left [%]", ylim=(0, None))
ax.legend(frameon=False)
