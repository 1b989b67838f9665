"""Fits of laws with memory to hysteresis loops."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf
from symfric.identification import loops

MU_C, SIGMA, MU_S, V_S, SIGMA1 = sp.symbols("mu_c sigma mu_s v_s sigma1", positive=True)
DAHL = sf.laws.dahl(MU_C, SIGMA)
BOUNDS = {"mu_c": (0.1, 1.0), "sigma": (100.0, 1e4)}
PHASE = np.linspace(0.0, 4 * np.pi, 401)
X = 1e-3 * np.sin(PHASE)


def noise(size, seed=0):
    return size * np.random.default_rng(seed).standard_normal(PHASE.size)


def modelled(law, names, values, x=X, t=None, closed=False):
    recurrence = loops._recurrence(law, names)
    t = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)))]) if t is None else t
    drive = loops._drive(x, t, recurrence.parts, closed)
    return recurrence.run(drive, np.array(values), x.size)


def test_the_loop_of_dahl_after_a_reversal():
    """From steady sliding one way to steady sliding the other, in closed form."""
    x = np.concatenate([np.linspace(0, 0.01, 200), np.linspace(0.01, 0.0, 200)])
    found, _ = modelled(DAHL, ("mu_c", "sigma"), [0.3, 2000.0], x)
    back = [-sf.theory.presliding.dahl_reversal(0.3, 2000.0, d) for d in 0.01 - x[200:]]
    assert found[200:] == pytest.approx(back, abs=1e-8)


def test_a_law_that_is_not_linear_in_its_state():
    law = sf.laws.dahl(MU_C, SIGMA, exponent=2)
    found, slopes = modelled(law, ("mu_c", "sigma"), [0.3, 2000.0])

    def rate(phase, mu):
        w = 1e-3 * np.cos(phase)
        return 2000.0 * w * (1 - mu / 0.3 * np.sign(w)) ** 2

    run = solve_ivp(rate, (0, PHASE[-1]), [0.0], t_eval=PHASE, rtol=1e-9, atol=1e-12, max_step=0.02)
    assert found == pytest.approx(run.y[0], abs=2e-4)  # the samples are joined by lines, the motion is not
    for k, step in enumerate((1e-6, 1e-2)):
        sides = [
            modelled(law, ("mu_c", "sigma"), np.array([0.3, 2000.0]) + w * step * np.eye(2)[k])[0] for w in (1, -1)
        ]
        assert slopes[:, k] == pytest.approx(
            (sides[0] - sides[1]) / (2 * step), abs=1e-6 * np.max(np.abs(slopes[:, k]))
        )


@pytest.mark.one_in(2)
@pytest.mark.parametrize("closed", [False, True])
def test_values_of_dahl_from_noisy_loops(closed):
    clean, _ = modelled(DAHL, ("mu_c", "sigma"), [0.3, 2000.0], closed=closed)
    fit = sf.fit_loop(DAHL, X, 100 * clean + noise(0.3), BOUNDS, normal=100.0, closed=closed)
    for name, true in (("mu_c", 0.3), ("sigma", 2000.0)):
        assert abs(fit.values[name] - true) < 3 * fit.standard_errors[name] < 0.01 * true
    assert fit.law.stiffness == pytest.approx(2000.0, rel=0.01)
    assert fit.sigma["friction"] == pytest.approx(0.3, rel=0.15)
    low, high = fit.profile("sigma").interval
    assert low < fit.values["sigma"] < high


def test_a_law_that_depends_on_the_speed_needs_times():
    law = sf.laws.lugre(MU_S, 0.25, V_S, SIGMA, 5.0)
    names, true = ("mu_s", "v_s", "sigma"), np.array([0.4, 0.002, 5000.0])
    t = PHASE / (2 * np.pi)
    clean, _ = modelled(law, names, true, t=t)
    bounds = {"mu_s": (0.2, 0.8), "v_s": (1e-4, 0.1), "sigma": (100.0, 1e5)}
    fit = sf.fit_loop(law, X, clean + noise(0.002), bounds, time=t)
    for name, value in zip(names, true, strict=True):
        assert abs(fit.values[name] - value) < 3 * fit.standard_errors[name]
    with pytest.raises(sf.SceneError, match="depends on the speed"):
        sf.fit_loop(law, X, clean, bounds)


def test_elements_of_maxwell_slip():
    """Springs and sliders are exact: first loading and Masing's branches are straight lines with known corners."""
    k = sp.symbols("k1 k2", positive=True)
    most = sp.symbols("l1 l2", positive=True)
    law = sf.laws.maxwell_slip(list(k), list(most))
    names, true = ("k1", "k2", "l1", "l2"), np.array([300.0, 150.0, 0.05, 0.1])
    x = np.concatenate([np.linspace(0, 1e-3, 101), np.linspace(1e-3, -1e-3, 201)[1:]])
    found, _ = modelled(law, names, true, x)
    first = np.minimum(300 * x[:101], 0.05) + np.minimum(150 * x[:101], 0.1)
    assert found[:101] == pytest.approx(first, abs=1e-12)
    half = (x[100] - x[100:]) / 2
    branch = first[-1] - 2 * (np.minimum(300 * half, 0.05) + np.minimum(150 * half, 0.1))
    assert found[100:] == pytest.approx(branch, abs=1e-12)
    varied = X * (1 + 0.3 * np.sin(0.37 * PHASE))
    clean, _ = modelled(law, names, true, varied)
    bounds = {"k1": (150.0, 1000.0), "k2": (20.0, 400.0), "l1": (0.01, 0.3), "l2": (0.01, 0.3)}
    fit = sf.fit_loop(law, varied, clean + noise(0.001), bounds)
    for name, value in zip(names, true, strict=True):
        assert abs(fit.values[name] - value) < 3 * fit.standard_errors[name] < 0.02 * value


