"""With which normal load does a friction damper under the platform of a blade keep its vibration smallest?

The blade is a beam of 12 elements in dimensionless units, excited at its tip; the damper sits at a quarter of its
length and gives before it slips: a slider behind a spring. Too little load dissipates nothing, too much leaves a spring
between the platforms.
No published value was found for this blade; the design compares its peak with the motion that settles.
"""

import sympy as sp

import symfric as sf

W, N = sp.symbols("W N", positive=True)
blade = sf.structures.beam(12, damping=2e-3)
damper = sf.structures.RowContact("platform", {"w3": 1.0}, N, sf.laws.coulomb(0.4), stiffness=60.0)
small = blade.reduced([damper, "w12"], modes=1)
forced = small.scene(
    [damper], force={"w12": 0.02 * sp.cos(W * sf.TIME)}, values={W: 3.6, N: 0.6}, initial={"w12": 0.1}, horizon=40.0
)
best = sf.design.damper(forced, "N", bounds=(0.3, 1.5), speeds=(3.5, 3.8), speed="W", coordinate="w12")
for load, size in list(zip(best.curve.x, best.curve.y, strict=True))[::4]:
    print(f"N = {load:5.3f}: the tip moves by +-{size:.4f} at the peak")
print(f"N = {best.values['N']:.3f} is best ({best.status}): +-{best.objective:.4f}.")
