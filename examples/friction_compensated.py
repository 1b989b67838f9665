"""How much of the friction of a stage may its controller compensate before it shakes?

A force F in the direction of the measured speed shall cancel the friction F_c. Too little leaves the stage at rest
beside its target, too much makes it shake (Putra, Nijmeijer and van de Wouw, Automatica 43, 2007, 1387). Beyond F_c by
D, half a cycle is that of a damped spring under a constant force, so that the amplitude is (D/k_p) coth(a), with
a = pi zeta/(2 sqrt(1 - zeta^2)). It turns round where the spring overcomes F and F_c: from D = 2 F_c/(coth(a) - 1) on.
"""

from math import pi, sqrt, tanh

import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
m, k_p, k_d, F_c, F = sp.symbols("m k_p k_d F_c F", positive=True)
force = sf.Held("force", update=F * sp.sign(u), when=u)  # turns with the speed
stage = sf.Scene(
    system=sf.System(q=[x], u=[u], mass=[[m]], force=[-k_p * x - k_d * u + force.symbol]),
    contacts=[sf.Contact("guide", slip=u, normal=1, law=sf.laws.coulomb(F_c))],
    values={m: 1.0, k_p: 400.0, k_d: 2.0, F_c: 1.0, F: 1.3},  # kg, N/m, N s/m, N, N
    initial={x: 0.02, u: -1e-3},  # 20 mm off, on its way back
    horizon=30.0,
    outputs={"x": sf.At(x), "shakes": sf.HalfRange(x, after=20.0)},
    held=[force],
)
zeta = 2.0 / (2 * sqrt(1.0 * 400.0))
coth = 1 / tanh(pi * zeta / (2 * sqrt(1 - zeta**2)))
for beyond in (-0.5, 0.0, 0.16, 0.18, 0.3):
    late = sf.simulate(stage.where({F: 1.0 + beyond}).starting({force.symbol: -1.0 - beyond})).checked()
    print(f"F = {1 + beyond:.2f} N:", end=" ")
    if late["shakes"]:
        print(f"shakes by +-{1e3 * late['shakes']:.4f} mm, closed form {1e3 * beyond / 400.0 * coth:.4f} mm")
    else:
        print(f"rests {1e3 * abs(late['x']):.2f} mm off, within {1e3 * (2 + beyond) / 400:.2f} mm")
print(f"it may compensate {1 + 2 / (coth - 1):.4f} N without shaking for ever")
