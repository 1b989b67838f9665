"""First-order and total Sobol indices of the half range."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
place = np.arange(len(names))
ax.bar(place - 0.2, indices["S1"], 0.4, yerr=indices["S1_conf"], label="first order")
ax.bar(place + 0.2, indices["ST"], 0.4, yerr=indices["ST_conf"], label="total")
ax.set_xticks(place, names)
ax.set_ylabel("index")
ax.legend()
