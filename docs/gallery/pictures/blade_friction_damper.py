"""Amplitude of the blade's tip over the frequency of the excitation for three normal loads."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
for load in (0.1, 0.45, 1.5):
    branch = sf.frequency_response(forced.where({N: load}), W, (3.4, 3.9), "w12", tolerance=1e-7)
    k = branch.orbits[0].names.index("w12")
    ax.semilogy(branch.values, [o.half_range[k] for o in branch.orbits], label=f"N = {load}")
ax.set(xlabel="omega", ylabel="half range of the tip")
ax.legend(frameon=False)
