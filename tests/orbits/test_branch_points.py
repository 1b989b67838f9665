"""Branch points of limit cycles against Newton's method on variational equations of the tests' own."""

import itertools

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.orbits.oscillators import A, Oscillator, U, X

SYMMETRIC = Oscillator(0.1, 0.0)


def kinds(branch):
    return [s.kind for s in branch.special]


@pytest.fixture(scope="module")
def symmetric():
    return sf.continue_cycle(SYMMETRIC.scene, A, (0.2, 2.9))


def test_a_pitchfork_is_located(symmetric):
    (point,) = symmetric.special
    assert point.kind == "branch-point"
    near = [k for k, a in enumerate(symmetric.values) if abs(a - point.value) < 0.3]
    (own,) = SYMMETRIC.pitchforks(symmetric.orbits[near[0]].start, symmetric.values[near])
    assert point.value == pytest.approx(own, abs=1e-9)
    stable = np.array([o.stable for o in symmetric.orbits])
    assert np.array_equal(stable, symmetric.values < point.value)
    assert symmetric.to_dict()["special"][0]["kind"] == "branch-point"
    assert symmetric.plot().get_legend()


def test_the_other_branch_of_a_pitchfork(symmetric):
    other = sf.continue_cycle(SYMMETRIC.scene, A, (0.2, 2.9), start=symmetric.special[0])
    assert kinds(other) == ["branch-point"]
    assert other.ends == ("span", "span")
    k = [o.values["A"] for o in other.orbits].index(other.special[0].value)
    assert other.values[0] == other.values[-1] == 2.9
    assert np.all(other.values[[*range(k), *range(k + 1, len(other.values))]] > other.special[0].value)
    one, two = other.orbits[0], other.orbits[-1]
    assert one.stable
    assert two.stable
    assert np.max(np.abs(one.start - two.start)) > 0.1
    assert np.allclose(one.x_max, -two.x_min, atol=1e-9)  # mirror images
    for orbit in (one, two):
        y, M = SYMMETRIC.periodic(orbit.start, 2.9)
        assert np.allclose(y, orbit.start, atol=1e-8)
        assert np.allclose(np.sort(np.abs(np.linalg.eigvals(M))), np.sort(np.abs(orbit.multipliers)), atol=1e-7)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("b", [1e-8, -1e-5, 1e-2])
def test_an_imperfection_leaves_no_branch_point(b):
    """The branch bends away where the symmetric one has its branch point; the other one has a fold."""
    branch = sf.continue_cycle(Oscillator(0.1, 0.0, b=b).scene, A, (0.2, 2.9))
    assert kinds(branch) == []
    assert branch.orbits[-1].stable
    assert np.all(np.diff(branch.values) > 0)


def test_rest_under_parametric_excitation_doubles_its_period_no_branch_point():
    """A parametric resonance at twice the frequency: the flip leads to cycles of two periods and back."""
    scene = Oscillator(0.1, 1.0, w=2.0, b=0.1, e=1).scene
    branch = sf.continue_cycle(scene, A, (0.05, 0.9))
    assert "branch-point" not in kinds(branch)
    flip = next(s for s in branch.special if s.kind == "flip")
    double = sf.continue_cycle(scene, A, (0.05, 0.9), start=flip)
    assert "flip" in double.ends
    assert all(o.period == pytest.approx(2 * np.pi, rel=1e-12) for o in double.orbits)
    own = Oscillator(0.1, 1.0, w=2.0, b=0.1, e=1)
    far = double.orbits[0 if double.ends[1] == "flip" else -1]
    y, _ = own.periodic(far.start, far.values["A"], 2)
    assert np.allclose(y, far.start, atol=1e-8)
    assert np.linalg.norm(own.mapped(far.start, far.values["A"])[0] - far.start) > 0.01


