"""Motion of the hinge against time: it creaks without shaking, and comes to rest with it."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
for words, scene in (("without shaking", door), ("with shaking", door.where(found.values))):
    run = sf.simulate(scene.wanting({"path": sf.Trajectory()}))
    ax.plot(run.t, run.x[0], linewidth=0.9, label=words)
ax.set(xlabel="time", ylabel="displacement", xlim=(0, 60))
ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
