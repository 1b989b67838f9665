"""Sprung foundation mass: closed forms against a search with eigenvalues, and against stick-slip on the full model."""

import numpy as np
import pytest
from scipy.optimize import minimize

import symfric as sf
from symfric.theory import foundation
from tests.longer import longer


def decay(mu, kappa, gamma, beta):
    """Decay rate with a self-excitation, from Newton's law."""
    k = np.array([[1.0, -1.0], [-1.0, 1.0 + kappa]]) / np.array([[1.0], [mu]])
    c = np.diag([-2 * beta, 2 * gamma / mu])
    return -np.max(np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-k, -c]])).real)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("mu", [0.05, 0.3, 0.9, 1.3, 3.0, 12.0])
def test_no_mount_stabilises_more_and_some_a_little_less(mu):
    best = foundation.widest_stability(mu)
    grid = [(k, g) for k in np.geomspace(1e-4, 20, 40) for g in np.geomspace(0.05, 20, 60)]
    assert max(decay(mu, k, g, 1.002 * best.value) for k, g in grid) < 0
    start = np.log([max(best.stiffness, 1e-3), best.damping])
    simplex = start + np.array([[0.0, 0.0], [0.3, 0.0], [0.0, 0.02]])
    options = {"initial_simplex": simplex, "maxiter": 800}
    found = minimize(lambda p: -decay(mu, *np.exp(p), 0.97 * best.value), start, method="Nelder-Mead", options=options)
    assert found.fun < 0


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("mu", "kappa"), [(0.1, 0.2), (0.5, 1.5), (2.0, 0.3), (2.0, 2.5), (4.0, 8.0), (0.6, 0.05)])
def test_a_given_stiffness_has_its_best_damping(mu, kappa):
    found = foundation.at_stiffness(mu, kappa)
    assert decay(mu, kappa, found.damping, found.value) == pytest.approx(0, abs=1e-6)
    for share in (0.9, 0.97, 1.03, 1.1):
        assert decay(mu, kappa, share * found.damping, found.value) < 0
    assert max(decay(mu, kappa, g, 1.001 * found.value) for g in np.geomspace(0.02, 50, 2000)) < 0


@pytest.mark.one_in(4)
@pytest.mark.parametrize("mu", [1.5, 2.0, 6.0])
def test_exactly_in_tune_it_stabilises_less_than_a_little_stiffer(mu):
    exactly, best = foundation.at_stiffness(mu, mu - 1), foundation.widest_stability(mu)
    damping = np.append(np.geomspace(0.02, 50, 4000), exactly.damping)
    most = max(decay(mu, mu - 1, g, 0.999 * exactly.value) for g in damping)
    assert most > 0 > max(decay(mu, mu - 1, g, 1.001 * exactly.value) for g in damping)
    softer, stiffer = (foundation.at_stiffness(mu, mu - 1 + step).value for step in (-1e-6, 1e-6))
    assert (softer, stiffer) == pytest.approx((exactly.value, best.value), rel=1e-3)
    assert exactly.value < 0.98 * best.value


@pytest.mark.parametrize("mu", longer([0.1, 1.0, 2.5], [0.1, 1.0]))
def test_the_design_is_exact_and_compared_with_the_absorber(mu):
    found, other = sf.design.sprung_foundation(mu), sf.design.absorber(mu, "self-excited")
    assert found.status == "infimum"
    assert found.check.agrees
    assert f"{other.objective:.6g}" in found.active[0]
    assert foundation.break_even() == pytest.approx(1.1246769962252516, rel=1e-12)
    assert (found.objective > other.objective) == (mu < foundation.break_even())


@pytest.mark.long(beside="test_the_design_is_exact_and_compared_with_the_absorber")
def test_a_gap_of_damping_and_a_bound_of_the_stiffness_are_said():
    gap = [a for a in sf.design.sprung_foundation(0.9).active if "unstable" in a]
    assert gap  # near the main mass the mount that does most does not do for all that is less
    stiff = sf.design.sprung_foundation(0.2, least_stiffness=0.5)
    assert stiff.values["stiffness"] == 0.5
    assert "stiffness at its lower bound" in stiff.active
    assert stiff.objective < sf.design.sprung_foundation(0.2).objective


def test_it_stops_the_stick_slip_of_a_mass_on_a_belt():
    law = sf.laws.cubic(0.4, 0.25, 0.5)
    mount = foundation.at_stiffness(0.3, 0.2)
    assert mount.value > 0.45 / 2  # the largest -c1/2 of the friction, on the slowest belts
    scene = sf.scenes.sprung_foundation(
        law, mass_ratio=0.3, stiffness=0.2, damping=mount.damping, v_b=0.1, horizon=400.0
    )
    assert sf.stability(scene).stable
    assert not sf.stability(scene.where({"damping": 0.0, "stiffness": 5.0})).stable
    rest = sf.equilibrium(scene).x
    run = sf.simulate(scene.starting({"x1": rest[0] + 0.01, "x2": rest[1]})).checked()
    assert np.abs(run(400.0)[:2] - rest[:2]).max() < 1e-6


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sf.design.sprung_foundation(0.0), "mass_ratio is 0; it must be positive"),
        (lambda: sf.design.sprung_foundation(0.1, least_stiffness=-1), "least_stiffness is -1"),
        (lambda: sf.scenes.sprung_foundation(mass_ratio=1, stiffness=1, damping=1, v_b=0.1), "without a law"),
        (lambda: sf.scenes.sprung_foundation(mass_ratio=1, stiffness=-1, damping=1), "stiffness is -1"),
    ],
)
def test_bad_arguments(call, message):
    with pytest.raises(sf.SceneError, match=message):
        call()
