"""Lobes of the closed form: above them the lathe chatters. Dots: found from the growth of runs."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
w = np.linspace(1.001, 1.7, 2000)
depth = [(w**2 - 1) ** 2 + (2 * zeta * w) ** 2, 2 * (w**2 - 1)]
for n in (1, 2, 3):
    turns = 2 * (n * pi - np.arctan((w**2 - 1) / (2 * zeta * w))) / w
    ax.plot(2 * pi / turns, depth[0] / depth[1], color="C0")
for turn in (4.0, 5.0, 9.0):
    ax.plot(2 * pi / turn, brentq(growth, 0.05, 0.25, args=(turn,)), "o", color="C1", markersize=4)
ax.set(xlabel="speed of turning", ylabel="stiffness of the cut K", xlim=(0.3, 2), ylim=(0, 0.6))
