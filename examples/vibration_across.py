"""How much does vibration across the sliding direction take from the friction?

A block on a spring and a moving belt, which shakes sideways: the slip swings to the sides with r times the belt
speed, and friction opposes the whole vector. Its mean along the belt is, for Coulomb friction, the part 2/(pi sqrt(1
+ r^2)) K(r^2/(1 + r^2)) of mu N, with the elliptic integral K.
"""

from math import pi, sqrt

import sympy as sp
from scipy.special import ellipk

import symfric as sf

x, y, u, w = sp.symbols("x y u w", real=True)
V, r, Omega, c = sp.symbols("V r Omega c", positive=True)
block = sf.System(q=[x, y], u=[u, w], mass=sp.diag(1, 1e9), force=[-x - c * u, 0])  # a guide holds it sideways
belt = sf.Contact("belt", slip=(u - V, w - r * V * sp.cos(Omega * sf.TIME)), normal=1, law=sf.laws.coulomb(0.3))
values = {V: 0.5, r: 1.0, Omega: 200.0, c: 2.0}
outputs = {"mean": sf.Mean(x, after=25.0)}
end = 25.0 + 40 * 2 * pi / 200
program = sf.prepare(sf.Scene(block, [belt], values, {x: 0.3, y: 0, u: 0, w: 0}, end, outputs=outputs), tolerance=1e-8)

ratios = (0.5, 1.0, 2.0, 5.0)
parts = [program.run({r: ratio}).checked()["mean"] / 0.3 for ratio in ratios]
told = [2 / pi / sqrt(1 + ratio**2) * ellipk(ratio**2 / (1 + ratio**2)) for ratio in ratios]
for ratio, part, closed in zip(ratios, parts, told, strict=True):
    print(f"r = {ratio:g}: {part:.5f} of the friction is left, closed form {closed:.5f}")
