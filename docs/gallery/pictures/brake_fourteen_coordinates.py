"""Frequencies of the fourteen modes over the coefficient of friction: pattern by pattern they meet."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
coefficients = np.linspace(0, 1.5, 150)
frequency = [np.sort(brake.complex_modes(14, mu=mu, near=1.0j).eigenvalues.imag) for mu in coefficients]
ax.plot(coefficients, frequency, ".", color="C0", markersize=2)
for point in found:
    ax.axvline(point.mu, color="0.6", linewidth=0.8)
ax.set(xlabel="coefficient of friction", ylabel="frequency", ylim=(0.5, None))
