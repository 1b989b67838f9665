"""A contact reverses, and its friction by that much more than another one that sticks can hold."""

import numpy as np
import sympy as sp

import symfric as sf

x, y, u, w = sp.symbols("x y u w", real=True)
F, W, k, m, mu, b, hold, weak = NAMES = sp.symbols("F W k m mu b hold weak", positive=True)
RANGES = (1, 3), (0.5, 2), (0.3, 2), (0.5, 2), (0.3, 0.6), (0.05, 0.3), (0.6, 1.2), (0.05, 0.2)


def drawn(seed):
    r = np.random.default_rng(seed)
    values = {s.name: float(r.uniform(*ends)) for s, ends in zip(NAMES, RANGES, strict=True)}
    return values, {s.name: float(r.uniform(-1, 1)) for s in (x, y)} | {"u": 1.0, "w": 1.0}


def program(offset):
    """Two masses that stick to each other, the first on a floor whose law starts with an infinite slope, or nearly so."""
    floor = sf.laws.custom(mu - b * (sp.sqrt(sf.SPEED + offset**2) - offset), mu)
    values, initial = drawn(0)
    scene = sf.Scene(
        system=sf.System([x, y], [u, w], sp.diag(1, m), [-k * x, F * sp.sin(W * sf.TIME) - k * y]),
        contacts=[sf.Contact("floor", u, 1, floor), sf.Contact("pad", u - w, 1, sf.laws.coulomb(hold, weak))],
        values=values,
        initial=initial,
        horizon=6.0,
        outputs={"path": sf.Trajectory(), "events": sf.Events()},
    )
    return sf.prepare(scene, tolerance=1e-8, route="taylor")


def test_where_one_contact_reverses_the_other_is_judged_although_the_friction_has_an_infinite_slope():
    """The rate of its force says nothing then about what the force does, and the series of a slip that ends overflows."""
    steep, bent = program(0), program(sp.Float(1e-8))
    together = 0
    for seed in range(100):
        runs = [p.run(*drawn(seed)).checked() for p in (steep, bent)]
        assert np.max(np.abs(runs[0].final - runs[1].final)) < 2e-5, seed
        times = {e.t for e in runs[0].events if e.contact == "floor"}
        together += any(e.contact == "pad" and e.t in times for e in runs[0].events)
    assert together > 10
