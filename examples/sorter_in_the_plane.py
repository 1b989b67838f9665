"""Where does a parcel leave a sorting belt onto which it is pushed sideways?

A parcel slides at 1.2 m/s onto a belt that runs at 1.5 m/s across its way. Friction opposes the velocity relative to
the belt, whose direction does not change, so that this velocity falls by mu g and its path on the belt is straight. In
the hall the path is a parabola until the parcel rests on the belt. Computed as two directions, each with the whole
friction force, it would be carried too far along the belt and not far enough across it.
"""

from math import hypot

import sympy as sp

import symfric as sf

x, y, u, w = sp.symbols("x y u w", real=True)
mu, g, belt, pushed = 0.3, 9.81, 1.5, 1.2  # -, m/s^2, m/s, m/s


def carried(slips):
    """Return the motion on the belt, which runs along x."""
    contacts = [sf.Contact(f"belt {k}", slip, normal=g, law=sf.laws.coulomb(mu)) for k, slip in enumerate(slips)]
    system = sf.System([x, y], [u, w], sp.eye(2), [0, 0])
    return sf.simulate(sf.Scene(system, contacts, {}, {x: 0, y: 0, u: 0, w: pushed}, horizon=1.0)).checked()


runs = {"in the plane": carried([(u - belt, w)]), "both directions alone": carried([u - belt, w])}
for name, run in runs.items():
    print(f"{name}: rests after {run.events[-1].t:.6f} s, {run.final[1]:.6f} m across the belt")
slip = hypot(belt, pushed)
print(f"closed form: {slip / (mu * g):.6f} s, {pushed * slip / (2 * mu * g):.6f} m")
