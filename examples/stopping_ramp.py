"""Over which time should a drive stop, so that the table on it stops where it shall?

A table of 50 kg on a drive of 5 N/um, fed at 4 to 8 mm/s. Friction rises at 3000 N s/m; its static value is 2 N above
the kinetic one.
No published value was found to compare with; the ramps around the best one are run with all events.
"""

from math import sqrt

import symfric as sf

m, k, v_star = 50.0, 5e6, 0.010  # kg, N/m, m/s
rise, jump = 3000.0, 2.0  # N s/m, N
omega = sqrt(k / m)
length, force = v_star / omega, m * omega * v_star  # the units of the closed forms
mu = rise / (2 * m * omega)
feeds = (0.4, 0.8)  # over v*

table = sf.scenes.drive_slide(mu1=mu, mu2=mu, p_star=1.0, epsilon=jump / force)
best = sf.design.positioning(table, "ramp", bounds=(0.0, 10.0), speeds=feeds)
abrupt = sf.design.positioning(table, "ramp", bounds=(0.0, 0.0), speeds=feeds)
print(f"stopped at once: up to {1e6 * abrupt.objective * length:.1f} um too far")
print(
    f"stopped over {1e3 * best.values['ramp'] / omega:.1f} ms: {1e6 * best.objective * length:.1f} um ({best.status})"
)

for ramp in (0.5, 0.9, 1.1, 1.5):  # how exactly must the ramp be kept?
    time = ramp * best.values["ramp"]
    feed = feeds[1]
    lam = sf.theory.drive.excess(mu, mu, feed)
    stop = sf.scenes.drive_stop(mu1=mu, mu2=mu, lam=lam, epsilon=jump / force, speed=feed, ramp=time)
    error = sf.simulate(stop)["error"] * length
    print(f"  over {1e3 * time / omega:.1f} ms: {1e6 * error:.1f} um at {1e3 * feed * v_star:.0f} mm/s")
