"""Limit cycles against closed forms, long simulations, and differences of the map over a period."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve.status import early_end

X, U = sp.symbols("x u", real=True)
B, F = sp.symbols("b f", positive=True)
BELT = sf.scenes.mass_on_belt(v_b=0.2)


def shaken(b, f):
    """x'' + x = cos(b t) - f Sgn(x'): Den Hartog's forced oscillator."""
    system = sf.System([X], [U], [[1]], [-X + sp.cos(B * sf.TIME)])
    contact = sf.Contact("floor", slip=U, normal=1, law=sf.laws.coulomb(F))
    return sf.Scene(system, [contact], {B: b, F: f}, {X: 0.0, U: 0.0}, 200.0)


def non_stop(b, f):
    """Return half range, velocity-free phase cosine at the turn, of the orbit that never stops (Den Hartog 1931).

    Between turns x'' + x = cos(b t) - f; from x = a at x' = 0 to x = -a half a period later.
    """
    V, W = 1 / (1 - b**2), np.sin(np.pi / b) / (b * (1 + np.cos(np.pi / b)))
    return np.sqrt(V**2 - (f * W) ** 2)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("v_b", "fall"), [(0.2, 0.1), (0.05, 0.15), (1.5, 0.3)])
def test_coulomb_belt_in_closed_form(v_b, fall):
    """Without damping: an arc around mu_k from the release at mu_s, then a stick of 2 (mu_s - mu_k)/v_b."""
    scene = sf.scenes.mass_on_belt(sf.laws.coulomb(0.4, 0.4 - fall), v_b=v_b, beta=0.0).starting({X: 3.0})
    orbit = sf.limit_cycle(scene)
    stick, arc = 2 * fall / v_b, 2 * np.pi - 2 * np.arctan2(fall, v_b)
    assert orbit.period == pytest.approx(stick + arc, rel=1e-12)
    assert orbit.stick_time == pytest.approx(stick, rel=1e-11)
    assert orbit.stick_fraction == pytest.approx(stick / (stick + arc), rel=1e-11)
    assert orbit.half_range[0] == pytest.approx(np.hypot(fall, v_b), rel=1e-12)
    assert orbit.x_max[1] == pytest.approx(v_b, rel=1e-12)
    assert np.allclose(orbit.multipliers, [1.0, 0.0], atol=1e-9)
    assert orbit.trivial == 0
    assert orbit.stable


@pytest.mark.one_in(4)
@pytest.mark.parametrize("v_b", [0.05, 0.2, 0.39, 0.42])
def test_belt_against_a_long_simulation(v_b):
    scene = BELT.where({"v_b": v_b})
    orbit = sf.limit_cycle(scene)
    late = sf.simulate(scene.until(3000.0).wanting({"end": sf.End()}), 1e-12)
    states = dict(zip(late.names, late.final, strict=True))
    program = sf.prepare(scene.until(2 * orbit.period).wanting({"size": sf.HalfRange(X)}), 1e-12)
    assert program.run(initial=states)["size"] == pytest.approx(orbit.half_range[0], rel=1e-9)
    assert np.allclose(orbit.run(0.0), orbit.run(orbit.period), atol=1e-10)
    assert len(orbit.events) == (2 if v_b < 0.3957 else 0)


def test_the_guess_may_be_rough_and_the_result_the_next_guess():
    orbit = sf.limit_cycle(BELT.where({"v_b": 0.42}))
    again = sf.limit_cycle(BELT.where({"v_b": 0.421}), guess=orbit)
    rough = sf.limit_cycle(BELT.where({"v_b": 0.421}), guess=([orbit.start[0] + 0.02, orbit.start[1]], 6.0))
    assert again.period == pytest.approx(rough.period, rel=1e-11)
    assert again.half_range == pytest.approx(rough.half_range, rel=1e-9)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("b", "f"), [(0.7, 0.2), (1.6, 0.2), (2.5, 0.3), (0.55, 0.25)])
def test_forced_oscillator_that_never_stops(b, f):
    orbit = sf.limit_cycle(shaken(b, f))
    assert orbit.period == pytest.approx(2 * np.pi / b, rel=1e-15)
    assert len(orbit.events) == 2
    assert orbit.stick_time == 0
    a = non_stop(b, f)
    assert orbit.half_range[0] == pytest.approx(a, rel=1e-11)
    turn = next(e for e in orbit.events if e.after == -1)  # x = a
    load = np.cos(b * turn.t)
    assert np.prod(orbit.multipliers).real == pytest.approx(((load - a + f) / (load - a - f)) ** 2, rel=1e-9)
    assert orbit.trivial is None


def test_forced_oscillator_with_two_stops():
    orbit = sf.limit_cycle(shaken(0.4, 0.3))
    assert [e.kind for e in orbit.events].count("stick") == 2
    assert orbit.multipliers[1] == 0
    late = sf.simulate(shaken(0.4, 0.3).until(40 * orbit.period), 1e-12)
    assert np.allclose(late.final, orbit.start, atol=1e-9)


@pytest.mark.parametrize(
    ("scene", "guess"),
    [(BELT.where({"v_b": 0.42}), None), (shaken(0.7, 0.2), None), (shaken(0.4, 0.3), None)],
)
def test_multipliers_against_differences_of_the_map(scene, guess):
    orbit = sf.limit_cycle(scene, guess)
    program = sf.prepare(scene.until(orbit.period).wanting({"end": sf.End()}), 1e-14, route="taylor")
    columns, step = [], 1e-6
    for k, name in enumerate(orbit.names):
        ends = []
        for way in (1, -1):
            start = dict(zip(orbit.names, orbit.start, strict=True))
            start[name] += way * step
            ends.append(program.run(initial=start).final)
        columns.append((ends[0] - ends[1]) / (2 * step))
        assert k < 2
    found = np.sort_complex(np.linalg.eigvals(np.column_stack(columns)))
    assert np.allclose(found, np.sort_complex(orbit.multipliers.astype(complex)), atol=1e-7)


def test_a_period_of_two_excitations():
    """A stiffening oscillator between its resonances, where half of the excitation's frequency answers."""
    beta, a = sp.symbols("beta a", positive=True)
    force = -2 * beta * U - X - X**3 + a * sp.cos(B * sf.TIME)
    scene = sf.Scene(sf.System([X], [U], [[1]], [force]), [], {beta: 0.05, a: 30.0, B: 5.6}, {X: 1.0, U: 0.0}, 400.0)
    orbit = sf.limit_cycle(scene)
    multiple = orbit.period * 5.6 / (2 * np.pi)
    assert multiple == pytest.approx(round(multiple), rel=1e-12)
    assert np.allclose(orbit.run(orbit.period), orbit.start, atol=1e-9)
    assert orbit.stable


def test_two_slides_of_the_audit():
    scene = sf.scenes.two_slides(r=0.5, zeta=2.0, s1=0.2, s2=0.3, fc1=1.0, fs1=7.8, horizon=400.0)
    orbit = sf.limit_cycle(scene)
    assert orbit.period == pytest.approx(30.5259317470719, rel=1e-12)
    assert orbit.stick_fraction == pytest.approx(0.643933628935, rel=1e-11)
    assert 2 * orbit.half_range[0] == pytest.approx(10.18899503638, rel=1e-11)
    assert 2 * orbit.half_range[1] == pytest.approx(13.21670790688, rel=1e-11)
    assert orbit.multipliers[0] == pytest.approx(1.0, abs=1e-9)
    assert orbit.multipliers[-1] == 0


def test_several_contacts():
    """Two masses on a belt, coupled by a spring: both stick and slip."""
    x, u = sp.symbols("x1 x2", real=True), sp.symbols("u1 u2", real=True)
    v_b, k = sp.symbols("v_b k", positive=True)
    force = [-x[0] + k * (x[1] - x[0]), -1.3 * x[1] + k * (x[0] - x[1])]
    contacts = [sf.Contact(f"belt {i}", slip=u[i] - v_b, normal=1, law=sf.laws.coulomb(0.4, 0.3)) for i in (0, 1)]
    initial = {**dict.fromkeys(x, 0.0), **dict.fromkeys(u, 0.0)}
    scene = sf.Scene(sf.System(x, u, sp.eye(2), force), contacts, {v_b: 0.1, k: 1.2}, initial, 300.0)
    orbit = sf.limit_cycle(scene)
    assert {e.contact for e in orbit.events} == {"belt 0", "belt 1"}
    assert np.allclose(orbit.run(orbit.period), orbit.start, atol=1e-9)
    run = sf.simulate(orbit.scene.until(50 * orbit.period), 1e-13)
    assert np.allclose(run.final, orbit.start, atol=1e-6)
    assert orbit.stable


def test_what_is_no_limit_cycle():
    with pytest.raises(sf.NotFound, match="settles to steady sliding or rest"):
        sf.limit_cycle(BELT.where({"v_b": 0.5}))
    with pytest.raises(sf.NotFound, match="settles"):
        sf.limit_cycle(sf.scenes.coulomb_oscillator(0.03))
    signal = sf.Signal([0.0, 1.0, 0.0], 0.1)
    isolator = sf.scenes.rolling_isolator(C=1.0, m=1.0, motion=signal, profile=0.05)
    with pytest.raises(sf.SceneError, match="sampled input"):
        sf.limit_cycle(isolator)
    with pytest.raises(sf.SceneError, match="no common period"):
        sf.limit_cycle(two_frequencies(sp.sqrt(2)))
    drifting = sf.Scene(sf.System([X], [U], [[1]], [-X + sf.TIME * B]), [], {B: 1.0}, {X: 0.0, U: 0.0}, 10.0)
    with pytest.raises(sf.SceneError, match="outside sines"):
        sf.limit_cycle(drifting)
    with pytest.raises(sf.SceneError, match="neither an Orbit nor a pair"):
        sf.limit_cycle(BELT, guess=3.0)
    with pytest.raises(sf.SceneError, match="2 states"):
        sf.limit_cycle(BELT, guess=([1.0], 3.0))


def two_frequencies(ratio):
    force = -X - B * U + sp.cos(2 * sf.TIME) + sp.sin(2 * ratio * sf.TIME)
    return sf.Scene(sf.System([X], [U], [[1]], [force]), [], {B: 0.4}, {X: 0.0, U: 0.0}, 100.0)


def test_two_frequencies_with_a_common_period():
    orbit = sf.limit_cycle(two_frequencies(sp.Rational(3, 2)))
    assert orbit.period == pytest.approx(2 * np.pi, rel=1e-14)
    beta, omega = 0.2, np.sqrt(1 - 0.04)
    pair = np.exp(2 * np.pi * (-beta + 1j * omega * np.array([1, -1])))
    assert np.allclose(np.sort_complex(orbit.multipliers), np.sort_complex(pair), atol=1e-12)


def test_manners():
    orbit = sf.limit_cycle(BELT)
    assert repr(orbit).startswith("Orbit(stable, period=6.799421444")
    data = orbit.to_dict()
    assert data["names"] == ["x", "u"]
    assert len(data["multipliers"]) == 2
    assert orbit.to_xarray()["x"].size == orbit.run.t.size
    axes = orbit.plot()
    assert axes.get_xlabel() == "x"


def ring(start, horizon=25.0):
    """Cycles of radius 1, stable, and 2, unstable, from whose inside motions come slowly to the other."""
    square = X**2 + U**2
    force = -X - sp.Float(0.005) * U * (square - 1) * (4 - square)
    return sf.Scene(sf.System([X], [U], [[1]], [force]), [], {}, {X: start, U: 0.0}, horizon)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("start", [1.999, 0.5])
def test_a_motion_is_followed_to_a_stable_cycle(start):
    """From 1.999 the motion stays near the unstable one for a horizon."""
    orbit = sf.limit_cycle(ring(start))
    assert orbit.stable
    assert orbit.half_range[0] == pytest.approx(1.0, abs=1e-9)


def test_a_guess_finds_an_unstable_cycle():
    orbit = sf.limit_cycle(ring(1.999), guess=((2.0, 0.0), 2 * np.pi))
    assert not orbit.stable
    assert orbit.half_range[0] == pytest.approx(2.0, abs=1e-9)


def test_the_advice_of_a_motion_that_ends_early_can_be_followed():
    """`limit_cycle` takes no route, and a guess replaces the motion."""
    blows = sf.Scene(sf.System([X], [U], [[1]], [X**3]), [], {}, {X: 1.0, U: 0.0}, 25.0)
    with pytest.raises(sf.NotFound, match=r"STEP_COLLAPSE: .*start.*; a guess replaces this motion$"):
        sf.limit_cycle(blows)
    with pytest.raises(
        sf.NotFound, match=r"from this start ends early, (STEP_COLLAPSE|NOT_FINITE): .*simulate the scene"
    ):
        sf.limit_cycle(blows, guess=((1.0, 0.0), 25.0))


@pytest.mark.parametrize("status", [s for s in sf.Status if s != sf.Status.OK], ids=lambda s: s.name)
def test_advice_above_a_run_names_nothing_that_only_a_run_takes(status):
    said = early_end("a run", status)
    assert said.startswith(f"a run ends early, {status.name}: ")
    assert len(said) > 80
    assert not any(word in said for word in ("route", "max_", "trajectory", "\n"))


def test_newtons_method_does_not_lead_to_the_largest_numbers():
    """Far from rest, at numbers beside which the kicks are rounding, any motion would be a cycle."""
    x, u = sp.symbols("x u", real=True)
    kick = sf.Reset(every=1.0, set={u: -u + sp.Rational(1, 10)})
    slider = sf.Contact("c", u, 1, sf.laws.coulomb(0.3), stiffness=10.0)
    scene = sf.Scene(sf.System([x], [u], [[1]], [-x / 5]), [slider], {}, {x: 0.0, u: 1.0}, 20.0, resets=[kick])
    orbit = sf.limit_cycle(scene)
    assert orbit.half_range[0] < 1.0
    start = dict(zip(orbit.run.names, orbit.start, strict=True))
    assert sf.prepare(scene.until(orbit.period)).run(initial=start).final == pytest.approx(orbit.start, abs=1e-8)
