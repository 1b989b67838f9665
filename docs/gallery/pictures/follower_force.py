"""Frequencies of both modes over the load, without damping: they meet where the column begins to flutter."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
load = np.linspace(0, 3, 400)
frequency = [np.sort(bars.complex_modes(2, mu=p, near=1.0j).eigenvalues.imag) for p in load]
ax.plot(load, frequency, color="C0")
ax.axvline(3.5 - sqrt(2), color="0.6", linewidth=0.8)
ax.set(xlabel="load P l/k", ylabel="frequency / sqrt(k/m)/l")
