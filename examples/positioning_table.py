"""How far beyond its target does a positioning table come to rest when the drive stops?

A table of 50 kg on a drive of 5 N/um. Friction falls at 600 N s/m up to 10 mm/s and rises at 900 N s/m beyond; static
friction is 4 N above the kinetic one. A damper to ground of 200 N s/m is in these slopes.
"""

from math import sqrt

import symfric as sf

m, k, v_star = 50.0, 5e6, 0.010  # kg, N/m, m/s
fall, rise, jump = -600.0, 900.0, 4.0  # N s/m, N s/m, N
omega = sqrt(k / m)
length, force = v_star / omega, m * omega * v_star  # the units of the closed forms
mu1, mu2 = fall / (2 * m * omega), rise / (2 * m * omega)

for feed in (0.012, 0.020, 0.040):
    lam = sf.theory.drive.excess(mu1, mu2, feed / v_star)  # spring force beyond the kinetic friction at rest
    error = sf.theory.drive.positioning_error(mu1, mu2, lam, epsilon=jump / force)
    words = f"{1e6 * error.value * length:.2f} um beyond" if error.value > 0 else "where it shall"
    print(f"{1e3 * feed:.0f} mm/s: stops {words} (type {error.type})")

scene = sf.scenes.drive_stop(mu1=mu1, mu2=mu2, lam=lam, epsilon=jump / force)
run = sf.simulate(scene).checked()
print(f"the event-driven motion says {1e6 * run['error'] * length:.2f} um for the last")
