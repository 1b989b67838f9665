"""Does a wiper blade judder on a drying windscreen? A law of one's own, from three measured points.

The lip of the blade weighs 12 g and bends at 45 Hz; it is pressed on by 4 N.
Friction feeds small vibration by no more than the damping takes above the speed b ln(0.55 N/(2 zeta m omega b)).
"""

from math import log, pi

import numpy as np
import sympy as sp

import symfric as sf

speed, mu = np.array([0.02, 0.2, 1.0]), np.array([1.10, 0.72, 0.60])  # m/s, measured
v = sf.SPEED
b = sp.Symbol("b", positive=True)
law = sf.laws.custom(kinetic=0.60 + 0.55 * sp.exp(-v / b), mu_s=1.2)
misfit = [float(np.max(np.abs(law.where({b: s})(speed) - mu))) for s in np.linspace(0.05, 0.4, 71)]
best = float(np.linspace(0.05, 0.4, 71)[np.argmin(misfit)])
print(f"mu = 0.60 + 0.55 exp(-v/{best:.3f}) misses the points by {min(misfit):.3f} at most")

x, u = sp.symbols("x u", real=True)
m, f, zeta, N, v_w = sp.symbols("m f zeta N v_w", positive=True)
omega = 2 * sp.pi * f
blade = sf.Scene(
    system=sf.System(q=[x], u=[u], mass=[[m]], force=[-m * omega**2 * x - 2 * zeta * m * omega * u]),
    contacts=[sf.Contact("screen", slip=u - v_w, normal=N, law=law)],
    values={m: 0.012, f: 45.0, zeta: 0.1, N: 4.0, v_w: 0.5, b: best},
    initial={x: 0.0, u: 0.0},
    horizon=1.0,
)
for wiping in (0.3, 0.6, 1.2):
    found = sf.stability(blade.where({v_w: wiping}))
    print(f"{wiping:.1f} m/s: {'quiet' if found.stable else 'judders'}, growth rate {-found.margin:+.1f} 1/s")
onset = sf.hopf(blade, "v_w", bracket=(0.2, 2.0)).value
told = best * log(0.55 * 4.0 / (2 * 0.1 * 0.012 * 2 * pi * 45.0 * best))
print(f"It is quiet above {onset:.6f} m/s, closed form {told:.6f} m/s.")
