"""Does a brake pad that vibrates lift off the disc, and how much larger is the vibration for it?

The support is inclined: the drag of the disc takes load off the pad. Dimensionless: mass, stiffness along the disc and
the pressing force are one.
No published value was found to compare with.
"""

import symfric as sf

for k_t in (-2.0, -3.0, -3.4, -3.8):
    pad = sf.scenes.brake_pad(v_b=0.2, k_t=k_t)
    x, y = pad.system.q
    outputs = {**pad.outputs, "x": sf.HalfRange(x), "gap": sf.Max(y)}
    run = sf.simulate(pad.wanting(outputs)).checked()
    words = (
        f"lifts off by {run['gap']:.4f}" if run["gap"] > 1e-9 else f"stays on, with {run['least_force']:.3f} at least"
    )
    print(f"coupling {k_t:.1f}: half range {run['x']:.4f} along the disc, {words}")
