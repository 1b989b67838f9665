"""Height of the follower over three turns of the cam, 20 % above the speed at which it lifts off."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
turn = 2 * pi / (1.2 * low)
t = np.linspace(0, 3 * turn, 1000)
ax.plot(t / turn, 1e3 * run(t)[0], label="follower")
ax.plot(t / turn, 1e3 * h * (1 - np.cos(2 * pi * t / turn)), linewidth=0.8, label="cam")
ax.set(xlabel="turns", ylabel="height [mm]")
ax.legend()
