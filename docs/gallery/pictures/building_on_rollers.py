"""Displacement of the building on its rollers during the last of the motions, on floors of both kinds."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
for profile, words in ((0.005, "even floor"), ((0.005, 0.05), "friction rises with distance")):
    building = sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=motions[-1], profile=profile)
    run = sf.simulate(building.wanting({"path": sf.Trajectory()}))
    ax.plot(run.t, run.x[0], linewidth=0.9, label=words)
ax.set(xlabel="time [s]", ylabel="displacement from the ground [m]")
ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
