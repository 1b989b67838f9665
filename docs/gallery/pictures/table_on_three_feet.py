"""Path of the centre on the floor and the angle over time: equal feet do not turn, a worn one lets the table turn."""

import matplotlib.pyplot as plt

figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.6), layout="constrained")
for c, run in runs.items():
    t = np.linspace(0, run.t_final, 3000)
    path = run(t)
    left.plot(1e3 * path[0], 1e3 * path[1], linewidth=0.8, label=f"one foot of {c}")
    right.plot(t, np.degrees(path[2]), linewidth=0.8)
left.set(xlabel="along the shaking [mm]", ylabel="down the floor [mm]")
left.invert_yaxis()
right.legend(*left.get_legend_handles_labels(), frameon=False, loc="lower left")
right.set(xlabel="time [s]", ylabel="angle [degrees]")
