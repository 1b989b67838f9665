"""Error of position against the time over which the drive stops; the best time is marked."""

import matplotlib.pyplot as plt
import numpy as np

ax = plt.figure().add_subplot()
lam = sf.theory.drive.excess(mu, mu, feeds[1])
stop = sf.scenes.drive_stop(mu1=mu, mu2=mu, lam=lam, epsilon=jump / force, speed=feeds[1], ramp=1.0)
times = np.linspace(0.05, 1.8, 36) * best.values["ramp"]
program = sf.prepare(stop)
errors = [program.run({"ramp": time})["error"] * length for time in times]
ax.plot(1e3 * times / omega, 1e6 * np.array(errors))
ax.axvline(1e3 * best.values["ramp"] / omega, color="0.6", linestyle="--")
ax.axhline(0, color="0.6", linewidth=0.8)
ax.set(xlabel="time of the stop [ms]", ylabel="error of position at 8 mm/s [um]")
