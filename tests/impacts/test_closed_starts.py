"""Derivatives of runs that start on closed contacts, against differences of runs whose contacts bounce a little first."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer

x, y, z, u, v, w = sp.symbols("x y z u v w", real=True)
a, mu, e = sp.symbols("a mu e", nonnegative=True)
STEP = 1e-6
CLOSE = 1e-4  # error of the differences, which a bounce as small as the step makes of the first order


def blocks(seed):
    """Return a scene of one sliding body that rests with two points on a floor and a wall, coupled by its mass."""
    rng = np.random.default_rng(seed)
    part = rng.uniform(-0.3, 0.3, (3, 3))
    mass = sp.Matrix(np.diag(rng.uniform(1, 2, 3)) + part @ part.T)
    presses, slides = [-float(f) for f in rng.uniform(8, 12, 2)], rng.random() < 0.5
    floor = sf.Unilateral(y - a * sf.TIME, restitution=e)
    wall = sf.Unilateral(z, restitution=float(rng.choice([0.0, 0.4])))
    speed = float(rng.choice([-2.0, 2.0])) if slides else 0.0
    on_floor = sf.Contact("floor", slip=u, normal=floor, law=sf.laws.coulomb(mu))
    if slides:
        slip = u - sp.Float(rng.choice([0.0, 0.7]))
        other = [sf.Contact("wall", slip=slip, normal=wall, law=sf.laws.coulomb(0.2))]
    else:
        clamp = sf.Contact("clamp", slip=u, normal=sp.Float(1.5), law=sf.laws.coulomb(0.3))
        other = [clamp, sf.Contact("wall", slip=None, normal=wall)]
    return sf.Scene(
        system=sf.System([x, y, z], [u, v, w], mass, [1.0 if slides else 0.5, *presses]),
        contacts=[on_floor, *other],
        values={a: float(rng.choice([0.0, 0.1])), mu: 0.3, e: float(rng.choice([0.0, 0.5]))},
        initial={x: 0.0, y: 0.0, z: 0.0, u: speed, v: a, w: 0.0},
        horizon=0.4,
    )


@pytest.mark.one_in(4)
@pytest.mark.parametrize("seed", longer(range(16), range(4, 16)))
def test_bounces_from_closed_contacts_add_up(seed):
    scene = blocks(seed)
    keys = [v, w, a, u] if scene.initial[u] else [v, w, a]
    run = sf.simulate(scene, tolerance=1e-11, sensitivities=keys).checked()
    plain = sf.prepare(scene, tolerance=1e-12)
    start = scene.values[a]
    for key in keys:
        sides = []
        for way in (STEP, -STEP):
            moved = {v: start, w: 0.0, u: scene.initial[u]}
            if key is a:
                sides.append(plain.run(values={a: start + way}).checked().final)
            elif key is not u and way < 0:
                continue  # a start into the floor
            else:
                sides.append(plain.run(initial=moved | {key: moved[key] + way}).checked().final)
        other = sides[1] if len(sides) > 1 else plain.run().final
        found = (sides[0] - other) / (STEP * len(sides))
        assert run.sensitivities[key.name] == pytest.approx(found, abs=CLOSE), key


def test_no_derivative_by_what_opens_a_contact():
    run = sf.simulate(blocks(0), sensitivities=[y])
    assert run.status == sf.Status.NO_DERIVATIVE
    assert np.all(np.isnan(run.sensitivities["y"]))
