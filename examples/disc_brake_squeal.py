"""From which coefficient of friction does a disc brake squeal, and how far does the pad then move?

A finite element model of 296 degrees of freedom in dimensionless units; the pad touches the disc at seven pairs of
nodes, each of which sticks, slips and opens by itself.
No published value was found for this model; the reduced model is compared with the whole one.
"""

import sympy as sp

import symfric as sf

brake = sf.structures.disc_and_pad(damping=0.3)
flutter = sf.structures.flutter(brake.structure, mu=(0.0, 0.6), count=4, grid=7)
first = flutter.critical[0]
print(f"Two modes couple: the brake squeals from mu = {first.mu:.4f}, at omega = {first.omega:.4f}.")

mu, speed = sp.symbols("mu v_b", positive=True)
contacts = brake.contacts(preload=0.01, law=sf.laws.coulomb(mu), speed=speed)
small = brake.apart.reduced([*contacts, "p0_3x"], modes=20)
change = small.error.frequency_error[small.error.frequency <= 1.2 * first.omega].max()
print(f"Reduced to {small.n} coordinates: frequencies up to that one change by {change:.0e}.")

back = sp.Symbol("p0_3x", real=True)  # a node of the back of the pad
squeal = small.scene(
    contacts,
    values={mu: 0.5, speed: 0.02},
    initial={"p0_3x": 0.02},
    horizon=1500.0,
    outputs={"movement": sf.HalfRange(back), "end": sf.End()},
)
modes = sf.stability(squeal)
print(f"At mu = 0.5 small vibrations grow by {-100 * modes.margin:.2f} % per unit of time.")
run = sf.simulate(squeal, 1e-7).checked()
late = squeal.starting(dict(zip(run.names, run["end"].tolist(), strict=True)))
settled = sf.simulate(late, 1e-7).checked()
print(
    f"In the end the pad moves by +-{settled['movement']:.2f}; {settled.stats['events']} times a pair sticks or slips."
)
