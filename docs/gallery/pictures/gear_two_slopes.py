"""Friction law of the gear: two straight lines, falling up to 2 m/s."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
speed = np.linspace(1e-6, 4, 200)
ax.plot(speed, law(speed))
ax.axvspan(0, 2, color="0.92")
ax.text(1.0, 0.045, "falls: chatters", ha="center")
ax.text(3.0, 0.045, "rises: smooth", ha="center")
ax.set(xlabel="sliding speed [m/s]", ylabel="coefficient of friction", ylim=(0, None), xlim=(0, 4))
