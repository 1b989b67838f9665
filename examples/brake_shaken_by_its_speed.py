"""How can a brake stop squealing without losing its friction? Shake it with the measured sliding speed.

A pad of 2 kg on a mount of 2 N/um, pressed with 3 kN. Friction falls from 0.45 to 0.32 at 0.6 m/s. An exciter of 4 kHz
works at sliding speeds from 0.1 to 0.5 m/s.
No published value was found to compare with. The intensities come from averaging; the last two lines are the motion
in full.
"""

import numpy as np
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
m, k, c, N, v_b, a, Omega = sp.symbols("m stiffness c N v_b a Omega", positive=True)
law = sf.laws.cubic(0.45, 0.32, 0.6)
pad = sf.Scene(
    system=sf.System(q=[x], u=[u], mass=[[m]], force=[-k * x - c * u + m * a * Omega**2 * sp.sin(Omega * sf.TIME)]),
    contacts=[sf.Contact("disc", slip=u - v_b, normal=N, law=law)],
    values={m: 2.0, k: 2e6, c: 40.0, N: 3000.0, v_b: 0.3, a: 0.0, Omega: 8000 * sp.pi.evalf()},
    initial={x: 0.0, u: 0.0},
    horizon=0.5,
)
drive = {"speeds": (0.1, 0.5), "Omega": (8000 * np.pi, 8000 * np.pi), "a": (0.0, 1e-4)}
fixed = sf.design.quench(pad, **drive)
following = sf.design.quench(pad, **drive, follow=True, k=(1.05, 1.5))  # 5 % above the measured speed


def left(intensity, v):
    """Share of the friction that is left."""
    return law.averaged(intensity)(v) / law(v)


always = fixed.values["a"] * fixed.values["Omega"]
print(f"fixed: a*Omega = {always:.3f} m/s; following: {following.values['k']:.2f} times the speed ({following.status})")
for v in (0.1, 0.2, 0.35, 0.5):
    shares = left(always, v), left(following.values["k"] * v, v)
    print(f"at {v:.2f} m/s the brake keeps {100 * shares[0]:.0f} %, or {100 * shares[1]:.0f} % of its friction")

for name, scene in (("not shaken", pad), ("shaken", following.scene.where(following.values))):
    run = sf.simulate(scene)
    slow = run(np.arange(1600, 2000) * 2 * np.pi / drive["Omega"][0])[0]  # once in a period of the exciter
    print(f"{name}, at 0.3 m/s: slow vibration of {1e6 * np.ptp(slow) / 2:.2f} um")
