"""Branch points of families of oscillators against a search of their own, found, missed and false."""

import numpy as np
import pytest

import symfric as sf
from tests.longer import longer
from tests.orbits.oscillators import A, Oscillator


def symmetric(seed):
    r = np.random.default_rng(seed)
    return Oscillator(float(r.uniform(0.08, 0.3)), float(r.choice([0.0, -0.3, 0.4])), float(r.uniform(0.8, 1.3)))


def counted(own, branch):
    """Return branch points found by both, missed, and false, at the symmetric orbits of a branch."""
    orbits = [o for o in branch.orbits if abs(o.x_max[0] + o.x_min[0]) < 1e-6 * o.half_range[0]]
    found = [s for s in branch.special if s.kind == "branch-point"]
    expected, before = [], None
    for orbit in orbits:
        a = orbit.values["A"]
        _, N = own.symmetric(orbit.start, a)
        test = np.linalg.det(np.eye(2) + N)
        if before is not None and test * before[0] < 0:
            expected.append(sorted((before[1], a)))
        before = test, a
    hits = sum(any(low <= s.value <= high for s in found) for low, high in expected)
    return hits, len(expected) - hits, len(found) - hits


@pytest.mark.parametrize("seed", longer(range(30), set(range(30)) - {12}))
def test_branch_points_are_those_of_the_own_search(seed):
    own = symmetric(seed)
    branch = sf.continue_cycle(own.scene, A, (0.1, 4.0), most=300)
    _, missed, false = counted(own, branch)
    assert (missed, false) == (0, 0)


@pytest.mark.one_in(20)
@pytest.mark.parametrize("seed", range(20))
def test_biased_oscillators_have_none(seed):
    own = symmetric(seed)._replace(b=10.0 ** -float(np.random.default_rng(seed).uniform(1, 8)))
    branch = sf.continue_cycle(own.scene, A, (0.1, 4.0), most=300)
    assert all(s.kind != "branch-point" for s in branch.special)


@pytest.mark.one_in(20)
@pytest.mark.parametrize("seed", range(20))
def test_other_branches_hold_cycles(seed):
    """The cycles of the other branch close, by the equations of the tests, and are not symmetric."""
    own = symmetric(seed)
    for point in [s for s in sf.continue_cycle(own.scene, A, (0.1, 4.0), most=300).special if s.kind == "branch-point"]:
        other = sf.continue_cycle(own.scene, A, (0.1, 4.0), start=point, most=12)
        for orbit in (other.orbits[0], other.orbits[-1]):
            end, _ = own.mapped(orbit.start, orbit.values["A"])
            assert np.max(np.abs(end - orbit.start) / orbit.half_range) < 1e-6
            half, _ = own.mapped(orbit.start, orbit.values["A"], 0.5)
            assert np.max(np.abs(half + orbit.start) / orbit.half_range) > 1e-3
