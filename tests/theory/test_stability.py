"""Verdicts on linearised sliding against eigenvalues, and the Routh-Hurwitz criterion against both."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.theory.averaging import average
from symfric.theory.equilibrium import equilibrium
from symfric.theory.hurwitz import (
    characteristic_coefficients,
    routh_hurwitz,
    symbolic_hurwitz,
    symbolic_hurwitz_of_matrices,
)
from symfric.theory.stability import judge, stability, stability_of_matrices


def linear_scene(M, B, K):
    n = len(M)
    q, u = sp.symbols(f"q0:{n}", real=True), sp.symbols(f"u0:{n}", real=True)
    force = -sp.Matrix(B) * sp.Matrix(u) - sp.Matrix(K) * sp.Matrix(q)
    system = sf.System(q=q, u=u, mass=sp.Matrix(M), force=list(force))
    return sf.Scene(system=system, initial=dict.fromkeys((*q, *u), 0.0), horizon=1.0)


def random_mass(rng, n):
    root = rng.standard_normal((n, n))
    mass = root @ root.T + n * np.eye(n)
    return (mass + mass.T) / 2


def test_belt_matrices():
    found = stability(sf.scenes.mass_on_belt(v_b=0.2))
    assert found.M.tolist() == [[1.0]]
    assert found.B[0, 0] == pytest.approx(-0.278, rel=1e-14)
    assert found.K.tolist() == [[1.0]]
    assert found.definiteness == "unstable"
    assert not found.stable
    assert found.margin == pytest.approx(-0.139, rel=1e-13)
    assert not found.hurwitz.stable
    assert found.eigenvalues[0] == pytest.approx(0.139 + 1j * np.sqrt(1 - 0.139**2), rel=1e-13)
    fast = stability(sf.scenes.mass_on_belt(v_b=0.5))
    assert (fast.definiteness, fast.stable, fast.hurwitz.stable) == ("stable", True, True)


def test_slow_motion_beside_a_fast_one():
    """Strong damping: B = 2 beta + gamma2 mu'(v_b) is of order 1e10, and the slow eigenvalue -1/B."""
    found = stability(sf.scenes.mass_on_belt(v_b=1e5))
    assert found.stable
    assert found.margin == pytest.approx(1 / found.B[0, 0], rel=1e-12)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("n", [1, 2, 3])
def test_verdicts_never_contradict_the_eigenvalues(n):
    rng = np.random.default_rng(n)
    seen = set()
    for _ in range(60):
        M, root = random_mass(rng, n), rng.standard_normal((n, n))
        B, K = rng.standard_normal((n, n)), root + root.T
        if rng.random() < 0.5:
            B, K = B @ B.T + 0.1 * np.eye(n), root @ root.T + 0.1 * np.eye(n)
        if rng.random() < 0.3:
            K = K + rng.standard_normal((n, n))
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, B)]])
        growth = np.max(np.linalg.eigvals(A).real)
        verdict, reason = judge(M, B, K)
        seen.add(verdict)
        assert reason
        if verdict == "stable":
            assert growth < 0
        if verdict == "unstable":
            assert growth > 0
        if abs(growth) > 1e-9:
            assert routh_hurwitz(characteristic_coefficients(A)).stable == (growth < 0)
    assert {"stable", "unstable"} <= seen


def test_hurwitz_on_larger_random_matrices():
    rng = np.random.default_rng(8)
    for n in (5, 9, 16):
        for shift in (1.05, 0.95):
            A = rng.standard_normal((n, n))
            A -= shift * np.max(np.linalg.eigvals(A).real) * np.eye(n)
            found = routh_hurwitz(characteristic_coefficients(A))
            assert found.stable == (shift > 1)
            assert len(found.determinants) == n
            assert found.coefficients[-1] == pytest.approx(np.linalg.det(-A), rel=1e-9)


def test_hurwitz_determinants_of_a_quartic():
    found = routh_hurwitz([1, 2, 3, 4, 5])
    assert found.determinants == pytest.approx((2, 2, -12, -60))
    assert not found.stable
    assert routh_hurwitz([-1, -2, -1]).stable
    with pytest.raises(sf.SceneError, match="leading coefficient"):
        routh_hurwitz([0, 1])


@pytest.mark.parametrize(
    ("B", "K", "verdict", "words"),
    [
        ([[0.2, 0], [0, 0.1]], [[2, -1], [-1, 2]], "stable", "positive definite"),
        ([[0.2, 5], [-5, 0.1]], [[2, -1], [-1, 2]], "stable", "symmetric part of B"),
        ([[0.2, 0], [0, 0.1]], [[2, -1.5], [1.5, 2.1]], "undecided", "circulatory"),
        ([[0.2, 0], [0, 0.0]], [[2, -1], [-1, 2]], "undecided", "semidefinite"),
        ([[0.4, 0], [0, -0.1]], [[2, -1], [-1, 2]], "undecided", "indefinite"),
        ([[0.1, 0], [0, -0.3]], [[2, -1], [-1, 2]], "unstable", "tr"),
        ([[0.2, 0], [0, 0.1]], [[2, 3], [3, 2]], "unstable", "det K"),
        ([[0.2, 0], [0, 0.1]], [[-2, 0], [0, -2]], "unstable", "negative eigenvalue"),
        ([[0.0, 3.0], [-3.0, 0.0]], [[-2, 0], [0, -2]], "undecided", "not positive definite"),
        ([[0.2, 0], [0, 0.1]], [[1, -1], [-1, 1]], "undecided", "not positive definite"),
    ],
)
def test_reasons(B, K, verdict, words):
    found = stability(linear_scene(np.diag([1.0, 2.0]), B, K))
    assert (found.definiteness, words in found.reason) == (verdict, True)
    if verdict != "undecided":
        assert found.stable == (verdict == "stable")


