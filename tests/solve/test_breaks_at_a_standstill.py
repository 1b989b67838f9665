"""A contact that sticks holds the speed of another one exactly at a break of its law, and is released there."""

import numpy as np
import sympy as sp

import symfric as sf

x, y, u, w, V = sp.symbols("x y u w V", real=True)
F, W, c, k, m, kc, mu, mu0, mu1, mu2, b = sp.symbols("F W c k m kc mu mu0 mu1 mu2 b", positive=True)
RANGES = {
    F: (0.6, 1.5),
    W: (0.5, 2),
    c: (0, 0.2),
    k: (0.5, 2),
    m: (0.5, 2),
    kc: (0.2, 1.5),
    mu: (0.2, 0.5),
    b: (0.1, 0.5),
}
RANGES |= {mu0: (0.1, 0.4), mu1: (0.1, 0.5), mu2: (0.1, 0.5)}


def drawn(seed):
    """Return values and start of a pair of masses; the first rests on the floor, at speed b on the belt."""
    r = np.random.default_rng(seed)
    values = {s.name: float(r.uniform(*ends)) for s, ends in RANGES.items()}
    values["V"] = values["b"] * float(r.choice([-1, 1]))
    return values, {s.name: float(r.uniform(-1, 1)) for s in (x, y, w)}


def test_a_release_at_a_break_is_the_limit_of_releases_beside_it():
    """The floor's law has no jump and no slope, so that the speed leaves the break with no acceleration, but a jerk."""
    law = sf.laws.piecewise_linear(mu0, [0, b, 2 * b, 3 * b], [mu0, mu1, mu2, mu2])
    values, initial = drawn(0)
    scene = sf.Scene(
        system=sf.System(
            q=[x, y],
            u=[u, w],
            mass=[[m, 0.1], [0.1, 1]],
            force=[-k * x - kc * (x - y) - c * u, kc * (x - y) - k * y - c * w + F * sp.sin(W * sf.TIME)],
        ),
        contacts=[
            sf.Contact("floor", slip=u, normal=1, law=sf.laws.coulomb(mu)),
            sf.Contact("belt", slip=u - V, normal=1, law=law),
        ],
        values=values,
        initial=initial | {"u": 0.0},
        horizon=10.0,
        outputs={"path": sf.Trajectory(), "events": sf.Events()},
    )
    program, released = sf.prepare(scene, tolerance=1e-11, route="taylor"), 0
    for seed in range(150):
        values, initial = drawn(seed)
        run = program.run(values, initial).checked()
        beside = [program.run(values | {"b": values["b"] * (1 + part)}, initial).final for part in (-1e-8, 1e-8)]
        size = np.max(np.abs(run.x), axis=1)
        assert np.max(np.abs(run.final - np.mean(beside, axis=0)) / size) < 1e-8, seed
        released += any(e.contact == "floor" and e.before == 0 for e in run.events)
    assert released > 50
