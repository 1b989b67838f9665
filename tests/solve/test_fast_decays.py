"""Steps with weighted coefficients: fast decays limit them far less, and they are as accurate as others."""

import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve.loop import model
from symfric.solve.loop.stepping.decay_weights import DAMPED, exact_order, weights

X, U, Z, Y = sp.symbols("x u z y", real=True)
V = sp.Symbol("v_b", positive=True)
LAST = 30  # longest series with weights
CLOSE = 3e-3  # relative, the rounding of 13 digits in sums of terms of up to 1e10
END = {"end": sf.End()}


def end_of_decay(order, z):
    """R(-z) of a weighted step."""
    g = weights(order)
    return np.polynomial.polynomial.polyval(-z, [g[k] / math.factorial(k) for k in range(order + 1)])


def limit(order):
    """The largest z at which nothing grows."""
    z = np.linspace(3.0, 60.0, 57_001)
    return z[np.argmax(np.abs(end_of_decay(order, z)) > DAMPED * (1 + CLOSE))]


@pytest.mark.parametrize("order", range(8, LAST + 1))
def test_no_other_weights_reach_farther(order):
    exact, most = exact_order(order), limit(order)
    assert np.all(weights(order)[: exact + 1] == 1.0)
    assert np.all(np.diff(weights(order)[exact:]) < 0.0)
    value = end_of_decay(order, np.linspace(2.0, most, 200_001))
    touches = np.flatnonzero(np.abs(value) > DAMPED * (1 - CLOSE))
    signs = np.sign(value[touches])
    assert 1 + np.count_nonzero(np.diff(signs)) == order - exact + 1  # alternation, as in Chebyshev's theorem
    plain = np.polynomial.polynomial.polyval(-most, [1 / math.factorial(k) for k in range(order + 1)])
    assert abs(plain) > 100


def test_series_without_weights():
    assert exact_order(7) == exact_order(LAST + 1) == 0
    assert np.all(weights(LAST + 1) == 1.0)


def follower(rate, turn):
    """A spiral that decays fast onto a slow motion, z = cos t and y = sin t if it starts there."""
    of_z, of_y = Z - sp.cos(sf.TIME), Y - sp.sin(sf.TIME)
    rates = [-rate * of_z - turn * of_y - sp.sin(sf.TIME), -rate * of_y + turn * of_z + sp.cos(sf.TIME)]
    system = sf.System([X], [U], [[1]], [-X + Z], z=[Z, Y], z_rate=rates)
    outputs = {**END, "z": sf.Samples(Z, np.linspace(0.1, 19.9, 300)), "area": sf.Integral(Z), "top": sf.Max(Y)}
    return sf.Scene(system, [], {}, {X: 0.0, U: 0.0, Z: 1.5, Y: 0.0}, 20.0, outputs)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10, 1e-12])
@pytest.mark.parametrize(("rate", "turn"), [(50.0, 0.0), (1000.0, 0.0), (400.0, 150.0)])
def test_a_fast_decay_takes_fewer_steps_and_is_as_accurate(rate, turn, tolerance, monkeypatch):
    run = sf.simulate(follower(rate, turn), tolerance, "taylor")
    t = np.linspace(0.1, 19.9, 300)
    left = 0.5 * np.exp(-rate * t) * np.cos(turn * t)
    assert run["z"] == pytest.approx(np.cos(t) + left, abs=10 * tolerance)
    assert run.final[2:] == pytest.approx([math.cos(20.0), math.sin(20.0)], abs=10 * tolerance)
    area = math.sin(20.0) + 0.5 * rate / (rate**2 + turn**2)
    assert run["area"] == pytest.approx(area, abs=50 * tolerance)
    assert run["top"] == pytest.approx(1.0, abs=10 * tolerance)
    monkeypatch.setattr(model, "exact_order", lambda _: 0)
    plain = sf.simulate(follower(rate, turn), tolerance, "taylor")
    part = run.stats["steps"] / plain.stats["steps"]
    assert part < (0.7 if turn == 0.0 and tolerance > 1e-11 else 1.0)