def test_bouc_and_wen():
    alpha, beta, gamma = sp.symbols("alpha beta gamma", positive=True)
    law = sf.laws.bouc_wen(alpha, beta, gamma, 2)
    names, true = ("alpha", "beta", "gamma"), np.array([1000.0, 8000.0, 3000.0])
    x = X[::2] * (1 + 0.3 * np.sin(0.37 * PHASE[::2]))
    clean, _ = modelled(law, names, true, x)
    bounds = {"alpha": (100.0, 5000.0), "beta": (100.0, 5e4), "gamma": (-5e3, 2e4)}
    fit = sf.fit_loop(law, x, clean + noise(0.002)[: x.size], bounds)
    for name, value in zip(names, true, strict=True):
        assert abs(fit.values[name] - value) < 3 * fit.standard_errors[name]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"law": sf.laws.coulomb(MU_C)}, "no memory"),
        ({"displacement": X[:-1]}, "400 displacements and 401"),
        ({"displacement": X[:2], "friction": X[:2]}, "2 samples"),
        ({"friction": np.where(PHASE == 0, np.nan, X)}, r"friction\[0\] is nan"),
        ({"displacement": np.zeros(401)}, "displacement is constant"),
        ({"parameters": {"mu_c": (0.1, 1.0)}}, "symbol sigma too"),
        ({"parameters": {**BOUNDS, "q": (0, 1)}}, "q is no symbol"),
        ({"normal": 0.0}, "positive"),
        ({"time": -PHASE}, "not finite and increasing"),
        ({"time": PHASE[:-1]}, "400 times"),
        ({"sigma": -1.0}, "sigma is not positive"),
    ],
)
def test_bad_loops(change, message):
    given = {"law": DAHL, "displacement": X, "friction": X, "parameters": BOUNDS, **change}
    with pytest.raises(sf.SceneError, match=message):
        sf.fit_loop(**given)