def test_circulatory_instability_is_seen_by_eigenvalues_only():
    """Mode coupling: friction with a load that follows another coordinate makes K unsymmetric."""
    x, y, u, w = sp.symbols("x y u w", real=True)
    mu = sp.Symbol("mu", positive=True)
    system = sf.System(q=[x, y], u=[u, w], mass=sp.eye(2), force=[-2 * x + y - 0.01 * u, x - 2 * y - 0.01 * w])
    contact = sf.Contact("disc", slip=u + 1, normal=10 + y, law=sf.laws.coulomb(mu))
    zero = dict.fromkeys((x, y, u, w), 0.0)
    scene = sf.Scene(system=system, contacts=[contact], values={mu: 1.5}, initial=zero, horizon=1.0)
    found = stability(scene)
    assert found.K.tolist() == [[2.0, 0.5], [-1.0, 2.0]]
    assert found.definiteness == "undecided"
    assert not found.stable
    assert stability(scene.where({mu: 0.5})).stable


def test_statespace_matches_the_matrices():
    found = stability(linear_scene(np.diag([1.0, 2.0]), np.diag([0.2, 0.1]), [[2, -1], [-1, 2]]))
    plant = found.statespace
    assert plant.state_labels == ["q0", "q1", "u0", "u1"]
    assert plant.input_labels == ["force_q0", "force_q1"]
    assert plant.output_labels == ["q0", "q1"]
    s = 0.3 + 0.7j
    expected = np.linalg.inv(s**2 * found.M + s * found.B + found.K)
    assert plant(s) == pytest.approx(expected, rel=1e-12)
    assert found.eigenvalues[0].real == pytest.approx(-found.margin)


def test_first_order_states_enter_the_state_matrix():
    x, u, z = sp.symbols("x u z", real=True)
    gain = sp.Symbol("gain", real=True)
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[-x - gain * z], z=[z], z_rate=[u - z])
    scene = sf.Scene(system=system, values={gain: 0.5}, initial={x: 0.0, u: 0.0, z: 0.0}, horizon=1.0)
    found = stability(scene)
    assert np.sort_complex(found.eigenvalues) == pytest.approx(np.sort_complex(np.roots([1, 1, 1.5, 1])), rel=1e-12)
    assert found.definiteness == "undecided"
    assert found.stable
    assert found.hurwitz.coefficients == pytest.approx((1, 1, 1.5, 1))
    assert not stability(scene.where({gain: -0.5})).stable


def test_symbolic_determinants_of_the_belt():
    law = sf.laws.cubic(*sp.symbols("mu_s mu_m v_m", positive=True))
    scene = sf.scenes.mass_on_belt(law, v_b=0.2).where({"mu_s": 0.4, "mu_m": 0.25, "v_m": 0.5})
    first, second = symbolic_hurwitz(scene)
    assert sp.simplify(first - second) == 0  # K = M = 1
    assert float(first.subs(scene.values)) == pytest.approx(-0.278, rel=1e-13)
    numbers = stability(scene).hurwitz.determinants
    assert numbers == pytest.approx((-0.278, -0.278), rel=1e-13)


def test_symbolic_determinants_refuse_large_scenes():
    with pytest.raises(sf.SceneError, match="up to 4"):
        symbolic_hurwitz(linear_scene(np.eye(3), np.eye(3), np.eye(3)))


def test_results_become_datasets():
    scene = sf.scenes.mass_on_belt(v_b=0.42)
    found = stability(scene)
    assert float(found.to_xarray().B.sel(row="x", column="x")) == found.B[0, 0]
    assert float(equilibrium(scene).to_xarray().sliding.sel(contact="belt")) == -0.42
    flow = average(scene)
    assert flow.to_xarray().amplitudes.values.tolist() == flow.amplitudes.tolist()


def test_plot_returns_axes():
    import matplotlib as mpl

    mpl.use("Agg")
    scene = sf.scenes.mass_on_belt(v_b=0.42)
    for result, label in ((stability(scene), "real part"), (average(scene), "amplitude A")):
        axes = result.plot()
        assert axes.get_xlabel() == label


