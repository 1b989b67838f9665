"""Multiple shooting: pieces that join have the minimum and the covariance of one run, and get there from afar."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.identification.local_fit import Problem, minimise, polished
from symfric.identification.pieces import Pieces
from symfric.identification.prediction import Predictor
from symfric.identification.records import read_channels
from symfric.identification.shooting import join
from symfric.identification.unknowns import read_unknowns
from tests.identification.rigs import BOUNDS, T, U, X, rig

MU, C, F, OMEGA = sp.symbols("mu c F Omega", positive=True)


def shaken(omega=0.9):
    force = -X - U / 10 + F * sp.cos(OMEGA * sf.TIME)
    floor = sf.Contact("floor", U, 1, sf.laws.coulomb(MU))
    values = {MU: 0.1, F: 0.5, OMEGA: omega}
    return sf.Scene(sf.System([X], [U], [[1]], [force]), [floor], values, {X: 0.5, U: 0.0}, 40.0)


def measured(scene, t, noise=0.01, seed=0):
    return sf.simulate(scene, 1e-11)(t)[0] + noise * np.random.default_rng(seed).standard_normal(t.size)


def problem_of(scene, records, parameters):
    channels = read_channels({"": scene}, records, None, None)
    unknowns = read_unknowns(parameters, {"": scene}, channels)
    predictor = Predictor({"": scene}, channels, unknowns, 1e-11)
    y = np.concatenate([c.y for c in channels])
    return Problem(predictor, y, np.ones(y.size))


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("scene", "unknowns", "horizon"),
    [
        (rig(), BOUNDS, 96.0),
        (shaken(), {"mu": (0.02, 0.3), "F": (0.2, 1.0), "x": (0.2, 0.8), "x.offset": (-0.1, 0.1)}, 40.0),
    ],
    ids=["belt", "shaken, start and offset unknown"],
)
def test_pieces_that_join_have_minimum_and_covariance_of_one_run(scene, unknowns, horizon):
    t = np.linspace(0.0, horizon, 201)[1:]
    problem = problem_of(scene, {"x": (t, measured(scene, t))}, unknowns)
    start = np.array([0.9 * (scene.values.get(sp.Symbol(n, positive=True), 0.5)) for n in unknowns])
    start = np.clip(start, problem.predictor.unknowns.low + 1e-3, problem.predictor.unknowns.high - 1e-3)
    joined = join(problem, Pieces(problem.predictor, 5), start)
    one = polished(problem, minimise(problem, joined.values))
    assert joined.cost == pytest.approx(one.cost, rel=1e-4)
    at = problem.predictor.at(joined.values)
    assert joined.y == pytest.approx(at.y, abs=1e-6)
    spread = np.linalg.inv(at.slopes.T @ at.slopes)
    assert np.linalg.inv(joined.information.T @ joined.information) == pytest.approx(
        spread, rel=1e-3, abs=1e-6 * np.max(spread)
    )


def test_from_afar_where_one_run_ends_in_another_minimum():
    far = rig(mu_s=0.7, mu_k=0.55, v_s=0.4)
    record = {"x": (T, measured(rig(), T))}
    pieces = sf.identify(far, record, BOUNDS, starts=1, segments=8)
    for name, true in (("mu_s", 0.4), ("mu_k", 0.25), ("v_s", 0.1)):
        assert abs(pieces.values[name] - true) < 3 * pieces.standard_errors[name]
    whole = sf.identify(rig(), record, BOUNDS, starts=1)
    assert pieces.values == pytest.approx(whole.values, rel=1e-6)
    assert pieces.covariance == pytest.approx(whole.covariance, rel=1e-3, abs=1e-12)
    low, high = pieces.profile("mu_s").interval
    assert low < pieces.values["mu_s"] < high


def test_what_cannot_be_cut():
    t = np.linspace(0.1, 8.0, 50)
    w = sp.Symbol("w", real=True)
    driven = sf.Scene(
        sf.System([X], [U], [[1]], [-X + w]),
        [sf.Contact("floor", U, 1, sf.laws.coulomb(MU))],
        {MU: 0.1},
        {X: 1.0, U: 0.0},
        8.0,
        inputs={w: sf.Signal(np.sin(t), 0.2)},
    )
    with pytest.raises(sf.SceneError, match="sampled inputs"):
        sf.identify(driven, {"x": (t, np.sin(t))}, {"mu": (0.01, 0.3)}, segments=3)
    with pytest.raises(sf.SceneError, match="segments is 0"):
        sf.identify(rig(), {"x": (T, np.sin(T))}, BOUNDS, segments=0)


@pytest.mark.long(beside="test_from_afar_where_one_run_ends_in_another_minimum")
def test_a_chaotic_record():
    """Duffing's two wells with a little dry friction: errors grow by 1e9 over the record."""
    force = X - X**3 - C * U + F * sp.cos(sp.Rational(6, 5) * sf.TIME)
    gap = sf.Contact("guide", U, 1, sf.laws.coulomb(MU))
    true = {"mu": 0.005, "c": 0.2, "F": 0.3}
    numbers = {MU: 0.005, C: 0.2, F: 0.3}
    scene = sf.Scene(sf.System([X], [U], [[1]], [force]), [gap], numbers, {X: 1.0, U: 0.0}, 150.0)
    assert sf.lyapunov(scene, 1000.0).exponents[0] > 0.1
    t = np.linspace(0.0, 150.0, 1501)[1:]
    record = {"x": (t, measured(scene, t))}
    bounds = {"mu": (5e-4, 0.1), "c": (0.05, 0.5), "F": (0.1, 0.6)}
    far = scene.where({"mu": 0.03, "c": 0.3, "F": 0.4})
    found = sf.identify(far, record, bounds, starts=1, segments=30)
    assert found.sigma["x"] == pytest.approx(0.01, rel=0.1)
    for name, value in true.items():
        assert abs(found.values[name] - value) < 4 * found.standard_errors[name]
    assert sf.identify(far, record, bounds, starts=1).sigma["x"] > 0.1  # one run does not get there


@pytest.mark.parametrize("seen", ["x", "u"])
def test_pieces_begin_at_what_the_record_shows_whatever_the_values(seen):
    """Of ``x'' = -k x`` with k = 1, seen at uneven times; what no record shows is that of the run with the wrong k."""
    k = sp.Symbol("k", positive=True)
    scene = sf.Scene(sf.System([X], [U], [[1]], [-k * X]), [], {k: 1.0}, {X: 1.0, U: 0.0}, 12.0)
    t = np.sort(np.random.default_rng(4).uniform(0.0, 12.0, 400))
    problem = problem_of(scene, {seen: (t, np.cos(t) if seen == "x" else -np.sin(t))}, {"k": (0.5, 2.0)})
    x, u = Pieces(problem.predictor, 4).first_nodes(np.array([1.21])).reshape(-1, 2).T
    at = t[-1] / 4 * np.arange(1, 4)
    assert u == pytest.approx(-np.sin(at), abs=2e-3)
    assert x == pytest.approx(np.cos(at) if seen == "x" else np.cos(1.1 * at), abs=2e-4)
