"""Measured coefficients of friction and the law put through them."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
grid = np.linspace(1e-6, 1.2, 300)
ax.plot(grid, law.where({b: best})(grid), label="law")
ax.plot(speed, mu, "o", label="measured")
ax.plot(0, 1.2, "s", label="static friction")
ax.set(xlabel="wiping speed [m/s]", ylabel="coefficient of friction", ylim=(0, 1.3))
ax.legend(frameon=False)
