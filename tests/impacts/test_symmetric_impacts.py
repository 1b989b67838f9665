"""Symmetric scenes: flat landings whose slips hold rounding only, mirror images, many contacts at once."""

import math
from functools import cache

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, Y, TH, U, V, OM = sp.symbols("x y th u v om", real=True)
E, MU = sp.symbols("e mu", nonnegative=True)
G = 9.81
WIDE, HIGH = 0.1, 0.2
LANDINGS = [(h, e, mu) for h in np.linspace(0.05, 0.8, 12) for e in (0.2, 0.4, 0.6, 0.8) for mu in (0.1, 0.5)]


@cache
def block(order=1):
    """Return the program of a block above a floor that it meets with two corners."""
    s, c = sp.sin(TH), sp.cos(TH)
    corners = [("left", -WIDE, -HIGH), ("right", WIDE, -HIGH)][::order]
    contacts = [
        sf.Contact(
            name,
            U - OM * (dx * s + dy * c),
            sf.Unilateral(Y + dx * s + dy * c, restitution=E),
            sf.laws.coulomb(MU),
        )
        for name, dx, dy in corners
    ]
    system = sf.System([X, Y, TH], [U, V, OM], sp.diag(1, 1, sp.Rational(1, 60)), [0, -G, 0])
    start = dict.fromkeys((X, TH, U, V, OM), 0.0) | {Y: 1.0}
    return sf.prepare(sf.Scene(system, contacts, {E: 0.4, MU: 0.5}, start, 3.0))


@pytest.mark.parametrize(
    ("order", "every"), [(1, 7), *(pytest.param(*c, marks=pytest.mark.long) for c in ((1, 1), (-1, 7)))]
)
def test_a_block_dropped_flat_comes_to_rest(order, every):
    """Its corners strike together, and its slips hold what impulses leave of rounding: they are zero."""
    for height, e, mu in LANDINGS[::every]:
        run = block(order).run(values={E: e, MU: mu}, initial={Y: HIGH + height})
        assert run.status == sf.Status.OK, (height, e, mu)
        end = math.sqrt(2 * height / G) * (1 + e) / (1 - e)
        if end < 3.0:
            assert np.max(np.abs(run.final - [0, HIGH, 0, 0, 0, 0])) < 1e-13
            assert [x.t for x in run.events[-2:]] == pytest.approx([end, end], rel=1e-7)
        assert max(event.t for event in run.events) <= 3.0


@pytest.mark.one_in(2)
@pytest.mark.parametrize("height", [0.0, 0.1, 0.5])
def test_energy_of_a_plastic_landing_balances(height):
    """All of it is lost at once, so that none is left to measure the residual by but what was."""
    run = block().run(values={E: 0.0, MU: 0.5}, initial={Y: HIGH + height})
    assert run.energy_residual() < 1e-12


def test_mirror_images_move_as_mirror_images():
    mirror = np.array([-1, 1, -1, -1, 1, -1])
    rng = np.random.default_rng(11)
    for _ in range(12):
        angle, spin, way = rng.uniform(-1, 1), rng.uniform(-3, 3), rng.uniform(-2, 2)
        height = HIGH * math.cos(angle) + WIDE * abs(math.sin(angle)) + 0.1
        values = {E: rng.uniform(0.0, 0.6), MU: rng.uniform(0.0, 1.0)}
        one, other = (
            block(side).run(values=values, initial={Y: height, TH: side * angle, OM: side * spin, U: side * way})
            for side in (1, -1)
        )
        assert other.checked().final * mirror == pytest.approx(one.checked().final, abs=1e-7)
        assert len(one.events) == len(other.events)


def row(n):
    """Return n equal balls that touch in a row, struck by the first."""
    x, u = sp.symbols(f"x:{n}", real=True), sp.symbols(f"u:{n}", real=True)
    contacts = [sf.Contact(f"{i}", None, sf.Unilateral(x[i + 1] - x[i], restitution=1)) for i in range(n - 1)]
    start = dict.fromkeys((*x, *u), 0.0) | {x[0]: -0.5, u[0]: 1.0}
    return sf.Scene(sf.System([*x], [*u], sp.eye(n), [0] * n), contacts, {}, start, 1.0)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("n", [12, 25])
def test_balls_that_touch_are_struck_together(n):
    run = sf.simulate(row(n)).checked()  # as one body of the mass of all others, at a restitution of one
    assert run.final[n:] == pytest.approx([(2 - n) / n, *[2 / n] * (n - 1)], abs=1e-14)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("drive", [sp.sin(sf.TIME) * X, sp.sin(sf.TIME)], ids=["series", "linear"])
def test_feet_of_one_slip_share_its_friction(drive):
    """Their bounds move with their normal forces, so that no condition on these may stand in a series."""
    slip, law = U + OM / 5, sf.laws.coulomb(MU)
    feet = [sf.Contact(f"{side}", slip, sf.Unilateral(Y + side * TH), law) for side in (-1, 1)]
    system = sf.System([X, Y, TH], [U, V, OM], sp.diag(1, 1, sp.Rational(1, 3)), [3 + drive, -G, 0])
    start = dict.fromkeys((X, Y, TH, U, V, OM), 0.0)
    program = sf.prepare(sf.Scene(system, feet, {MU: 0.5}, start, 0.5), tolerance=1e-12)
    assert np.all(program.run().checked().final == 0.0)
    run = program.run({MU: 0.2}).checked()  # the feet hold the turning, so that all slides as one mass
    if drive == sp.sin(sf.TIME):
        assert run.final[3] == pytest.approx((3 - 0.2 * G) * 0.5 + 1 - math.cos(0.5), abs=1e-11)
    assert run.final[[1, 2, 4, 5]] == pytest.approx(np.zeros(4), abs=1e-12)
