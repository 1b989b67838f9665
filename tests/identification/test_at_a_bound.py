"""Uncertainty of a fit in which an unknown is at, near or far from its bound."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.stats
import sympy as sp

import symfric as sf
from symfric.identification.bounded import bounded_interval
from symfric.identification.pieces import Pieces
from symfric.identification.shooting import join

X, U = sp.symbols("x u", real=True)
MU_S, MU_K, C, K = sp.symbols("mu_s mu_k c k", positive=True)
T = np.linspace(0.2, 40.0, 150)
NOISE = 0.02
BOUNDS = {"mu_k": (0.1, 0.4), "c": (0.0, 0.3), "k": (0.8, 2.0)}
LAWS = {
    "coulomb": sf.laws.coulomb(MU_S, MU_K),
    "stribeck": sf.laws.stribeck(MU_S, MU_K, 0.2),
    "lugre": sf.laws.lugre(MU_S, MU_K, 0.2, 100.0, 1.0),
}
PLACES = {"at": 0.0, "near": 0.02, "far": 0.15}


def rig(law, c, v=0.15):
    belt = sf.Contact("belt", U - v, 1, LAWS[law])
    numbers = {MU_S: 0.42, MU_K: 0.3, C: c, K: 1.3}
    return sf.Scene(sf.System([X], [U], [[1]], [-K * X - C * U]), [belt], numbers, {X: 0.0, U: 0.0}, 40.0)


def fits(law, place, seeds):
    """Yield fits to noisy records of a law with damping at some place from its bound."""
    scene = rig(law, PLACES[place])
    clean = sf.simulate(scene, 1e-10)(T)[0]
    for seed in seeds:
        generator = np.random.default_rng([list(LAWS).index(law), list(PLACES).index(place), seed])
        y = clean + NOISE * generator.standard_normal(T.size)
        yield sf.identify(scene, {"x": (T, y)}, BOUNDS, starts=1)


def holds(fit, name, true):
    low, high = fit.interval(name)
    return low <= true <= high


@pytest.fixture(scope="module")
def bound():
    """A fit with the damping at its bound, whose truth is inside."""
    scene = rig("stribeck", 0.02)
    clean = sf.simulate(scene, 1e-10)(T)[0]
    for seed in range(40):
        y = clean + NOISE * np.random.default_rng([9, seed]).standard_normal(T.size)
        fit = sf.identify(scene, {"x": (T, y)}, BOUNDS, starts=1)
        if fit.active:
            return fit
    raise AssertionError("no fit ended at its bound")


def test_intervals_at_a_bound_are_those_of_profiles(bound):
    assert bound.active == ("c",)
    for name, true in (("mu_k", 0.3), ("c", 0.02), ("k", 1.3)):
        low, high = bound.interval(name)
        assert low <= true <= high
        profile = bound.profile(name, points=9).interval
        assert high == pytest.approx(profile[1], rel=1e-3)
        assert low == pytest.approx(0.0 if name == "c" else profile[0], rel=1e-3)
    assert bound.interval("c")[0] == 0.0 == bound.values["c"] < bound.interval("c")[1] < 0.3
    assert bound.profile("c", points=3).interval[0] == -np.inf
    narrow, wide = bound.interval("mu_k", 0.5), bound.interval("mu_k", 0.99)
    assert wide[0] < bound.interval("mu_k")[0] < narrow[0] < bound.values["mu_k"] < narrow[1] < wide[1]
    with pytest.raises(sf.SceneError, match="level is 1"):
        bound.interval("mu_k", 1.0)


def test_the_ends_are_where_another_fit_has_the_threshold(bound):
    """With an end held, the others are fitted anew and the unknown at the bound is free to leave it."""
    low, high = bound.interval("mu_k")
    others = {n: b for n, b in BOUNDS.items() if n != "mu_k"}
    left = []
    for end in (low, high):
        held = sf.identify(bound.scene.where({"mu_k": end}), {"x": bound.records["x"]}, others, starts=3)
        rise = bound.variance * 0.5 * scipy.stats.f.isf(0.05, 1, bound.freedom)
        assert held.cost - bound.cost == pytest.approx(rise, rel=2e-3)
        left.append(held.values["c"] > 0)
    assert any(left)


def test_errors_of_the_others_regard_it_as_free(bound):
    """Their covariance is that of all unknowns, which is larger than with one held; its own row is empty."""
    J = bound._jacobian
    whole = bound.variance * np.linalg.inv(J.T @ J)
    kept = [0, 2]
    assert bound.names == ("mu_k", "c", "k")
    assert bound.covariance[np.ix_(kept, kept)] == pytest.approx(whole[np.ix_(kept, kept)], rel=1e-6)
    assert np.all(np.isnan(bound.covariance[1]))
    assert np.all(np.isnan(bound.covariance[:, 1]))
    assert np.isnan(bound.standard_errors["c"])
    held = bound.variance * np.linalg.inv(J[:, kept].T @ J[:, kept])
    assert bound.standard_errors["mu_k"] > 1.2 * np.sqrt(held[0, 0])
    (note,) = [n for n in bound.notes if "at its bound" in n]
    assert note.startswith("c is at its bound 0; widen it")
    assert "follow the cost with c free" in note


def test_what_is_not_fixed_is_named_at_a_bound_too():
    """Friction that never acts: its coefficients end anywhere, one of them at a bound."""
    scene = rig("coulomb", 0.1).starting({"x": 0.23})
    scene = scene.where({"mu_k": 0.3, "mu_s": 0.9})
    clean = sf.simulate(scene.until(8.0), 1e-10)
    t = np.linspace(0.1, 1.2, 60)
    y = clean(t)[0] + 1e-4 * np.random.default_rng(3).standard_normal(t.size)
    fit = sf.identify(scene, {"x": (t, y)}, {"mu_s": (0.9, 2.0), "k": (0.8, 2.0)}, starts=1)
    assert any("mu_s" in d for d in fit.unidentifiable)
    assert any("do not fix mu_s" in n for n in fit.notes)


def test_records_in_pieces_have_the_interval_of_their_linearisation(bound):
    problem = bound._problem
    joined = join(problem, Pieces(problem.predictor, 3), bound.vector)
    assert joined.values[1] == pytest.approx(0.0, abs=1e-4)
    assert joined.step[1] < 0
    cut = replace(bound, _jacobian=joined.information, _step=joined.step)
    for name in bound.names:
        low, high = cut.interval(name)
        size = bound.interval(name)[1] - bound.interval(name)[0]
        assert (low, high) == pytest.approx(bound.interval(name), abs=0.25 * size)


def test_intervals_of_linear_least_squares_with_bounds():
    """Two unknowns with correlation r and unit errors, the second one at zero where -2 would fit best."""
    r = 0.8
    root = np.linalg.cholesky(np.linalg.inv([[1.0, r], [r, 1.0]])).T
    step, rise = np.array([-2.0 * r, -2.0]), 1.92
    low, high = np.array([-9.0, 0.0]), np.array([9.0, 9.0])
    least = 0.5 * 4.0
    ends = bounded_interval(root, step, low, high, 0, rise)

    def cost(d):  # the second unknown fitted between its bounds: above zero only if that is where it is drawn to
        second = max(0.0, -2.0 + r * (d + 2.0 * r))
        e = np.array([d + 2.0 * r, second + 2.0])
        return 0.5 * e @ (root.T @ root) @ e

    for end in ends:
        assert cost(end) - least == pytest.approx(rise, rel=1e-6)
    free = bounded_interval(root, step, np.full(2, -99.0), np.full(2, 99.0), 0, rise)
    assert free == pytest.approx((-2.0 * r - np.sqrt(2 * rise), -2.0 * r + np.sqrt(2 * rise)))
    assert bounded_interval(root, step, low, high, 1, rise)[0] == 0.0
    assert bounded_interval(np.eye(1), np.ones(1), np.zeros(1), np.full(1, 9.0), 0, 0.125) == pytest.approx((0.5, 1.5))


@pytest.mark.long(beside="test_intervals_at_a_bound_are_those_of_profiles")
def test_intervals_hold_the_truth_at_near_and_far_from_a_bound():
    """225 records of three laws: the share of 95 % intervals that hold the truth, for every place and every unknown."""
    held = {(place, name): [] for place in PLACES for name in BOUNDS}
    bound = dict.fromkeys(PLACES, 0)
    for law in LAWS:
        for place, c in PLACES.items():
            for fit in fits(law, place, range(25)):
                bound[place] += bool(fit.active)
                for name, true in (("mu_k", 0.3), ("c", c), ("k", 1.3)):
                    held[place, name].append(holds(fit, name, true))
            print(law, place, {n: sum(held[place, n]) for n in BOUNDS}, len(held[place, "c"]), bound, flush=True)
    shares = {key: float(np.mean(hits)) for key, hits in held.items()}
    print({k: round(v, 3) for k, v in shares.items()}, bound)
    assert bound["at"] > 20 > bound["far"]
    assert 0.92 <= np.mean(list(held.values())) <= 0.98
    for share in shares.values():  # of 75 records each
        assert share >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / 75)
