"""At which pitch line velocity does a pair of gears stop chattering? Friction of two straight lines.

The friction of a spur gear: 0.05 at rest, 0.014 at 2 m/s, then rising at 0.0012 s/m. The tooth force is 2 kN; the
torsional mode weighs 0.8 kg at 320 Hz with 0.6 % of damping.
"""

import numpy as np
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
m, f, zeta, N, v_p = sp.symbols("m f zeta N v_p", positive=True)
omega = 2 * sp.pi * f
law = sf.laws.piecewise_linear(0.05, [0.0, 2.0], [0.05, 0.014], last_slope=0.0012)
gear = sf.Scene(
    system=sf.System(q=[x], u=[u], mass=[[m]], force=[-m * omega**2 * x - 2 * zeta * m * omega * u]),
    contacts=[sf.Contact("tooth", slip=u - v_p, normal=N, law=law)],
    values={m: 0.8, f: 320.0, zeta: 0.006, N: 2000.0, v_p: 1.0},
    initial={x: 0.0, u: 0.0},
    horizon=1.0,
    outputs={"largest": sf.Max(x), "smallest": sf.Min(x)},
)
for speed in (0.5, 1.5, 2.5):
    found = sf.stability(gear.where({v_p: speed}))
    print(f"{speed:.1f} m/s: {'smooth' if found.stable else 'chatters'}, growth rate {-found.margin:+.2f} 1/s")

needed = 0.018 * 2000.0 / (2 * 0.8 * 2 * np.pi * 320.0)  # damping that outweighs the falling line: slope N/(2 m omega)
print(f"damping ratio {needed:.4f} would keep it smooth at every speed")
print("stable there:", sf.stability(gear.where({zeta: 1.01 * needed})).stable)
