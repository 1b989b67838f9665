"""The closed forms of the tuned mass damper against direct numerical optima, by methods that share nothing with them."""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize, minimize_scalar

import symfric as sf
from symfric.theory import absorber

MASSES = [0.02, 0.5, 6.0]


def hamiltonian_crosses(matrix, level):
    """Whether the response to a force on the main mass reaches a level: imaginary eigenvalues of the Hamiltonian."""
    b, c = np.array([[0, 0, 1.0, 0]]), np.array([[1.0, 0, 0, 0]])
    whole = np.block([[matrix, b.T @ b / level**2], [-c.T @ c, -matrix.T]])
    values = np.linalg.eigvals(whole)
    return bool(np.any(np.abs(values.real) < 1e-9 * np.abs(values)))


@pytest.mark.parametrize("mu", MASSES)
@pytest.mark.parametrize(("f", "zeta"), [(0.9, 0.1), (0.5, 0.3), (1.2, 0.02)])
def test_highest_peak_is_the_h_infinity_norm(mu, f, zeta):
    highest = absorber.peaks(mu, f, zeta)[0][1]
    matrix = absorber.state_matrix(mu, f, zeta)
    assert not hamiltonian_crosses(matrix, highest * (1 + 1e-8))
    assert hamiltonian_crosses(matrix, highest * (1 - 1e-6))
    g, y = absorber.peaks(mu, f, zeta)[0]
    rounding = 4 * np.finfo(float).eps * highest**2  # a sharp peak magnifies that of the frequency
    assert absorber.response(mu, f, zeta, g) == pytest.approx(y, rel=max(1e-10, rounding))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("mu", MASSES)
def test_least_peak(mu):
    def equal(zeta):
        # at the best tuning for a damping the peaks beside the middle are equally high
        def difference(f):
            left, right = sorted(absorber.peaks(mu, f, zeta))[-2:]
            return left[1] - right[1]

        f = brentq(difference, best.tuning * (1 - width), best.tuning * (1 + width), xtol=1e-15, rtol=1e-14)
        return absorber.peaks(mu, f, zeta)[0][1]

    best, width = absorber.least_peak(mu), 0.03 if mu > 1 else 0.005
    found = minimize_scalar(equal, bounds=(0.97 * best.damping, 1.03 * best.damping), method="bounded")
    assert found.fun == pytest.approx(best.value, rel=1e-9)
    assert found.fun >= best.value * (1 - 1e-12)
    assert absorber.peaks(mu, *best[:2])[0][1] == pytest.approx(best.value, rel=1e-11)
    draw = np.random.default_rng(1)
    places = zip(best.tuning * draw.uniform(0.2, 3, 200), draw.uniform(0.001, 2, 200), strict=True)
    assert min(absorber.peaks(mu, f, z)[0][1] for f, z in places) > best.value


@pytest.mark.parametrize("mu", [0.001, 0.05, 1.0])
def test_den_hartog_is_a_little_worse(mu):
    plain, best = absorber.fixed_points(mu), absorber.least_peak(mu)
    assert absorber.response(mu, *plain[:2], 1.0) > 0
    assert plain.value < best.value < absorber.peaks(mu, *plain[:2])[0][1] < best.value * 1.01


@pytest.mark.parametrize("mu", MASSES)
def test_least_variance(mu):
    import control

    best = absorber.least_variance(mu)
    found = minimize(
        lambda p: absorber.variance(mu, *p),
        np.array(best[:2]) * [1.02, 0.97],
        method="Nelder-Mead",
        options={"xatol": 1e-9, "fatol": 1e-15},
    )
    assert found.fun == pytest.approx(best.value, rel=1e-10)
    assert found.x == pytest.approx(np.array(best[:2]), rel=1e-6)
    matrix = absorber.state_matrix(mu, *best[:2])
    system = control.ss(matrix, [[0], [0], [1], [0]], [[1, 0, 0, 0]], 0)
    assert control.norm(system, 2) ** 2 == pytest.approx(best.value, rel=1e-8)
    draw = np.random.default_rng(2)
    places = zip(best.tuning * draw.uniform(0.2, 3, 200), draw.uniform(0.001, 2, 200), strict=True)
    assert min(absorber.variance(mu, f, z) for f, z in places) > best.value


