"""Which brings a pendulum to rest: its bearing, the oil or the air? Dry, viscous and quadratic damping from one decay.

The record is made here: a swing of 0.2 rad, two minutes long, read by an encoder of 4096 steps a turn.
No published value was found to compare with: the values are those that the record was made with.
"""

import numpy as np
import sympy as sp

import symfric as sf

q, u = sp.symbols("q u", real=True)
omega, delta, zeta, kappa = 3.13, 4e-4, 1.5e-3, 0.012
force = -(omega**2) * q - 2 * zeta * omega * u - kappa * u * sp.Abs(u)
bearing = sf.Contact("bearing", slip=u, normal=omega**2, law=sf.laws.coulomb(delta))
pendulum = sf.Scene(sf.System([q], [u], [[1]], [force]), [bearing], {}, {q: 0.2, u: 0.0}, 120.0)
t = np.linspace(0, 120, 6001)
step = 2 * np.pi / 4096
angle = step * np.round(sf.simulate(pendulum)(t)[0] / step)

fit = sf.fit_decay(t, angle, sigma=step / np.sqrt(12))
print(fit)
for name, true in (("delta", delta), ("zeta", zeta), ("kappa", kappa)):
    off = abs(fit.values[name] - true) / fit.standard_errors[name]
    print(f"{name}: {fit.values[name]:.3g}, true {true:.3g}, {off:.1f} standard errors off")
size = fit.values["x0"]
share = {
    "bearing": 2 * fit.values["delta"] * omega / np.pi,
    "oil": fit.values["zeta"] * omega * size,
    "air": 4 * fit.values["kappa"] * omega * size**2 / (3 * np.pi),
}
most = max(share, key=share.get)
print(f"At the start the {most} takes most, {100 * share[most] / sum(share.values()):.0f} % of the loss.")
