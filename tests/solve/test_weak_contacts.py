"""Contacts far weaker than the other forces, and loads that vanish where the slip is zero: they hold nothing."""

import numpy as np
import pytest
import sympy as sp
from scipy import integrate

import symfric as sf

X, U, Y, W = sp.symbols("x u y w", real=True)
N = sp.Symbol("N", positive=True)
LAWS = {"coulomb": sf.laws.coulomb(0.5), "drop": sf.laws.coulomb(0.6, 0.4), "stribeck": sf.laws.stribeck(0.5, 0.4, 0.1)}


@pytest.mark.parametrize("route", ["taylor", "exact"])
@pytest.mark.parametrize("law", ["coulomb", "drop"])
def test_a_weak_contact_leaves_a_free_vibration_alone(route, law):
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X]), [sf.Contact("c", U, N, LAWS[law])], {N: 1.0}, {X: 1, U: 0}, 10)
    program = sf.prepare(scene, 1e-10, route)
    for load in 10.0 ** np.array([-9, -12, -13, -13.5, -14, -14.5, -15, -16, -17, -20, -50, -100, -250]):
        run = program.run({N: load}).checked()
        assert run.stats["events"] == 3  # the turning points, each passed at once
        assert run.final == pytest.approx([np.cos(10), -np.sin(10)], abs=1e-10 + 5 * load)


@pytest.mark.one_in(12)
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("route", ["taylor", "integrators"])
def test_a_weak_contact_beside_others_changes_the_motion_by_as_little(seed, route):
    rng = np.random.default_rng([19, seed])
    kc, damping, load, speed, mu = rng.uniform([0.2, 0.02, 0.3, -0.3, 0.2], [1.5, 0.2, 0.9, 0.3, 0.6])
    force = [-X - kc * (X - Y) - damping * U + sp.sin(1.3 * sf.TIME), -Y + kc * (X - Y)]
    system = sf.System([X, Y], [U, W], [[1, 0], [0, rng.uniform(0.5, 2)]], force)
    strong = sf.Contact("strong", U - speed, load, sf.laws.coulomb(1.3 * mu, mu))
    slip = [W, W - U, W + U / 2 - 0.1, U, 2 * U - W, W - speed][seed]
    weak = sf.Contact("weak", slip, N, list(LAWS.values())[seed % 3])
    start = dict(zip([X, Y, U, W], rng.uniform(-1, 1, 4), strict=True))
    tolerance = 1e-8 if route == "integrators" else 1e-11
    alone = sf.simulate(sf.Scene(system, [strong], {}, start, 10), 1e-12).checked()
    program = sf.prepare(sf.Scene(system, [strong, weak], {N: 1.0}, start, 10), tolerance, route)
    for exponent in (-12, -14, -15, -17, -30) if route == "taylor" else (-14, -30):
        run = program.run({N: 10.0**exponent}).checked()
        assert run.final == pytest.approx(alone.final, abs=1e2 * tolerance)


VANISHING = {  # load, and the magnitude of the friction over mu
    "square": (U**2, lambda x, u: u * u),
    "fourth power": (U**4, lambda x, u: u**4),
    "magnitude": (sp.Abs(U), lambda x, u: abs(u)),
    "square over the place": (U**2 * (1 + X**2), lambda x, u: u * u * (1 + x * x)),
    "bent over the place": (U**2 * sp.Abs(X), lambda x, u: u * u * abs(x)),
    "cosine": (1 - sp.cos(U), lambda x, u: 1 - np.cos(u)),
    "nearly": (U**2 + sp.Rational(1, 10**16), lambda x, u: u * u + 1e-16),
}


@pytest.mark.one_in(32)
@pytest.mark.parametrize("load", VANISHING)
@pytest.mark.parametrize("law", [sf.laws.coulomb(0.6), sf.laws.coulomb(0.8, 0.6)], ids=["coulomb", "drop"])
@pytest.mark.parametrize("start", [(1.0, 0.3), (1.0, 0.0)])
def test_a_load_that_vanishes_with_the_slip_lets_it_pass(load, law, start):
    expr, size = VANISHING[load]
    friction = lambda t, y: [y[1], -y[0] - 0.6 * np.sign(y[1]) * size(*y)]  # noqa: E731
    right = integrate.solve_ivp(friction, (0, 12), start, rtol=1e-11, atol=1e-12, method="DOP853", max_step=0.05).y
    initial = dict(zip((X, U), start, strict=True))
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X]), [sf.Contact("c", U, expr, law)], {}, initial, 12)
    for tolerance in (1e-6, 1e-9, 1e-12):
        run = sf.simulate(scene, tolerance).checked()
        assert run.final == pytest.approx(right[:, -1], abs=2e-9 + 10 * tolerance)
        assert {e.kind for e in run.events} == {"reverse"} or start[1] == 0


@pytest.mark.one_in(4)
@pytest.mark.parametrize("slip", [U - sp.Rational(1, 5), U - 0.2, U - W, 3 * U - 2 * W])
def test_a_load_that_vanishes_with_a_slip_of_several_velocities(slip):
    gap = sp.lambdify((U, W), slip)
    slopes = [float(slip.diff(e)) for e in (U, W)]

    def rate(t, y):
        force = -0.6 * gap(*y[2:]) * abs(gap(*y[2:]))
        return [*y[2:], -y[0] + slopes[0] * force, -2 * y[1] + slopes[1] * force]

    start = [1.0, -0.4, 0.3, 0.5]
    right = integrate.solve_ivp(rate, (0, 12), start, rtol=1e-11, atol=1e-12, method="DOP853").y[:, -1]
    system = sf.System([X, Y], [U, W], sp.eye(2), [-X, -2 * Y])
    scene = sf.Scene(
        system,
        [sf.Contact("c", slip, slip**2, sf.laws.coulomb(0.6))],
        {},
        dict(zip((X, Y, U, W), start, strict=True)),
        12,
    )
    for tolerance, route in ((1e-9, "taylor"), (1e-12, "taylor"), (1e-8, "integrators")):
        assert sf.simulate(scene, tolerance, route).checked().final == pytest.approx(right, abs=1e-8 + 10 * tolerance)


def test_a_profile_that_is_zero_at_the_start_holds_nothing_there():
    law, pushed = sf.laws.coulomb(0.6), sf.System([X], [U], [[1]], [sp.Rational(1, 10)])
    scene = sf.Scene(pushed, [sf.Contact("c", U, 1, law, profile=X**2)], {}, {X: 0, U: 0}, 20)
    # 0.1 x - 0.2 x^3 is the energy: it stops at x = 0.5**0.5, where 0.3 holds 0.1
    for tolerance in (1e-6, 1e-9, 1e-12):
        assert sf.simulate(scene, tolerance).checked().final == pytest.approx([0.5**0.5, 0], abs=10 * tolerance)


def test_a_weak_contact_holds_what_nothing_else_moves():
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X]), [sf.Contact("c", U, N, LAWS["drop"])], {N: 1.0}, {X: 0, U: 0}, 5)
    for route in ("taylor", "exact", "integrators"):
        program = sf.prepare(scene, 1e-9, route)
        for load in (1e-12, 1e-15, 1e-100):
            held = program.run({N: load}, {X: 0.5 * load}).checked()
            assert held.mode.tolist() == [[0] * held.mode.shape[1]]
            released = program.run({N: load}, {X: 2 * load}).checked()
            assert abs(released.final[0]) < 2 * load
