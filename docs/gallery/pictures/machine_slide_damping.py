"""Damping ratio that the slide needs, against its feed."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
feeds = np.linspace(0.0055, 0.06, 60)
needed = [brentq(spare, 0.0, 0.9, (f,)) if spare(0.0, f) < 0 else 0.0 for f in feeds]
ax.plot(1e3 * feeds, needed)
ax.fill_between(1e3 * feeds, needed, 0, color="0.92")
ax.text(10, 0.5 * max(needed), "stick-slip below the curve")
ax.set(xlabel="feed [mm/s]", ylabel="damping ratio", ylim=(0, None))
