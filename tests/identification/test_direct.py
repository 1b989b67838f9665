"""Direct fits: the steady curve, the envelope of a decay."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf
from symfric.identification.decay import envelope

X, U = sp.symbols("x u", real=True)
MU_S, MU_K, V_S = sp.symbols("mu_s mu_k v_s", positive=True)
LAW = sf.laws.stribeck(MU_S, MU_K, V_S)
BOUNDS = {"mu_s": (0.1, 1.0), "mu_k": (0.1, 1.0), "v_s": (0.001, 1.0)}
V = np.concatenate([-np.geomspace(0.005, 1, 20), np.geomspace(0.005, 1, 20)])
TRUE = LAW.where({MU_S: 0.4, MU_K: 0.25, V_S: 0.1})
T = np.linspace(0, 100, 5001)


def friction(noise, seed=0):
    return 100 * TRUE(V) + noise * np.random.default_rng(seed).standard_normal(V.size)


def test_the_steady_curve():
    fit = sf.fit_curve(LAW, V, friction(1.0), BOUNDS, normal=100.0, static=[39.0, 41.0])
    for name, true in (("mu_s", 0.4), ("mu_k", 0.25), ("v_s", 0.1)):
        assert abs(fit.values[name] - true) < 3 * fit.standard_errors[name]
    assert fit.law(0.3) == pytest.approx(TRUE(0.3), abs=0.01)
    assert fit.sigma["friction"] == pytest.approx(1.0, rel=0.4)
    low, high = fit.profile("v_s").interval
    assert low < fit.values["v_s"] < high
    assert fit.plot().get_lines()
    with pytest.raises(sf.SceneError, match=r"fit\.law"):
        _ = fit.scene
    with pytest.raises(sf.SceneError, match=r"fit\.law"):
        sf.test_design(fit, {"v_b": [0.1]})


@pytest.mark.long(beside="test_the_steady_curve")
def test_standard_errors_of_the_curve_are_those_of_many_records():
    names, found = list(BOUNDS), []
    for seed in range(14):
        fit = sf.fit_curve(LAW, V, friction(1.0, seed), BOUNDS, normal=100.0, sigma=1.0)
        found.append([fit.values[n] for n in names])
    spread = np.std(found, axis=0)
    assert spread == pytest.approx([fit.standard_errors[n] for n in names], rel=0.5)


def test_two_lines_of_a_gear():
    """A law of two lines: the kink at a known speed, three values unknown."""
    a, b, c = sp.symbols("a b c", positive=True)
    law = sf.laws.piecewise_linear(a, [0.0, 0.2, 1.0], [a, b, c])
    v = np.linspace(0.02, 1.0, 40)
    y = np.interp(v, [0.0, 0.2, 1.0], [0.5, 0.3, 0.4]) + 0.002 * np.random.default_rng(0).standard_normal(40)
    fit = sf.fit_curve(law, v, y, {"a": (0.1, 1.0), "b": (0.1, 1.0), "c": (0.1, 1.0)})
    for name, true in (("a", 0.5), ("b", 0.3), ("c", 0.4)):
        assert abs(fit.values[name] - true) < 3.5 * fit.standard_errors[name]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"law": "stribeck"}, "no friction law"),
        ({"speed": V[:-1]}, "39 speeds and 40 values"),
        ({"speed": np.where(np.arange(40) == 3, 0.0, V)}, r"speed\[3\] is 0"),
        ({"friction": np.where(np.arange(40) == 3, np.nan, V)}, r"friction\[3\] is nan"),
        ({"speed": np.ones(40)}, "several speeds"),
        ({"speed": [], "friction": []}, "no points"),
        ({"parameters": {"mu_s": (0.1, 1)}}, "too; give its bounds"),
        ({"parameters": {**BOUNDS, "q": (0, 1)}}, "no symbol of the law"),
        ({"normal": -1.0}, "must be positive"),
        ({"sigma": [1.0, 2.0]}, "sigma has shape"),
        ({"speed": V[:2], "friction": V[:2]}, "2 points cannot fix 3"),
    ],
)
def test_bad_points(change, message):
    given = {"law": LAW, "speed": V, "friction": TRUE(V), "parameters": BOUNDS, **change}
    with pytest.raises(sf.SceneError, match=message):
        sf.fit_curve(**given)


def decaying(delta, zeta, kappa, omega=1.3):
    contacts = [sf.Contact("floor", U, omega**2, sf.laws.coulomb(delta))] if delta else []
    force = -(omega**2) * X - 2 * zeta * omega * U - kappa * U * sp.Abs(U)
    return sf.Scene(sf.System([X], [U], [[1]], [force]), contacts, {}, {X: 1.0, U: 0.0}, 100.0)


CASES = [(0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.03), (0.005, 0.01, 0.03)]


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("delta", "zeta", "kappa"), CASES)
def test_damping_from_the_envelope(delta, zeta, kappa):
    x = sf.simulate(decaying(delta, zeta, kappa), 1e-11)(T)[0]
    clean = sf.fit_decay(T, x)
    assert clean.values["delta"] == pytest.approx(delta, abs=1e-5)
    assert clean.values["zeta"] == pytest.approx(zeta, abs=3e-5)
    assert clean.values["kappa"] == pytest.approx(kappa, abs=5e-5)
    noisy = sf.fit_decay(T, x + 0.15 + 0.003 * np.random.default_rng(0).standard_normal(T.size))
    truth = {"delta": delta, "zeta": zeta, "kappa": kappa, "offset": 0.15}
    for name, true in truth.items():
        assert abs(noisy.values[name] - true) < 3 * noisy.standard_errors[name], name
    assert sf.simulate(noisy.scene).status == sf.Status.OK


def test_only_the_terms_given():
    x = sf.simulate(decaying(0.01, 0, 0), 1e-11)(T)[0]
    fit = sf.fit_decay(T, x, ["dry"])
    assert set(fit.values) == {"x0", "offset", "delta"}
    assert fit.values["delta"] == pytest.approx(0.01, abs=1e-6)  # the acceleration jumps at an extreme


def test_strong_damping_is_told_and_the_scene_fits_better():
    x = sf.simulate(decaying(0.02, 0.03, 0.05), 1e-11)(T)[0]
    noise = 0.002 * np.random.default_rng(0).standard_normal(T.size)
    rough = sf.fit_decay(T, x + noise)
    assert any("identify" in n for n in rough.notes)
    start = rough.records["extremes"][0][0]
    later = T[T >= start] - start
    wide = {"delta": (0.001, 0.1), "zeta": (0.0, 0.2), "kappa": (0.0, 0.3), "x0": (0.5, 1.2), "omega": (1.1, 1.5)}
    fine = sf.identify(rough.scene, {"x": (later, (x + noise)[T >= start])}, {**wide, "u": (-0.1, 0.1)}, starts=1)
    for name, true in (("delta", 0.02), ("zeta", 0.03), ("kappa", 0.05), ("omega", 1.3)):
        assert abs(fine.values[name] - true) < 3 * fine.standard_errors[name]
        assert fine.standard_errors[name] < rough.standard_errors.get(name, 1.0)


@pytest.mark.parametrize(
    "rates", [(0.01, 0.02, 0.03), (0.01, 0.0, 0.0), (0.0, 0.02, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.1)]
)
def test_the_envelope_solves_its_equation(rates):
    a, b, c = rates
    t = np.linspace(0, 20, 50)
    run = solve_ivp(lambda _, y: -(a + b * y + c * y**2), (0, 20), [1.0], t_eval=t, rtol=1e-11, atol=1e-13)
    value, slopes = envelope(t, 1.0, a, b, c)
    assert value == pytest.approx(run.y[0], abs=1e-9)
    for k in range(4):
        sides = []
        for way in (1e-6, -1e-6):
            given = [1.0, a, b, c]
            given[k] += way
            sides.append(envelope(t, *given)[0])
        assert slopes[:, k] == pytest.approx((sides[0] - sides[1]) / 2e-6, abs=1e-5)


@pytest.mark.parametrize(
    ("t", "x", "terms", "error", "message"),
    [
        (T, np.cos(T), "dry", sf.SceneError, "terms is 'dry'"),
        (T, np.cos(T), ["wet"], sf.SceneError, "some of 'dry'"),
        (T, np.zeros(T.size), ["dry"], sf.SceneError, "constant"),
        (T[::-1], np.cos(T), ["dry"], sf.SceneError, "order"),
        (T, np.random.default_rng(0).standard_normal(T.size), ["dry"], sf.NotFound, "swings"),
        (T[:200], np.cos(T[:200]), ["dry"], sf.NotFound, "swings"),
    ],
)
def test_bad_decays(t, x, terms, error, message):
    with pytest.raises(error, match=message):
        sf.fit_decay(t, x, terms)