def bristles(sigma0, horizon=12.0, **outputs):
    law = sf.laws.lugre(0.4, 0.25, 0.1, sigma0, sigma0**0.5 / 3)
    system = sf.System([X], [U], [[1]], [-X - U / 10])
    contact = sf.Contact("belt", U - V, 1, law)
    return sf.Scene(system, [contact], {V: 0.2}, {X: 0.0, U: 0.0}, horizon, outputs or END)


BELT = sf.scenes.mass_on_belt(v_b=0.2, horizon=25.0).wanting(END)
FAMILY = {
    "soft bristles": bristles(100.0),
    "bristles": bristles(1e3),
    "stiff bristles": bristles(3e4, 6.0),
    "regularised": BELT.regularised(1e-3),
    "regularised by a hyperbolic tangent": BELT.regularised(1e-3, "tanh"),
}  # fmt: skip


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", FAMILY)
def test_laws_without_a_jump_are_as_accurate_as_without_weights(name, monkeypatch):
    tolerances, steps = (1e-5, 1e-9), []
    found = [sf.simulate(FAMILY[name], tolerance, "taylor") for tolerance in tolerances]
    monkeypatch.setattr(model, "exact_order", lambda _: 0)
    true = sf.simulate(FAMILY[name], 1e-13, "taylor").final
    for tolerance, run in zip(tolerances, found, strict=True):
        assert run.status == sf.Status.OK
        assert run.final == pytest.approx(true, abs=20 * tolerance)
        steps.append(run.stats["steps"] / sf.simulate(FAMILY[name], tolerance, "taylor").stats["steps"])
    assert min(steps) < (1.01 if name == "soft bristles" else 0.7)
    assert max(steps) < 1.05


def test_the_motion_within_a_step_is_right():
    scene = bristles(1e3, path=sf.Trajectory())
    t = np.linspace(0.0, 12.0, 5000)
    coarse, fine = sf.simulate(scene, 1e-7, "taylor"), sf.simulate(scene, 1e-12, sf.Taylor(order=LAST + 4))
    assert np.max(np.abs(coarse(t) - fine(t))) < 1e-6


def test_derivatives_take_the_same_steps_for_decays():
    scene = bristles(1e3, 5.0)
    run = sf.simulate(scene, 1e-10, sensitivities=["v_b"])
    h = 1e-5
    program = sf.prepare(scene, 1e-13, "taylor")
    ends = [program.run({"v_b": 0.2 + s * h}).final for s in (1, -1)]
    assert run.sensitivities["v_b"][:2] == pytest.approx((ends[0] - ends[1])[:2] / (2 * h), rel=1e-5, abs=1e-7)


def test_a_law_of_a_contact_costs_what_its_equations_cost():
    """The rate of a bristle stands in its force, too; it is computed once."""
    w = U - V
    level = 0.25 + 0.15 * sp.exp(-((w / sp.Rational(1, 10)) ** 2))
    rate = w - 1000 * sp.Abs(w) * Z / level
    system = sf.System([X], [U], [[1]], [-X - U / 10 - 1000 * Z - 10 * rate], z=[Z], z_rate=[rate])
    by_hand = sf.Scene(system, [], {V: 0.2}, {X: 0.0, U: 0.0, Z: 0.0}, 12.0, END)
    law = sf.laws.lugre(0.4, 0.25, 0.1, 1000.0, 10.0)
    contact = sf.Contact("belt", w, 1, law)
    as_law = sf.Scene(sf.System([X], [U], [[1]], [-X - U / 10]), [contact], {V: 0.2}, {X: 0.0, U: 0.0}, 12.0, END)
    programs = [sf.prepare(scene, 1e-9, "taylor") for scene in (by_hand, as_law)]
    lengths = [p._variants[0].series.n_instructions() for p in programs]
    assert lengths[1] < 1.1 * lengths[0]
    runs = [p.run() for p in programs]
    assert runs[1].stats["steps"] == pytest.approx(runs[0].stats["steps"], rel=0.05)
    assert runs[1].final == pytest.approx(runs[0].final, abs=1e-8)
