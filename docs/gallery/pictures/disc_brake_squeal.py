"""Frequencies and growth rates of four modes of the brake against the coefficient of friction; two of them couple."""

import matplotlib.pyplot as plt

upper, lower = plt.figure().subplots(2, 1, sharex=True)
for values in flutter.eigenvalues:
    upper.plot(flutter.mu, values.imag, "o-", markersize=3)
    lower.plot(flutter.mu, values.real, "o-", markersize=3)
lower.axvline(first.mu, color="0.6", linestyle="--")
lower.axhline(0, color="0.6", linewidth=0.8)
upper.set_ylabel("omega")
lower.set(xlabel="coefficient of friction mu", ylabel="growth rate")
