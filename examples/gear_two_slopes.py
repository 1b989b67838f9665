"""At which pitch line velocity does a pair of gears stop chattering? Friction of two straight lines.

The friction of a spur gear, measured at 12 pitch line velocities to 0.0005: it falls, and rises from a corner on. The
tooth force is 2 kN; the torsional mode weighs 0.8 kg at 320 Hz with 0.6 % of damping.
"""

import numpy as np
import sympy as sp

import symfric as sf

velocity = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.5, 3.0, 4.0, 6.0, 8.0, 10.0]  # m/s
measured = [0.0455, 0.041, 0.0365, 0.032, 0.0275, 0.023, 0.0145, 0.015, 0.0165, 0.019, 0.021, 0.0235]
fit = sf.theory.two_lines(velocity, measured)
print(f"slopes {fit.slope_below:.4f} and {fit.slope_above:.5f} s/m, corner at {fit.corner:.2f} m/s", end=" ")
print(f"+- {fit.standard_errors['corner']:.2f}")

x, u = sp.symbols("x u", real=True)
m, f, zeta, N, v_p = sp.symbols("m f zeta N v_p", positive=True)
omega = 2 * sp.pi * f
gear = sf.Scene(
    system=sf.System(q=[x], u=[u], mass=[[m]], force=[-m * omega**2 * x - 2 * zeta * m * omega * u]),
    contacts=[sf.Contact("tooth", slip=u - v_p, normal=N, law=fit.law)],
    values={m: 0.8, f: 320.0, zeta: 0.006, N: 2000.0, v_p: 1.0},
    initial={x: 0.0, u: 0.0},
    horizon=1.0,
    outputs={"largest": sf.Max(x), "smallest": sf.Min(x)},
)
for speed in (0.5, 1.5, 2.5):
    found = sf.stability(gear.where({v_p: speed}))
    slope = fit.slope_below if speed < fit.corner else fit.slope_above
    told = -slope * 2000.0 / (2 * 0.8) - 0.006 * 2 * np.pi * 320.0
    words = "smooth" if found.stable else "chatters"
    print(f"{speed:.1f} m/s: {words}, growth rate {-found.margin:+.4f} 1/s, closed form {told:+.4f} 1/s")

needed = (
    -fit.slope_below * 2000.0 / (2 * 0.8 * 2 * np.pi * 320.0)
)  # damping that outweighs the falling line: slope N/(2 m omega)
print(f"damping ratio {needed:.4f} would keep it smooth at every speed")
print("stable there:", sf.stability(gear.where({zeta: 1.01 * needed})).stable)
