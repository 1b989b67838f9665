"""How fast does a part creep down the side of a vibrating feeder whose tray is not level?

The tray shakes along its length with a velocity of 0.126 m/s, at 50 Hz with 0.4 mm, and is tilted sideways. With a
coefficient of friction of 0.35 a part would not slide down a tray at rest before 19 degrees. The vibration turns the
friction to and fro along the tray and leaves across, with its intensity q, the part (2/pi) (v/A) K(q^2/A^2) with
A^2 = v^2 + q^2: a damper, which lets the part creep at the speed v at which it balances the weight. The closed form is
that of an infinite frequency, at which the part stays at rest along the tray.
"""

from math import pi, radians, tan

import sympy as sp
from scipy.optimize import brentq

import symfric as sf

x, y, u, w = sp.symbols("x y u w", real=True)
tilt, rate = sp.symbols("tilt Omega", positive=True)
mu, g, q = 0.35, 9.81, 0.4e-3 * 2 * pi * 50.0  # -, m/s^2, m/s

part = sf.System([x, y], [u, w], sp.eye(2), [0, g * sp.sin(tilt)])
shaken = (u - q * sp.cos(rate * sf.TIME), w)
tray = sf.Contact("tray", slip=shaken, normal=g * sp.cos(tilt), law=sf.laws.coulomb(mu))
scene = sf.Scene(
    part,
    [tray],
    {tilt: radians(2.0), rate: 2 * pi * 50.0},
    dict.fromkeys((x, y, u, w), 0),
    horizon=1.0,
    outputs={"creep": sf.Mean(w, after=0.6)},
)
program = sf.prepare(scene, tolerance=1e-8)


def closed_form(angle):
    """Return the speed at which the mean friction across balances the weight, m/s."""
    return brentq(lambda v: mu * sf.theory.plane.lateral_vibration_drag(v, q) - tan(angle), 1e-9, 10.0)


angles = (1.0, 2.0, 5.0, 10.0)  # degrees
creep = {f: [program.run({tilt: radians(a), rate: 2 * pi * f}).checked()["creep"] for a in angles] for f in (50, 100)}
told = [closed_form(radians(a)) for a in angles]
for a, slow, fast, limit in zip(angles, creep[50], creep[100], told, strict=True):
    print(f"tilt {a:g} deg: {1e3 * slow:.3f} mm/s at 50 Hz, {1e3 * fast:.3f} at 100 Hz, closed form {1e3 * limit:.3f}")
