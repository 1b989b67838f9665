"""Limits of a quench: closed forms of Coulomb and of the cubic law, dense grids, and what is said where none fits."""

import re

import numpy as np
import pytest
from scipy.optimize import brentq

import symfric as sf
from symfric.design import quench

CUBIC = sf.scenes.mass_on_belt(sf.laws.cubic(0.4, 0.25, 0.5), v_b=0.2)
GAUSS = sf.scenes.mass_on_belt(sf.laws.gauss(0.4, 0.1), v_b=0.2, beta=0.01)
COULOMB = sf.scenes.mass_on_belt(sf.laws.coulomb(0.4), v_b=0.2, beta=0.05)
WIDE = {"speeds": (0.1, 0.4), "Omega": (20.0, 60.0), "a": (0.0, 0.05)}
LAWS = {
    "cubic": (CUBIC, 0.05, lambda w: 0.4 - 0.225 * (2 * w - 8 * w**3 / 3), lambda w: -0.45 + 1.8 * w**2),
    "gauss": (GAUSS, 0.01, lambda w: 0.4 * np.exp(-100 * w**2), lambda w: -80 * w * np.exp(-100 * w**2)),
}
SHARES = (np.arange(300) + 0.5) / 300


def intensity(design):
    """Intensity a Omega of a design."""
    return design.values["a"] * design.values["Omega"]


def cubic_share(v, q):
    """Thomsen (41) for the numbers of `CUBIC`, inside and outside, over the law."""
    mu = lambda w: 0.4 - 0.45 * w + 0.6 * w**3  # noqa: E731
    if q <= v:
        return (mu(v) + 0.9 * v * q**2) / mu(v)
    return (0.8 / np.pi * np.arcsin(v / q) - 0.45 * v + 0.6 * (v**3 + 1.5 * v * q**2)) / mu(v)


def misses(message):
    """Return the numbers by which limits are missed."""
    return [float(e) for e in re.findall(r"by ([0-9.e+-]+[0-9])", message)]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("share", [0.18, 0.2])
def test_a_share_of_the_friction_asks_for_more_shaking_with_the_cubic_law(share):
    """Beyond the speed of least friction it rises again, and with it what strong shaking leaves."""
    found = quench(CUBIC, **WIDE, limits={"friction": share})
    expected = brentq(lambda q: cubic_share(0.1, q) - share, 0.6, 2.0, xtol=1e-15)
    assert intensity(found) == pytest.approx(expected, abs=1e-8)
    assert found.active[0] == "limit on the friction at v_b = 0.1"
    assert found.check.agrees


def test_friction_that_the_excitation_does_not_touch():
    """Faster than the fast motion the cubic law rubs more than without: the limit of 1 binds nothing."""
    v = 0.42
    found = quench(CUBIC, (v, v), Omega=(20, 60), a=(0, 0.05), limits={"friction": 1.0})
    free = quench(CUBIC, (v, v), Omega=(20, 60), a=(0, 0.05))
    assert found.values == free.values
    assert found.active == free.active


@pytest.mark.long(beside="test_no_friction_no_share_of_it")
def test_constant_friction_inside_and_its_power():
    """(2/pi) asin(v/q) is left, and c q^2/2 + (2/pi) N mu sqrt(q^2 - v^2) is spent; q is the fastest belt's speed."""
    bounds = {"speeds": (0.1, 0.3), "Omega": (20, 60), "a": (0, 0.05), "margin": 0.5}
    left = 2 / np.pi * np.arcsin(1 / 3)
    power = 0.05 * 0.09 + 0.8 / np.pi * np.sqrt(0.08)
    found = quench(COULOMB, **bounds, limits={"friction": left - 1e-6, "power": power + 1e-6})
    assert intensity(found) == pytest.approx(0.3, abs=1e-8)
    assert found.status == "infimum"
    with pytest.raises(sf.NotFound, match=r"of the friction at v_b = 0\.1, short of 0\.3 by") as error:
        quench(COULOMB, **bounds, limits={"friction": 0.3})
    assert misses(str(error.value)) == pytest.approx([0.3 - left], abs=1e-8)
    with pytest.raises(sf.NotFound, match=r"its mean power 0\.0\d+ at v_b = 0\.1 is above the limit 0\.05 by") as error:
        quench(COULOMB, **bounds, limits={"power": 0.05})
    assert misses(str(error.value)) == pytest.approx([power - 0.05], abs=1e-8)


@pytest.mark.long(beside="test_no_point_of_a_dense_grid_is_better")
def test_acceleration_couples_amplitude_and_frequency():
    """At a = .01 the intensity of (56) needs the frequency a Omega/.01, so the acceleration its square over .01."""
    needed = sf.theory.belt.quench_intensity(CUBIC)
    bounds = {"speeds": (0.1, 1.0), "Omega": (20, 60), "a": (0, 0.01)}
    just = quench(CUBIC, **bounds, limits={"acceleration": 100 * needed**2 * (1 + 1e-12)})
    assert intensity(just) == pytest.approx(needed, abs=1e-8)
    assert "limit on the acceleration" in just.active
    with pytest.raises(
        sf.NotFound, match="its acceleration .* above the limit 12 by .*, and it leaves .* short of"
    ) as e:
        quench(CUBIC, **bounds, limits={"acceleration": 12.0, "friction": 0.5})
    expected = [100 * needed**2 - 12, 0.5 - cubic_share(0.1, needed)]
    assert misses(str(e.value)) == pytest.approx(expected, abs=1e-8)


