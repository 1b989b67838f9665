"""How fast may a bow move before the string stops sticking to it? One mode of an open A string, 440 Hz.

The mode weighs 0.3 g; rosin: 0.8 at rest, 0.25 at speed; the bow is pressed on by 0.9 N. The coefficient falls as
0.55 exp(-v/v_s), so that friction feeds small vibration by 0.55 N exp(-v/v_s)/v_s, and the string takes
c = 2 zeta m omega: steady sliding is unstable below v_s ln(0.55 N/(v_s c)).
"""

from math import log, pi

import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
m, f, zeta, N, v_b = sp.symbols("m f zeta N v_b", positive=True)
omega = 2 * sp.pi * f
string = sf.Scene(
    system=sf.System(q=[x], u=[u], mass=[[m]], force=[-m * omega**2 * x - 2 * zeta * m * omega * u]),
    contacts=[sf.Contact("bow", slip=u - v_b, normal=N, law=sf.laws.stribeck(0.8, 0.25, 0.1))],
    values={m: 3e-4, f: 440.0, zeta: 0.002, N: 0.9, v_b: 0.2},  # kg, Hz, -, N, m/s
    initial={x: 0.0, u: 0.0},
    horizon=0.5,
)
for speed in (0.1, 0.2, 0.4, 0.8):
    run = sf.simulate(string.where({v_b: speed})).checked()
    late = [e.t for e in run.events if e.t > 0.45 and e.kind == "stick"]
    if len(late) > 1:
        print(f"{speed:.1f} m/s: sticks and slips {(len(late) - 1) / (late[-1] - late[0]):.1f} times a second")
    else:
        print(f"{speed:.1f} m/s: slips all the time")
onset = sf.hopf(string, "v_b", bracket=(0.05, 1.5))
told = 0.1 * log(0.55 * 0.9 / (0.1 * 2 * 0.002 * 3e-4 * 2 * pi * 440))
print(f"Steady sliding is unstable below {onset.value:.6f} m/s, closed form {told:.6f} m/s;")
print(f"{onset.kind}: above, a string at rest may still start.")
