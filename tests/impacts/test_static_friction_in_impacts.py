"""Impacts where friction drops from rest to slip: what rests is held up to static friction, what slides only up to kinetic."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.impacts.impact_laws import (
    APART,
    BACKWARD,
    FORWARD,
    STICK,
    NotUnique,
    Touching,
    of_combination,
    several,
)

MASSES = np.array([1.0, 1.0, 0.3])  # of the displacements and of the turn
x, y, turn = sp.symbols("x y turn", real=True)
u, v, w = sp.symbols("u v w", real=True)


MU, STATIC = sp.symbols("mu static", positive=True)


def landing_bar(law):
    """Return a program of an upright bar of unit length that falls without turning on its lower end."""
    slip, gap = u + sp.cos(turn) * w / 2, y - sp.cos(turn) / 2
    system = sf.System([x, y, turn], [u, v, w], sp.diag(1, 1, sp.Rational(1, 12)), [0, -1, 0])
    start = dict.fromkeys((x, turn, u, v, w), 0) | {y: 0.6}
    contact = sf.Contact("tip", slip, sf.Unilateral(gap, 0.5), law)
    values = dict.fromkeys((law.stick.free_symbols | law.kinetic.free_symbols), 1.0)
    return sf.prepare(sf.Scene(system, [contact], values, start, 0.5), tolerance=1e-11)


@pytest.fixture(scope="module")
def landing_bars():
    """Return programs of bars whose friction drops from `static` to `mu` with the slip, and whose friction does not."""
    return landing_bar(sf.laws.coulomb(STATIC, MU)), landing_bar(sf.laws.coulomb(MU))


@pytest.mark.long(beside="test_contacts_that_rest_and_slide_in_one_impact")
@pytest.mark.parametrize("angle", [-0.7, -0.4, 0.3, 0.6])
@pytest.mark.parametrize("static", [0.2, 0.5, 1.2])
def test_a_bar_that_lands_without_slip_is_held_by_static_friction(angle, static, landing_bars):
    """At the lower end ``|W_tn| / W_tt = 3 sin cos / (1 + 3 cos^2)`` is the coefficient that holds it."""
    needed = 3 * abs(np.sin(angle)) * np.cos(angle) / (1 + 3 * np.cos(angle) ** 2)
    start = {"turn": angle, "y": np.cos(angle) / 2 + 0.1}
    drops, keeps = landing_bars
    run = drops.run(values={"static": static, "mu": 0.1}, initial=start).checked()
    alone = keeps.run(values={"mu": static if needed <= static else 0.1}, initial=start).checked()
    assert run.final == pytest.approx(alone.final, abs=1e-12)


@pytest.fixture(scope="module")
def struck_body():
    """Return a program of a body whose two contacts touch at the start, with values for their places and their laws."""
    b, h, e = sp.symbols("b:2", real=True), sp.symbols("h:2", real=True), sp.symbols("e:2", nonnegative=True)
    law = sf.laws.coulomb(STATIC, MU)
    contacts = [sf.Contact(f"c{i}", u + h[i] * w, sf.Unilateral(y + b[i] * turn, e[i]), law) for i in range(2)]
    system = sf.System([x, y, turn], [u, v, w], sp.diag(*MASSES.tolist()), [0, 0, 0])
    values = dict.fromkeys((*b, *h, *e, MU), 0.5) | {STATIC: 1.0}
    start = dict.fromkeys((x, y, turn, u, w), 0.0) | {v: -1.0}
    return sf.prepare(sf.Scene(system, contacts, values, start, 1e-6), tolerance=1e-12)


@pytest.mark.parametrize("resting", [0, 1, 2])
def test_contacts_that_rest_and_slide_in_one_impact(resting, struck_body):
    """Against all combinations of what two contacts do; `resting` of them have no slip."""
    rng, unlike, judged = np.random.default_rng([91, resting]), 0, 0
    for _ in range(25):
        places, heights = rng.uniform(-1, 1, 2), rng.uniform(-1, 1, 2)
        bounces, mu = rng.uniform(0, 0.6, 2), rng.uniform(0.1, 0.5)
        static = mu * rng.uniform(1.3, 3)
        turning = rng.uniform(-1, 1) if resting < 2 else 0.0
        along = -heights[0] * turning if resting else rng.uniform(-1, 1)
        velocities = np.array([along, -rng.uniform(0.3, 1), turning])
        normal = np.array([[0, 1, b] for b in places])
        if np.any(normal @ velocities >= -0.05):
            continue
        rows = np.vstack([[[1, 0, h] for h in heights], normal])
        W, z = rows @ (rows / MASSES).T, rows @ velocities
        z[np.abs(z) < 1e-15] = 0.0
        bounds = np.where(z[:2] == 0, static, mu)
        ends = []
        for bound in (bounds, np.full(2, static), np.full(2, mu)):
            try:
                impulses = several(Touching(W, [0, 1], np.full(2, mu), bound, bounces), z)
            except NotUnique:
                ends.append(None)
                continue
            ends.append(velocities + rows.T @ impulses / MASSES)
        if ends[0] is None:
            continue
        values = {
            f"{name}{i}": each[i] for name, each in zip("bhe", (places, heights, bounces), strict=True) for i in (0, 1)
        }
        start = dict(zip("uvw", velocities, strict=True))
        run = struck_body.run(values=values | {"static": static, "mu": mu}, initial=start)
        assert run.status == sf.Status.OK
        assert run.final[3:] == pytest.approx(ends[0], abs=1e-9)
        judged += 1
        unlike += any(e is None or np.max(np.abs(e - ends[0])) > 1e-6 for e in ends[1:])
    assert judged > 5
    assert unlike or resting == 0


@pytest.mark.long(beside="test_contacts_that_rest_and_slide_in_one_impact")
@pytest.mark.parametrize("seed", [6, 19, *range(6)])
def test_of_many_contacts_those_that_could_stick_do(seed):
    """Eight contacts, too many for all combinations; strong coupling, with which the laws leave several answers."""
    n, rng = 8, np.random.default_rng([seed, 8])
    A = rng.normal(size=(2 * n, 2 * n))
    M = np.eye(2 * n) + 30 * (A @ A.T) / (2 * n)
    z = np.append(rng.uniform(-1, 1, n), rng.uniform(-1, 1, n))
    z[n:] = -rng.uniform(0.1, 1, n)
    rests = rng.random(n) < 0.6
    z[:n][rests] = 0
    mu, bounces = rng.uniform(0.1, 0.5, n), rng.uniform(0, 0.6, n)
    q, p = (sp.symbols(f"{s}:{2 * n}", real=True) for s in "qp")
    contacts = [
        sf.Contact(f"c{i}", p[i], sf.Unilateral(q[n + i], bounces[i]), sf.laws.coulomb(3 * mu[i], mu[i]))
        for i in range(n)
    ]
    start = dict.fromkeys(q, 0.0) | dict(zip(p, z.tolist(), strict=True))
    scene = sf.Scene(sf.System(q, p, sp.Matrix(M.tolist()), [0] * (2 * n)), contacts, {}, start, 1e-6)
    after = sf.simulate(scene, tolerance=1e-12).checked().final[2 * n :]
    touching = Touching(np.linalg.inv(M), list(range(n)), mu, np.where(rests, 3 * mu, mu), bounces)
    target = bounces * -z[n:]
    kinds = [
        APART
        if after[n + k] > target[k] + 1e-9
        else STICK
        if abs(after[k]) < 1e-9
        else FORWARD
        if after[k] > 0
        else BACKWARD
        for k in range(n)
    ]
    margin, _, again = of_combination(touching, z, target, 1.0, kinds)
    assert margin > 0
    assert after == pytest.approx(again, abs=1e-9)
    for k in np.flatnonzero(rests):
        other = of_combination(touching, z, target, 1.0, [*kinds[:k], STICK, *kinds[k + 1 :]])
        assert kinds[k] == STICK or other is None or other[0] < 1e-6
