"""With which normal load does a friction damper under the platform of a blade keep its vibration smallest?

The blade is a beam of 12 elements in dimensionless units, excited at its tip; the damper rubs at a quarter of its
length. Too little load dissipates nothing, too much only holds the platform.
"""

import sympy as sp

import symfric as sf

W, N = sp.symbols("W N", positive=True)
blade = sf.structures.beam(12, damping=2e-3)
damper = sf.structures.RowContact("platform", {"w3": 1.0}, N, sf.laws.coulomb(0.4))
small = blade.reduced([damper, "w12"], modes=1)
forced = small.scene(
    [damper], force={"w12": 0.02 * sp.cos(W * sf.TIME)}, values={W: 3.6, N: 0.1}, initial={"w12": 0.1}, horizon=40.0
)
best = None
for load in (0.1, 0.3, 0.45, 0.6, 1.5):
    peak = sf.frequency_response(forced.where({N: load}), W, (3.2, 6.5), "w12", tolerance=1e-10).peak
    print(f"N = {load:4.2f}: the tip moves by +-{peak.half_range:.4f} at omega = {peak.value:.4f}")
    best = min(best or (peak.half_range, load), (peak.half_range, load))
print(f"Of these, N = {best[1]:.2f} is best.")
