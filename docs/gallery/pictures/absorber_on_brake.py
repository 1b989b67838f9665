"""Growth rate of the pad with absorber over tuning and damping; the best point is marked."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
tunings, dampings = np.linspace(0.8, 1.0, 6), np.linspace(0.1, 0.3, 5)
levels = np.array([[found[t, d] for t in tunings] for d in dampings])
filled = ax.contourf(tunings, dampings, levels, levels=12, cmap="viridis")
ax.figure.colorbar(filled, label="decay rate [1/s]")
ax.plot(best, damper, "o", color="white", markeredgecolor="black")
ax.set(xlabel="frequency of the absorber / frequency of the pad", ylabel="damping ratio of the absorber")