def test_what_bounds_and_limits_exclude_is_told_apart():
    with pytest.raises(sf.NotFound, match="leaves the damping at v_b"):
        quench(CUBIC, (0.1, 1.0), Omega=(20, 30), a=(0, 0.01), limits={"acceleration": 3.0})
    with pytest.raises(sf.NotFound, match=r"above the limit 1 by 6\.200"):
        quench(CUBIC, (0.1, 1.0), Omega=(20, 60), a=(0.012, 0.05), margin=0.0, limits={"acceleration": 1.0, "power": 9})


def test_the_full_model_keeps_the_limits_as_averaging_says():
    """Measured over whole periods of the forced vibration; what averaging misses falls with Omega squared."""
    errors = []
    for Omega in (20.0, 40.0):
        limits = {"friction": 0.1, "power": 0.9}
        found = quench(CUBIC, (0.1, 0.4), Omega=(Omega, Omega), a=(0, 0.05), limits=limits)
        assert found.check.agrees
        share, power = found.check.limits
        assert (share.quantity, power.quantity) == ("share of the friction at v_b = 0.1", "mean power at v_b = 0.1")
        assert share.predicted == pytest.approx(cubic_share(0.1, intensity(found)), abs=1e-8)
        errors.append([abs(r.computed / r.predicted - 1) for r in (share, power)])
    assert np.log2(np.divide(*errors)) == pytest.approx([2.0, 2.0], abs=0.1)
    assert found.check.to_dict()["limits"][0]["agrees"]
    assert "share of the friction at v_b = 0.1: 0.1095" in str(found.check)


def grid_values(name, speeds, q):
    """Least damping, largest power and least share of the friction over belt speeds, by the midpoint rule."""
    _, beta, mu, slope = LAWS[name]
    v = np.unique(np.append(np.linspace(*speeds, 60), np.clip(q * (1 + 1e-9), *speeds)))
    split = np.arccos(np.clip(v / q, -1, 1))[:, None]
    total = 0
    for low, width in ((0.0, split), (split, np.pi - split)):
        fast = q * np.cos(low + width * SHARES)
        w = v[:, None] - fast
        parts = slope(abs(w)), -fast * np.sign(w) * mu(abs(w)), np.sign(w) * mu(abs(w))
        total = total + np.array([(e * width / np.pi).mean(axis=1) for e in parts])
    inside = v < q
    jump = np.where(inside, 2 * mu(0.0) / np.pi / np.sqrt(np.where(inside, q**2 - v**2, 1.0)), 0.0)
    return (2 * beta + total[0] + jump).min(), (total[1] + beta * q**2).max(), (total[2] / mu(v)).min()


CASES = [
    ("cubic", "power", {"friction": 0.19, "acceleration": 40.0}, "limit on the friction"),
    ("cubic", "force", {"friction": 0.15, "power": 0.5, "acceleration": 30.0}, "limit on the friction"),
    ("gauss", "power", {"acceleration": 8.0}, "damping"),  # strong shaking spends less, and is excluded
    ("gauss", "intensity", {"power": 0.006}, "damping"),  # weak shaking spends more
]


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("name", "minimise", "limits", "active"), CASES)
def test_no_point_of_a_dense_grid_is_better(name, minimise, limits, active):
    speeds = {"cubic": (0.1, 0.4), "gauss": (0.02, 0.05)}[name]
    found = quench(LAWS[name][0], speeds, Omega=(20, 60), a=(0.0, 0.05), minimise=minimise, limits=limits)
    q = np.unique(np.append(np.linspace(0.01, 3.0, 300), intensity(found) * (1 + np.array([1e-5, -1e-3]))))
    force = q * np.maximum(20.0, q / 0.05)
    damping, power, share = np.array([grid_values(name, speeds, e) for e in q]).T
    good = damping >= 1e-4
    for kind, limit in limits.items():
        good &= {"friction": share >= limit, "power": power <= limit, "acceleration": force <= limit}[kind]
    cost = {"intensity": q, "power": power, "force": force}[minimise]
    assert np.min(cost[good], initial=np.inf) >= found.objective - 1e-5
    damping, power, share = grid_values(name, speeds, intensity(found) * (1 + 1e-7))
    assert damping >= -1e-4
    assert power <= limits.get("power", np.inf) + 1e-5
    assert share >= limits.get("friction", -np.inf) - 1e-4
    assert found.values["a"] * found.values["Omega"] ** 2 <= limits.get("acceleration", np.inf) * (1 + 1e-9)
    assert any(active in words for words in found.active)


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"frction": 0.5}, "no limit 'frction'; did you mean friction"),
        ({"friction": 1.5}, "at most 1"),
        ({"friction": 0}, "must be positive"),
        ({"power": "much"}, "the limit on the power"),
        ({"acceleration": float("inf")}, "finite"),
        ([("friction", 0.5)], "write a dict"),
    ],
)
def test_bad_limits(limits, message):
    with pytest.raises(sf.SceneError, match=message):
        quench(CUBIC, **WIDE, limits=limits)


def test_no_friction_no_share_of_it():
    smooth = sf.scenes.mass_on_belt(sf.laws.piecewise_linear(0.4, [0, 0.2, 0.5], [0.4, 0.0, 0.3]), v_b=0.2)
    with pytest.raises(sf.SceneError, match=r"there is no friction at v_b = 0\.2"):
        quench(smooth, (0.2, 0.4), Omega=(20, 60), a=(0, 0.05), limits={"friction": 0.1})
    with pytest.raises(sf.NotFound, match=r"it leaves 0 of the friction at v_b = 0, short of 0\.1 by 0\.1"):
        quench(CUBIC, (0.0, 0.4), Omega=(20, 60), a=(0, 0.05), limits={"friction": 0.1})
