"""Isolators for a set of motions: limits met exactly, beaten by no point of a grid, and honest where they cannot be."""

from functools import cache

import numpy as np
import pytest

import symfric as sf
from symfric.design import isolator

BOUNDS = {"C": (1e3, 1e6), "mu": (0.001, 0.1)}


@cache  # made by the first test that takes them: every worker imports this file
def motions():
    return [sf.motions.synthetic(seed=k, pga=0.3, unit="g") for k in (0, 2, 4)]


@cache
def scene():
    return sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=motions()[0], profile=0.01)


@pytest.fixture(scope="module")
def limited():
    return isolator(scene(), motions(), BOUNDS, {"displacement": 0.12, "residual": 0.03})


@cache
def program(motion):
    return sf.prepare(sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=motion, profile=0.01))


def peaks(C, mu, motion):
    found = program(motion).run({"C": C, "mu": mu})
    return found["peak_acceleration"], found["peak_displacement"], abs(found["residual"])


def test_limits_hold_and_one_is_active(limited):
    table = np.array([peaks(limited.values["C"], limited.values["mu"], m) for m in motions()])
    assert table[:, 0].max() == pytest.approx(limited.objective, rel=1e-9)
    assert table[:, 1].max() <= 0.12 * (1 + 1e-8)
    assert table[:, 2].max() <= 0.03 * (1 + 1e-8)
    assert limited.check.agrees
    reached = {"displacement limit": table[:, 1].max() / 0.12, "residual limit": table[:, 2].max() / 0.03}
    tight = {name for name, share in reached.items() if share > 1 - 1e-6}
    assert tight == {a for a in limited.active if a.endswith("limit")} != set()


def test_no_point_of_a_dense_grid_is_better(limited):
    """Another grid than the one inside, at random places."""
    rng = np.random.default_rng(7)
    for C, mu in zip(rng.uniform(1e3, 1e6, 400), rng.uniform(0.001, 0.1, 400), strict=True):
        table = np.array([peaks(C, mu, m) for m in motions()])
        if table[:, 0].max() < limited.objective * (1 - 1e-6):
            assert table[:, 1].max() > 0.12 or table[:, 2].max() > 0.03


def test_the_mean_over_the_motions():
    found = isolator(scene(), motions(), BOUNDS, {"displacement": 0.2}, over="mean")
    C, mu = found.values["C"], found.values["mu"]
    mean = np.mean([peaks(C, mu, m)[0] for m in motions()])
    assert found.objective == pytest.approx(mean, rel=1e-9)
    for share in (0.97, 1.03):
        beside = np.array([peaks(max(C * share, BOUNDS["C"][0]), mu, m) for m in motions()])
        assert beside[:, 0].mean() > mean * (1 - 1e-9) or beside[:, 1].max() > 0.2


def test_the_trade_off_falls(limited):
    assert np.all(np.diff(limited.curve.x) > 0)
    assert np.all(np.diff(limited.curve.y) < 0)
    assert limited.plot().get_xlabel() == "peak displacement allowed"


def test_what_cannot_be_met():
    with pytest.raises(sf.NotFound, match=r"the limit on acceleration, 1e-06, cannot be met within the bounds"):
        isolator(scene(), motions()[:1], BOUNDS, {"acceleration": 1e-6}, minimise="displacement")


def test_errors():
    with pytest.raises(sf.SceneError, match="did you mean displacement"):
        isolator(scene(), motions(), BOUNDS, {"displacment": 0.1})
    with pytest.raises(sf.SceneError, match="known|did you mean"):
        isolator(scene(), motions(), {"c": (0.0, 1.0)})
    with pytest.raises(sf.SceneError, match="give at least one"):
        isolator(scene(), [], BOUNDS)
    with pytest.raises(sf.SceneError, match="sampled inputs"):
        isolator(sf.scenes.mass_on_belt(v_b=0.2), motions(), {"beta": (0.0, 1.0)})