def test_gyroscopic_and_circulatory_parts_are_split_off():
    B, K = np.array([[0.3, 2.0], [-1.0, 0.2]]), np.array([[2.0, 0.7], [-0.1, 1.0]])
    found = stability_of_matrices(np.diag([1.0, 2.0]), B, K)
    assert found.damping + found.gyroscopic == pytest.approx(B, rel=1e-15)
    assert found.stiffness + found.circulatory == pytest.approx(K, rel=1e-15)
    assert np.array_equal(found.damping, found.damping.T)
    assert np.array_equal(found.gyroscopic, -found.gyroscopic.T)
    assert found.circulatory == pytest.approx(np.array([[0.0, 0.4], [-0.4, 0.0]]), rel=1e-15)
    assert found.to_dict()["circulatory"] == found.circulatory.tolist()
    assert float(found.to_xarray().gyroscopic.sel(row="q1", column="q2")) == 1.5
    assert found.definiteness == "undecided"
    mirrored = stability(linear_scene(np.diag([1.0, 2.0]), B, K))
    assert mirrored.eigenvalues == pytest.approx(found.eigenvalues, rel=1e-13)
    assert (mirrored.definiteness, mirrored.stable) == (found.definiteness, found.stable)
    for part in ("damping", "gyroscopic", "stiffness", "circulatory"):
        assert getattr(mirrored, part) == pytest.approx(getattr(found, part), abs=1e-15)


@pytest.mark.parametrize("gyroscopic", [0.0, 0.3, 40.0])
@pytest.mark.parametrize("circulatory", [0.0, 1e-3, 3.0])
def test_definiteness_speaks_only_where_the_theorem_holds(gyroscopic, circulatory):
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    B, K = np.diag([0.3, 0.2]) + gyroscopic * turn, np.array([[2.0, 0.5], [0.5, 1.0]]) + circulatory * turn
    found = stability_of_matrices(np.eye(2), B, K)
    assert found.definiteness == ("stable" if circulatory == 0 else "undecided")
    exact = np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-K, -B]])).real.max() < 0
    assert found.stable == exact == found.hurwitz.stable


def test_hurwitz_in_symbols_agrees_with_numbers_up_to_four_states():
    names = b, g, k, c = sp.symbols("b g k c", real=True)
    B, K = sp.Matrix([[b, g], [-g, 2 * b]]), sp.Matrix([[k, c], [-c, 1]])
    formulas = symbolic_hurwitz_of_matrices(sp.diag(1, 2), B, K)
    rng = np.random.default_rng(5)
    for _ in range(10):
        numbers = dict(zip(names, rng.standard_normal(4), strict=True))
        damping, stiffness = (np.array(e.subs(numbers), dtype=float) for e in (B, K))
        found = stability_of_matrices(np.diag([1.0, 2.0]), damping, stiffness).hurwitz
        lead = 2.0 ** np.arange(1, 5)  # the numeric polynomial begins with 1, the symbolic one with det M
        assert [float(f.subs(numbers)) for f in formulas] == pytest.approx(np.array(found.determinants) * lead)
    with pytest.raises(sf.SceneError, match="6 states"):
        symbolic_hurwitz_of_matrices(sp.eye(3), sp.eye(3), sp.eye(3))


@pytest.mark.parametrize(
    ("matrices", "message"),
    [
        (([[1.0, 0.0]], [[1.0]], [[1.0]]), r"M has shape \(1, 2\)"),
        (([[1.0]], np.eye(2), [[1.0]]), "1, 2 and 1 rows"),
        (([[-1.0]], [[1.0]], [[1.0]]), "positive definite"),
        (([[1.0, 0.5], [0.2, 1.0]], np.eye(2), np.eye(2)), "symmetric"),
        (([[1.0]], [[np.nan]], [[1.0]]), "B has an entry"),
        (([[1.0]], [["a"]], [[1.0]]), "B is no matrix"),
    ],
)
def test_bad_matrices_are_named(matrices, message):
    with pytest.raises(sf.SceneError, match=message):
        stability_of_matrices(*matrices)


def test_the_two_slides_between_the_sufficient_and_the_exact_limit():
    """The slope of friction that definiteness allows, and the one that eigenvalues allow."""
    limits = sf.theory.drive.slope_limits(r=0.5, zeta=2, s1=0.2, s2=0.3)
    slides = sf.scenes.two_slides(r=0.5, zeta=2.0, s1=0.2, s2=0.3, fc1=1.0, fs1=1.0)
    between = 0.5 * (limits.definite + limits.exact)
    for mu, definiteness, stable in (
        (-0.149, "stable", True),
        (between, "undecided", True),
        (-0.1801, "undecided", False),
    ):
        law = sf.laws.custom(1 + 2 * mu * (sf.SPEED - 1), 1 - 2 * mu)
        contact = sf.Contact("slides", slip=slides.contacts[0].slip, normal=1, law=law)
        values = {
            k: v for k, v in slides.values.items() if k in slides.system.mass.free_symbols or k.name in "s1 s2 zeta"
        }
        found = stability(sf.Scene(slides.system, [contact], values=values, initial=slides.initial, horizon=1.0))
        assert (found.definiteness, found.stable, found.hurwitz.stable) == (definiteness, stable, stable)
