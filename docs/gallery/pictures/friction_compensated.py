"""Position of the stage: with too little compensation it rests beside its target, with too much it shakes."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
t = np.linspace(0, 4, 1500)
for level in (0.5, 1.3):
    shown = stage.where({F: level}).starting({force.symbol: -level}).until(4.0, {"path": sf.Trajectory()})
    ax.plot(t, 1e3 * sf.simulate(shown)(t)[0], linewidth=0.9, label=f"F = {level} N")
ax.axhline(0, color="0.6", linewidth=0.8)
ax.set(xlabel="time [s]", ylabel="position from the target [mm]")
ax.legend(frameon=False)
