"""Displacement of the pad and the load that the controller sets, over time."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
ax.plot(times[::5], places[::5], linewidth=0.5)
ax.set(xlabel="time [ms]", ylabel="displacement of the pad [um]")
right = ax.twinx()
right.plot(times, loads, color="tab:red")
right.set(ylabel="load [N]", ylim=(0, 320))
right.yaxis.label.set_color("tab:red")
