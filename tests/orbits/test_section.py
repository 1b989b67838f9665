"""Poincare sections against closed forms, and what sampling would miss."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
K, W = sp.symbols("k w", positive=True)


def oscillator(force=-K * X, values=None, contacts=(), **changes):
    start = {"initial": {X: 1.0, U: 0.0}, "horizon": 100.0, **changes}
    return sf.Scene(
        sf.System(q=[X], u=[U], mass=[[1]], force=[force]), contacts, {K: 1.0} if values is None else values, **start
    )


@pytest.fixture(scope="module")
def cosine():
    return sf.simulate(oscillator(), 1e-15)


@pytest.mark.parametrize("route", ["exact", "taylor"])
def test_turning_points_of_a_coulomb_oscillator(route):
    """Each turn loses twice delta, and events of the run lie exactly on the section."""
    delta = 0.03
    found = sf.poincare(sf.simulate(sf.scenes.coulomb_oscillator(delta), 1e-15, route), U, direction=0)
    k = np.arange(1, 17)
    assert np.allclose(found["x"], (-1.0) ** k * (1 - 2 * delta * k), rtol=0, atol=1e-12)
    assert np.allclose(found.times, np.pi * k, rtol=1e-12)


def test_every_crossing_of_a_wavy_surface_is_found(cosine):
    """sin(40 cos t) = 1/2, up to a dozen times in one step of the run."""
    found = sf.poincare(cosine, sp.sin(40 * X), level=0.5, direction=0)
    turns = 2 * np.pi * np.arange(-7, 8)
    angles = np.concatenate([np.pi / 6 + turns, 5 * np.pi / 6 + turns])
    first = np.arccos(angles[np.abs(angles) < 40] / 40)
    times = np.sort(np.add.outer(2 * np.pi * np.arange(16), [*first, *(2 * np.pi - first)]).ravel())
    times = times[times <= 100]
    assert found.times.size == times.size > 15 * cosine.t.size
    assert np.allclose(found.times, times, rtol=0, atol=1e-12)
    assert np.allclose(found["x"], np.cos(times), rtol=0, atol=1e-12)
    nodes = np.sin(40 * cosine["x"]) - 0.5
    assert np.count_nonzero(nodes[:-1] * nodes[1:] < 0) < times.size / 20  # the negative test: what the nodes show


def test_two_crossings_beside_a_turning_point_are_two_and_a_near_miss_is_none(cosine):
    gap = 1e-9
    found = sf.poincare(cosine, X, level=1 - gap, direction=0, after=1.0)
    assert found.times.size == 30
    assert np.allclose(np.diff(found.times)[::2], 2 * np.arccos(1 - gap), rtol=1e-6)
    assert sf.poincare(cosine, X, level=1 + 1e-12, direction=0).times.size == 0


@pytest.mark.parametrize(("direction", "first"), [(1, 1.5 * np.pi), (-1, 0.5 * np.pi)])
def test_direction(cosine, direction, first):
    found = sf.poincare(cosine, "x", direction=direction)
    assert np.allclose(found.times, first + 2 * np.pi * np.arange(found.times.size), rtol=1e-13)
    late = sf.poincare(cosine, "x", direction=direction, after=50.0)
    assert np.array_equal(late.times, found.times[found.times >= 50])
    assert np.array_equal(late["u"], found["u"][found.times >= 50])


def test_a_motion_that_sticks_on_the_section_crosses_it_where_it_arrives():
    """The floor holds a forced mass twice in a period; every stop is a turning point of the coordinate."""
    floor = sf.Contact("floor", slip=U, normal=1, law=sf.laws.coulomb(0.5))
    scene = oscillator(-K * X + sp.cos(W * sf.TIME), {K: 1.0, W: 0.5}, [floor], initial={X: 0.0, U: 0.0})
    run = sf.simulate(scene)
    stops = np.array([e.t for e in run.events if e.kind == "stick"])
    found = sf.poincare(run, U, direction=0)
    assert found.times.size == stops.size > 10
    assert np.allclose(found.times, stops, rtol=1e-13)
    belt = sf.simulate(sf.scenes.mass_on_belt(v_b=0.2))
    assert belt.stats["events"] > 20
    assert sf.poincare(belt, sf.slip("belt"), direction=0).times.size == 0  # it sticks and falls behind again


@pytest.mark.parametrize("e", [1.0, 0.9])
def test_a_ball_turns_at_every_top_and_jumps_through_zero_at_every_impact(e):
    ground = sf.Contact("ground", None, sf.Unilateral(X, e))
    ball = sf.Scene(sf.System([X], [U], [[1]], [-1]), [ground], {}, {X: 2.0, U: 0.0}, 20.0)
    speeds = 2 * e ** np.arange(1, 40)  # after each impact, and the time to the top
    impacts = 2 + np.concatenate([[0], 2 * np.cumsum(speeds)[:-1]])
    tops = impacts + speeds
    falls, rises = (sf.poincare(ball, "u", direction=d) for d in (-1, 1))
    assert falls.times == pytest.approx(tops[tops < 20], abs=1e-9)
    assert falls["x"] == pytest.approx(0.5 * speeds[tops < 20] ** 2, abs=1e-9)
    assert rises.times == pytest.approx(impacts[impacts < 20], abs=1e-9)
    assert rises["u"] == pytest.approx(-speeds[impacts < 20] / e, abs=1e-9)  # before the impact
    assert sf.poincare(ball, "u", direction=0).times.size == np.sum(tops < 20) + np.sum(impacts < 20)


@pytest.mark.parametrize("direction", [1, -1])
def test_crossings_between_kicks_are_found(direction):
    scene = oscillator(-X, {}, horizon=20.0, resets=[sf.Reset(every=1.7, set={U: U + 1.5})])
    run = sf.simulate(scene)
    count, edges = 0, [0.0, *run.jumps, 20.0]
    for low, high in zip(edges, edges[1:], strict=False):
        inner = np.linspace(low, high, 20_001)[:-1] + 1e-12
        signs = np.sign(run(inner)[1])
        count += int(np.sum((signs[:-1] * signs[1:] < 0) & (signs[1:] == direction)))
    for t in run.jumps:
        before, after = run.before(t)[1], run(t)[1]
        count += before * after < 0 and np.sign(after) == direction
    assert sf.poincare(run, "u", direction=direction).times.size == count > 4


def test_forced_motion_once_in_a_period():
    """x'' + x'/2 + x = cos(w t) + sin(3 w t/2)/2, looked at every 4 pi/w."""
    c, w = 0.5, 0.8
    force = -K * X - c * U + sp.cos(W * sf.TIME) + sp.sin(3 * W * sf.TIME / 2) / 2
    scene = oscillator(force, {K: 1.0, W: w}, horizon=200.0)
    found = sf.poincare(scene, after=120.0, tolerance=1e-13)
    assert np.allclose(np.diff(found.times), 4 * np.pi / w)
    answer = lambda z: 1 / (1 - z**2 + 1j * c * z)  # noqa: E731
    one, other = answer(w), answer(1.5 * w) / 2
    x, u = one.real + other.imag, (1j * w * one).real + (1.5j * w * other).imag
    assert np.allclose(found.states, [[x], [u]], rtol=0, atol=1e-10)
    shifted = sf.poincare(scene, phase=0.25, after=120.0, tolerance=1e-13)
    turn = np.exp(1j * np.pi * np.array([1.0, 1.5]))  # a quarter of 4 pi/w
    assert np.allclose(shifted["x"], (one * turn[0]).real + (other * turn[1]).imag, rtol=0, atol=1e-10)


