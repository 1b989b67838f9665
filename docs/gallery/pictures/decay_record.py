"""Decay of the swing as the encoder reads it, and the part that each loss takes at the start."""

import matplotlib.pyplot as plt

left, right = plt.figure().subplots(1, 2, width_ratios=(2, 1))
left.plot(t, angle, linewidth=0.5)
left.set(xlabel="time [s]", ylabel="angle [rad]")
total = sum(share.values())
right.bar(list(share), [100 * part / total for part in share.values()])
right.set_ylabel("share of the loss at the start [%]")
