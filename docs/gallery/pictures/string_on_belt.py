"""The string at twelve times of a period, with 30 modes: two nearly straight lines whose corner runs round."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
place = np.linspace(0, 1, 300)
shapes = np.sin(np.pi * np.outer(place, j))
for t in run.t_final - period * np.arange(12) / 12:
    ax.plot(place * length, 1e3 * shapes @ run(t)[:n], color="C0", linewidth=0.9)
ax.axvline(b * length, color="0.6", linewidth=0.8)
ax.set(xlabel="place along the string [m]", ylabel="displacement [mm]")