def test_largest_turning_point_is_the_maximum():
    x_max = sf.Max(X)
    run = sf.simulate(sf.scenes.mass_on_belt(v_b=0.2).wanting({"path": sf.Trajectory(), "x_max": x_max}))
    found = sf.poincare(run, "u", direction=-1)
    assert np.max(found["x"]) == pytest.approx(run["x_max"], rel=1e-13)
    assert found.to_xarray().x.shape == found.times.shape
    assert found.to_dict()["states"]["u"] == found["u"].tolist()


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda run: sf.poincare(run), "nothing depends on time; give a section"),
        (lambda run: sf.poincare(run, "y"), "'y' is no state"),
        (lambda run: sf.poincare(run, X + sp.Symbol("y")), "y in the section is neither a state nor a parameter"),
        (lambda run: sf.poincare(run, K), "holds no state"),
        (lambda run: sf.poincare(run, X, direction=2), "direction is 2"),
        (lambda run: sf.poincare(run, X, after=100.0), "after is 100"),
        (lambda run: sf.poincare(run, X, level=np.nan), "level is nan"),
        (lambda run: sf.poincare(run, sp.sqrt(X)), "not finite"),
        (lambda run: sf.poincare(run.t), "neither a run nor"),
        (lambda run: sf.poincare(sf.scenes.mass_on_belt(v_b=1.0, a=0.1, Omega=2.0), phase=1.0), "phase is 1"),
        (lambda run: sf.poincare(sf.simulate(oscillator().wanting({"end": sf.End()})), X), "no motion was kept"),
    ],
)
def test_wrong_input_is_one_line(cosine, ask, message):
    with pytest.raises(sf.SceneError, match=message):
        ask(cosine)