def test_cycles_of_two_periods_near_their_flip_are_not_taken_for_one_at_a_coarse_tolerance():
    own = Oscillator(0.1, 1.0, w=2.0, b=0.1, e=1)
    branch = sf.continue_cycle(own.scene, A, (0.05, 0.9))
    flip = next(s for s in branch.special if s.kind == "flip")
    double = sf.continue_cycle(own.scene, A, (0.05, 0.9), start=flip, most=3)
    near = sorted(double.orbits, key=lambda o: abs(o.values["A"] - flip.value))[2:4]
    for orbit, tolerance in itertools.product(near, (1e-4, 1e-5, 1e-6)):
        value = orbit.values["A"]
        apart = np.abs(own.mapped(orbit.start, value)[0] - orbit.start) / orbit.half_range
        assert np.max(apart) > 10 * tolerance
        again = sf.limit_cycle(own.scene.where({A: value}), orbit, tolerance)
        assert again.period == pytest.approx(2 * np.pi, rel=1e-12)


def test_cycles_between_two_flips():
    """The cycles of twice the period lead from one flip to another, and are met once."""
    scene = Oscillator(0.1, 0.0, b=0.6).scene
    branch = sf.continue_cycle(scene, A, (0.5, 1.4))
    flips = [s for s in branch.special if s.kind == "flip"]
    double = sf.continue_cycle(scene, A, (0.1, 4.0), start=flips[0])
    assert double.ends == ("flip", "flip")
    ends = sorted(s.value for s in (double.special[0], double.special[-1]))
    assert ends == pytest.approx([s.value for s in flips], abs=1e-8)
    again = sf.continue_cycle(scene, A, (0.5, 1.7), start=double.special[0], most=5)
    assert again.orbits[-1].period == pytest.approx(4 * np.pi)


@pytest.mark.long(beside="test_the_other_branch_of_a_pitchfork")
def test_two_branches_that_cross():
    """Rest of the first mass is a branch for every p; another one crosses it, and both change their stability."""
    p, y, v = sp.Symbol("p", real=True), sp.Symbol("y", real=True), sp.Symbol("v", real=True)
    force = [-U / 2 + p * X - X**2 - X**3 / 5 + 2 * X * y, -v / 2 - 2 * y + sp.cos(sf.TIME)]
    scene = sf.Scene(sf.System([X, y], [U, v], np.eye(2), force), [], {p: 0.3}, {X: 0, U: 0, y: 0, v: 0}, 200.0)
    start = sf.limit_cycle(scene, ([0, 0.8, 0, 0.4], 2 * np.pi))
    rest = sf.continue_cycle(scene, p, (-2, 0.5), start=start)
    points = [s for s in rest.special if s.kind == "branch-point"]
    assert len(points) == 2
    for point, before in zip(points, (True, False), strict=True):
        near = [o for o, a in zip(rest.orbits, rest.values, strict=True) if abs(a - point.value) < 0.1]
        sides = {bool(o.values["p"] < point.value): o.stable for o in near}
        assert sides == {True: before, False: not before}
    other = sf.continue_cycle(scene, p, (-2, 0.5), start=points[0])
    assert other.ends == ("span", "span")
    again = [s.value for s in other.special if s.kind == "branch-point"]
    assert again == pytest.approx([s.value for s in points], abs=1e-8)
    moves = np.array([o.half_range[0] for o in other.orbits])
    assert np.sum(moves < 1e-6) < 20  # it crosses rest, and does not follow it
    assert np.max(moves) > 0.1
    assert kinds(other).count("fold") == 2


def test_manners(symmetric):
    (point,) = symmetric.special
    assert "ends: the end of the span at A = 0.2" in repr(symmetric)
    assert symmetric.reasons[1] == "the end of the span at A = 2.9"
    short = sf.continue_cycle(SYMMETRIC.scene, A, (0.2, 2.9), most=3)
    assert short.ends == ("budget", "budget")
    assert "largest number of orbits" in short.reasons[0]
    with pytest.raises(sf.SceneError, match="outside the span"):
        sf.continue_cycle(SYMMETRIC.scene, A, (0.2, 0.4), start=point)
    with pytest.raises(sf.SceneError, match="branch point has no curve"):
        sf.continue_special(point, ("A", "A"), ((0.2, 3), (0.2, 3)))
