"""Laws compared on one record, and experiments chosen."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer

X, U = sp.symbols("x u", real=True)
MU_S, MU_K, V_S, V_B = sp.symbols("mu_s mu_k v_s v_b", positive=True)
T = np.linspace(0.0, 96.0, 301)[1:]
BOUNDS = {"mu_s": (0.1, 0.8), "mu_k": (0.05, 0.6), "v_s": (1e-2, 1.0)}
NUMBERS = {MU_S: 0.4, MU_K: 0.25, V_S: 0.1, V_B: 0.2}


def rig(law, **values):
    belt = sf.Contact("belt", U - V_B, 1, law)
    used = {s: v for s, v in NUMBERS.items() if s in law.free_symbols | {V_B}}
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X - U / 20]), [belt], used, {X: 0.0, U: 0.0}, 96.0)
    return scene.where(values) if values else scene


STRIBECK, LORENTZ = rig(sf.laws.stribeck(MU_S, MU_K, V_S)), rig(sf.laws.lorentz(MU_K, V_S, MU_S))
COULOMB = rig(sf.laws.coulomb(MU_S, MU_K))


def measured(scene, noise=0.01, t=T):
    return {"x": (t, sf.simulate(scene, 1e-11)(t)[0] + noise * np.random.default_rng(1).standard_normal(t.size))}


@pytest.mark.one_in(2)
@pytest.mark.parametrize("starts", longer([2, 4], [4]))
@pytest.mark.parametrize("sigma", [None, 0.01])
def test_the_law_that_made_the_record_is_the_best(sigma, starts):
    scenes = {"coulomb": COULOMB, "stribeck": STRIBECK, "lorentz": LORENTZ}
    found = sf.compare_laws(scenes, measured(STRIBECK), BOUNDS, sigma=sigma, starts=starts)
    assert found.best.name == "stribeck"
    assert found.notes == ()
    errors = {s.name: s.error for s in found}
    assert min(errors, key=errors.get) == "stribeck"
    assert errors["stribeck"] == pytest.approx(0.01 if sigma is None else 1.0, rel=0.2)
    # by hand: n log(S/n) + 2 k + 2 k (k + 1)/(n - k - 1), the variance counted among the k unless it is known
    score = found["coulomb"]
    s, n, k = float(np.sum(score.fit.residuals["x"] ** 2)), 300, 2 + (sigma is None)
    deviance = n * np.log(s / n) if sigma is None else s / sigma**2
    assert score.aicc == pytest.approx(deviance + 2 * k + 2 * k * (k + 1) / (n - k - 1))
    assert score.bic == pytest.approx(deviance + k * np.log(n))
    assert found.to_xarray()["delta AICc"].values[0] == 0.0
    assert "stribeck" in str(found)
    assert len(found.to_dict()["laws"]) == len(found) == 3


@pytest.mark.long(beside="test_the_law_that_made_the_record_is_the_best")
def test_laws_that_a_record_does_not_tell_apart():
    fast = {n: s.where({"v_b": 0.2}) for n, s in {"stribeck": STRIBECK, "lorentz": LORENTZ}.items()}
    with pytest.warns(UserWarning, match="do not tell"):
        found = sf.compare_laws(fast, measured(fast["stribeck"], noise=0.3), BOUNDS, starts=2)
    assert len(found.notes) == 1


def test_bad_comparisons():
    record = measured(STRIBECK)
    for scenes, parameters, message in (
        ({}, BOUNDS, "no mapping"),
        ({"a": COULOMB}, {}, "must name"),
        ({"a": COULOMB}, {"v_s": (0.1, 1.0)}, "none of the scenes"),
        ({"a": COULOMB}, {"b": {"mu_s": (0.1, 0.8)}}, "names the law"),
        ({"a": COULOMB, "b": STRIBECK}, {"b": {"mu_s": (0.1, 0.8)}}, "no unknowns for"),
    ):
        with pytest.raises(sf.SceneError, match=message):
            sf.compare_laws(scenes, record, parameters)
    with pytest.raises(sf.SceneError, match="folds"):
        sf.compare_laws({"a": COULOMB}, record, BOUNDS, folds=1)


def test_the_chosen_speed_is_that_which_fixes_most():
    fit = sf.identify(STRIBECK, measured(STRIBECK), BOUNDS, sigma=0.01, starts=2)
    speeds = [0.05, 0.1, 0.2, 0.35, 0.5]
    found = sf.test_design(fit, {"v_b": speeds}, number=2)
    assert len(found.chosen) == len(found.standard_errors) == 2
    (best,) = found.chosen[0].values()
    assert best == speeds[int(np.argmax(found.gains))]
    # a fit to both records has the standard errors that were promised
    scenes = {"first": STRIBECK, "second": STRIBECK.where({"v_b": best})}
    records = {"first": measured(STRIBECK), "second": measured(scenes["second"])}
    both = sf.identify(scenes, records, BOUNDS, sigma=0.01, starts=2)
    for name, error in found.standard_errors[0].items():
        assert both.standard_errors[name] == pytest.approx(error, rel=0.25)
    for settings, message in (({}, "settings"), ({"mu_s": [0.3]}, "unknown of the fit"), ({"q": [1]}, "no parameter")):
        with pytest.raises(sf.SceneError, match=message):
            sf.test_design(fit, settings)