def leftmost(mu):
    """Return the largest rate of decay over all pairs of quadratic factors, by a search of its own.

    ``(s^2 + a1 s + b1)(s^2 + a2 s + b2)`` is a characteristic polynomial of the absorber if two conditions hold; both
    factors have their roots left of -rate if those of the shifted factors have positive coefficients.
    """

    def conditions(z):
        a1, b1, a2, b2, _ = z
        c3, c2, c1, c0 = a1 + a2, b1 + b2 + a1 * a2, a1 * b2 + a2 * b1, b1 * b2
        return [c3 - (1 + mu) * c1, c2 - 1 - (1 + mu) * c0]

    def left(z):
        a1, b1, a2, b2, rate = z
        return [e for a, b in ((a1, b1), (a2, b2)) for e in (a - 2 * rate, b - a * rate + rate**2)]

    rules = [{"type": "eq", "fun": conditions}, {"type": "ineq", "fun": left}]
    draw = np.random.default_rng(3)
    found = []
    for _ in range(8):
        start = [*draw.uniform(0.05, 1.5, 4), 0.05]
        run = minimize(
            lambda z: -z[4], start, constraints=rules, method="SLSQP", options={"ftol": 1e-15, "maxiter": 400}
        )
        if np.max(np.abs(conditions(run.x))) < 1e-10 and min(left(run.x)) > -1e-10 and min(run.x[:4]) > 0:
            found.append(-run.fun)
    return max(found)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("mu", MASSES)
def test_fastest_decay(mu):
    best = absorber.fastest_decay(mu)
    assert leftmost(mu) == pytest.approx(best.value, rel=1e-7 if mu > 4 else 1e-8)
    # eigenvalues that coincide are known to half the digits, three of them to a third
    assert absorber.decay_rate(mu, *best[:2]) == pytest.approx(best.value, rel=1e-4)
    draw = np.random.default_rng(4)
    places = zip(best.tuning * draw.uniform(0.2, 3, 800), draw.uniform(0.001, 3, 800), strict=True)
    assert max(absorber.decay_rate(mu, f, z) for f, z in places) < best.value


def test_fastest_decay_joins_at_four():
    below, above = absorber.fastest_decay(4.0), absorber.fastest_decay(4.0 * (1 + 1e-12))
    assert below == pytest.approx(above, rel=1e-5)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("mu", MASSES)
def test_widest_stability(mu):
    best = absorber.widest_stability(mu)

    def conditions(z):
        b1, b2, f, damper, twice = z  # both pairs on the imaginary axis, damper = 2 zeta f, twice the negative damping
        return [
            damper * (1 + mu) - twice,
            1 + f**2 * (1 + mu) - damper * twice - b1 - b2,
            damper - twice * f**2,
            f**2 - b1 * b2,
        ]

    run = minimize(
        lambda z: -z[4],
        [0.7, 0.9, 1 / np.sqrt(1 + mu), 0.1, 0.1],
        constraints={"type": "eq", "fun": conditions},
        bounds=[(0, None)] * 5,
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
    )
    assert np.max(np.abs(conditions(run.x))) < 1e-9
    assert -run.fun / 2 == pytest.approx(best.value, rel=1e-8)
    # a little below it an absorber near this one is stable, and at it none is
    draw = np.random.default_rng(5)
    near = zip(best.tuning * draw.uniform(0.97, 1.03, 1000), best.damping * draw.uniform(0.9, 1.1, 1000), strict=True)
    near = list(near)
    assert max(absorber.decay_rate(mu, f, z, -0.98 * best.value) for f, z in near) > 0
    assert max(absorber.decay_rate(mu, f, z, -best.value) for f, z in near) < 0
    places = zip(best.tuning * draw.uniform(0.1, 3, 600), draw.uniform(0.001, 3, 600), strict=True)
    assert max(absorber.decay_rate(mu, f, z, -best.value) for f, z in places) < 0


@pytest.mark.parametrize("bad", [0, -1, float("nan"), "0.1", None])
def test_bad_mass_ratio(bad):
    for form in (absorber.least_peak, absorber.fixed_points, absorber.widest_stability):
        with pytest.raises(sf.SceneError, match="mass_ratio"):
            form(bad)


def test_without_damping_the_peaks_are_infinite():
    assert [y for _, y in absorber.peaks(0.1, 0.9, 0.0)] == [np.inf, np.inf]
    assert absorber.variance(0.1, 0.9, 0.0) == np.inf
    with pytest.raises(sf.SceneError, match="must not be negative"):
        absorber.peaks(0.1, 0.9, -0.1)
