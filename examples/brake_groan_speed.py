"""Below which disc speed does a brake pad groan, and how far does the pad then move?

A pad of 0.6 kg on a support of 159 Hz; the coefficient of friction falls from 0.50 to 0.38 within 0.12 m/s.
Friction feeds small vibration by N |mu'(v)|, as Thomsen has it, and the support takes c: they are equal at the speed
v_s ln(0.12 N/(v_s c)).
"""

from math import log

import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
m, k, c, N, v_b = sp.symbols("m k c N v_b", positive=True)
pad = sf.Scene(
    system=sf.System(q=[x], u=[u], mass=[[m]], force=[-k * x - c * u]),
    contacts=[sf.Contact("disc", slip=u - v_b, normal=N, law=sf.laws.stribeck(0.50, 0.38, 0.12))],
    values={m: 0.6, k: 6.0e5, c: 60.0, N: 300.0, v_b: 0.05},  # kg, N/m, N s/m, N, m/s
    initial={x: 0.0, u: 0.0},
    horizon=0.5,
    outputs={"largest": sf.Max(x), "smallest": sf.Min(x)},
)

onset = sf.hopf(pad, "v_b", bracket=(0.01, 0.5))
told = 0.12 * log(0.12 * 300.0 / (0.12 * 60.0))
print(f"The pad groans below {1000 * onset.value:.4f} mm/s, closed form {1000 * told:.4f} mm/s,", end=" ")
print(f"at {onset.omega / 6.283185:.0f} Hz ({onset.kind}).")

run = sf.simulate(pad).checked()
print(f"At 50 mm/s it moves over {1e3 * (run['largest'] - run['smallest']):.3f} mm, from rest on.")
