"""Families of branches with dry friction: what they claim, against SciPy's simulation and settled motions."""

import numpy as np
import pytest
from scipy.optimize import brentq

import symfric as sf
from symfric.orbits.continuation.hopf import vanishing_point
from symfric.orbits.flow_map import FlowMap
from tests.longer import longer
from tests.orbits.checked_branches import (
    branch_of,
    forced,
    nontrivial,
    one_mass,
    silent_changes,
    swept,
    twins,
    two_masses,
    wrong_orbits,
    wrong_specials,
)


def check(case, seed):
    branch = branch_of(case)
    if branch is None:
        pytest.skip("the motion settles to no cycle")
    rng = np.random.default_rng(seed)
    assert "lost" not in branch.ends
    assert silent_changes(case, branch) == []
    assert wrong_specials(case, branch) == []
    wrong, _ = wrong_orbits(case, branch, rng)
    assert wrong == []
    _, wrong = swept(case, branch, rng)
    assert wrong == []


@pytest.mark.long(beside="test_branch_points_of_a_forced_cycle_with_sticking")
@pytest.mark.parametrize("seed", range(40))
def test_one_mass_on_a_belt(seed):
    check(one_mass(seed), seed)


@pytest.mark.long(beside="test_branch_points_of_a_forced_cycle_with_sticking")
@pytest.mark.parametrize("seed", range(40))
def test_forced_oscillators(seed):
    check(forced(seed), seed)


@pytest.mark.long(beside="test_branch_points_of_a_forced_cycle_with_sticking")
@pytest.mark.parametrize("seed", range(40))
def test_two_masses_on_a_belt(seed):
    check(two_masses(seed), seed)


@pytest.mark.long(beside="test_branch_points_of_a_forced_cycle_with_sticking")
@pytest.mark.parametrize("seed", range(40))
def test_two_masses_of_a_kind(seed):
    check(twins(seed), seed)


def own_location(case, branch, value, apart):
    """Return where the leading multiplier of the tests' own, linear between cycles on both sides, passes 1."""
    near = branch.orbits[int(np.argmin(np.abs(branch.values - value)))]
    ends = []
    for there in (value - apart, value + apart):
        orbit = sf.limit_cycle(case.own.at(case.name, there).scene(), guess=near)
        ends.append(float(np.max(np.abs(nontrivial(case._replace(own=case.own.at(case.name, there)), orbit)))) - 1)
    assert ends[0] * ends[1] < 0
    return value - apart + 2 * apart * ends[0] / (ends[0] - ends[1])


@pytest.fixture(scope="module")
def shaken():
    case = forced(1001)._replace(span=(0.42, 0.6))
    case = case._replace(own=case.own.at("w", 0.595), starts=(0.595,))
    return case, branch_of(case)


@pytest.mark.parametrize("sticks", longer([True, False], [False]))
def test_branch_points_of_a_forced_cycle_with_sticking(shaken, sticks):
    case, branch = shaken
    points = {s.orbit.stick_fraction > 0: s.value for s in branch.special if s.kind == "branch-point"}
    assert sorted(points) == [False, True]
    assert points[sticks] == pytest.approx(own_location(case, branch, points[sticks], 1e-4), abs=1e-5)


@pytest.mark.long(beside="test_branch_points_of_a_forced_cycle_with_sticking")
def test_the_other_branch_of_a_forced_cycle_closes(shaken):
    """It leads from one point to the other and back over the mirror images; events pass the start of the period."""
    case, branch = shaken
    points = sorted(s.value for s in branch.special if s.kind == "branch-point")
    for point in (s for s in branch.special if s.kind == "branch-point"):
        other = sf.continue_cycle(case.own.scene(), case.name, case.span, start=point)
        assert "closed" in other.ends
        assert sorted({round(s.value, 8) for s in other.special if s.kind == "branch-point"}) == pytest.approx(points)
        assert silent_changes(case, other) == []
        wrong, _ = wrong_orbits(case, other, np.random.default_rng(0), 1)
        assert wrong == []


def test_an_event_at_the_start_of_the_period_is_no_special_point():
    case = forced(3)._replace(span=(0.42, 0.47))
    case = case._replace(own=case.own.at("w", 0.43), starts=(0.43,))
    branch = branch_of(case)
    times = np.array([o.events[0].t / o.period for o in branch.orbits])
    assert np.min(times) < 0.02 < 0.1 < np.max(times)
    assert branch.special == ()
    assert branch.ends == ("span", "span")


@pytest.mark.long(beside="test_a_stick_through_the_start_of_the_period_begins_once")
def test_a_slip_that_begins_is_no_least_slip():
    """It starts from zero and turns there by rounding; the least slip of the orbit comes later."""
    own = two_masses(18).own.at("v_b", 0.10295088036057867)
    start = [0.3908864687986829, 0.3824089489524858, 0.07473976760936349, -0.1566786679835926]
    passage = FlowMap(own.scene(), ["v_b"]).run(np.array(start), {}, 42.19979817890113)
    sticks = [t for t, i, _, after in passage.events if i == 0 and after == 0]
    t = np.linspace(0, 42.2, 400_001)
    slip = own.v_b - np.asarray(sf.simulate(own.scene(42.2, start), 1e-13)(t))[2]
    turns = t[1:-1][(slip[1:-1] < slip[:-2]) & (slip[1:-1] <= slip[2:]) & (slip[1:-1] > 1e-9)]
    least = min(np.interp(turns, t, slip))
    assert len(sticks) == 11
    assert passage.gaps[0] == pytest.approx(least, abs=1e-8)
    assert passage.gaps[0] > 1e-10


def test_a_stick_through_the_start_of_the_period_begins_once():
    for orbit in branch_of(forced(25)).orbits:
        assert sum(e.after == 0 for e in orbit.events) == sum(e.before == 0 for e in orbit.events)


def test_a_branch_ends_at_a_hopf_point_of_a_pair_beside_an_unstable_one():
    """Steady sliding is unstable on both sides, by the other pair of eigenvalues; slopes of friction by hand."""
    own = two_masses(2).own
    (m1, m2), (k1, k2), k, (mu_s, mu_k, v_s) = own.m, own.k, own.k_c, own.law

    def pairs(v):
        slope = np.array(own.N) * (mu_s - mu_k) / v_s * np.exp(-v / v_s)  # of friction by the velocity of the mass
        K, C = np.array([[k1 + k, -k], [-k, k2 + k]]), np.diag(np.array(own.c) - slope)
        M = np.diag([m1, m2])
        A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
        found = np.linalg.eigvals(A)
        return sorted(found[found.imag > 0], key=lambda e: e.imag)

    value = brentq(lambda v: pairs(v)[0].real, 0.5, 0.65, xtol=1e-13)
    slow, fast = pairs(value)
    assert fast.real > 1e-3
    sizes = np.sqrt([0.002, 0.001])
    found = vanishing_point(own.scene(), "v_b", value + np.array([0.002, 0.001]), sizes, 2 * np.pi / slow.imag)
    assert found == pytest.approx(value, abs=1e-11)
