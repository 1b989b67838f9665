"""Properties that every run has: units, mirrors, bounds of friction, balance of energy, continuity."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import symfric as sf

X, U = sp.symbols("x u", real=True)
BELT = sf.scenes.mass_on_belt(v_b=0.2)
VARIED = {"v_b": 0.2, "beta": 0.05, "gamma2": 1.0, "a": 0.01, "Omega": 9.0}
POWER = sf.friction_force("belt") * sf.slip("belt")
SHIFT = sp.Symbol("shift", real=True)
TOLERANCES = (1e-6, 1e-8, 1e-10)
derandomized = settings(derandomize=True, deadline=None, max_examples=25)
values = st.fixed_dictionaries(
    {
        "v_b": st.floats(0.02, 0.6),
        "beta": st.floats(0.0, 0.3),
        "gamma2": st.floats(0.2, 3.0),
        "a": st.floats(0.0, 0.03),
        "Omega": st.floats(1.0, 25.0),
    }
)
starts = st.fixed_dictionaries({"x": st.floats(-1, 1), "u": st.floats(-1, 1)})


@pytest.fixture(scope="module")
def fine():
    return sf.prepare(sf.scenes.mass_on_belt(**VARIED, horizon=30.0), 1e-13)


@pytest.fixture(scope="module")
def coarse():
    return {tol: sf.prepare(sf.scenes.mass_on_belt(**VARIED, horizon=30.0), tol) for tol in TOLERANCES}


@pytest.fixture(scope="module")
def ground():
    scene = sf.scenes.mass_on_belt(v_b=0.0, horizon=20.0)
    return sf.prepare(scene.wanting({"largest": sf.Max(POWER), "path": sf.Trajectory()}), 1e-10)


@pytest.fixture(scope="module")
def shifted():
    scene = sf.Scene(
        system=sf.System(q=[X], u=[U], mass=[[1]], force=[-(X - SHIFT)]),
        contacts=[sf.Contact("belt", U - 0.2, 1, sf.laws.cubic(0.4, 0.25, 0.5))],
        values={SHIFT: 1.0},
        initial={X: 0.0, U: 0.0},
        horizon=15.0,
    )
    return sf.prepare(scene, 1e-12)


def fine_times(run, n=8):
    return np.unique(np.concatenate([np.linspace(a, b, n) for a, b in zip(run.t[:-1], run.t[1:], strict=True)]))


@derandomized
@given(values=values, initial=starts, tolerance=st.sampled_from(TOLERANCES))
def test_error_follows_the_tolerance(fine, coarse, values, initial, tolerance):
    best, run = fine.run(values, initial).checked(), coarse[tolerance].run(values, initial).checked()
    # 8 times the tolerance is the most in 1200 motions, a twentieth of it the median: each stick forgets what was before
    assert np.max(np.abs(run.final - best.final)) < 30 * tolerance


@derandomized
@given(values=values, initial=starts)
def test_energy_balances(coarse, values, initial):
    for tolerance, program in coarse.items():
        assert program.run(values, initial).energy_residual() < 100 * tolerance


@derandomized
@given(values=values, initial=starts)
def test_modes_friction_and_slip_fit_together(fine, values, initial):
    run = fine.run(values, initial).checked()
    law, v_b, load = BELT.contacts[0].law, values["v_b"], values["gamma2"]
    t = fine_times(run)
    x, u = run(t)
    mode = run.mode[0, np.clip(np.searchsorted(run.t, t, side="right") - 1, 0, run.t.size - 1)]
    inside = ~np.isin(t, run.t)
    slip = u - v_b
    assert np.all(slip[inside] * mode[inside] > -1e-12)
    held = inside & (mode == 0)
    assert np.all(np.abs(slip[held]) <= 1e-15)
    drive = values["a"] * values["Omega"] ** 2 * np.sin(values["Omega"] * t)
    force = x + 2 * values["beta"] * u - drive  # what holds the mass while it sticks
    assert np.all(np.abs(force[held]) <= load * 0.4 * (1 + 1e-9))
    power = np.where(mode == 0, 0.0, -np.sign(slip) * load * law(np.abs(slip)) * slip)
    assert np.all(power <= 1e-12)


@derandomized
@given(values=values, initial=starts)
def test_dense_output_is_continuous_and_passes_through_every_event(fine, values, initial):
    run = fine.run(values, initial).checked()
    size = 1 + np.max(np.abs(run.x))
    for k in range(1, run.t.size - 1):
        before = run(np.nextafter(run.t[k], 0))
        assert np.max(np.abs(before - run.x[:, k])) < 1e-11 * size * (1 + values["Omega"] ** 2)
    assert np.max(np.abs(run(run.t_final) - run.final)) < 1e-12 * size
    assert np.all(np.diff(run.t) >= 0)
    for event in run.events:
        k = np.flatnonzero(run.t == event.t)
        assert k.size >= 1
        assert event.after in run.mode[0, k]
        if event.before != 0 or event.after == 0:
            assert run(event.t)[1] == pytest.approx(values["v_b"], abs=1e-12)


@derandomized
@given(values=values, initial=starts)
def test_mirrored_scenes_give_mirrored_runs(fine, values, initial):
    run = fine.run(values, initial)
    mirrored = values | {"v_b": -values["v_b"], "a": -values["a"]}
    other = fine.run(mirrored, {k: -v for k, v in initial.items()})
    t = np.linspace(0, 30, 400)
    growth = np.exp(30 * max(0.0, 0.225 * values["gamma2"] - values["beta"]))
    assert np.max(np.abs(other(t) + run(t))) < 1e-12 * min(growth, 1e3)
    assert [(-e.before, -e.after) for e in other.events] == [(e.before, e.after) for e in run.events]
    assert [e.t for e in other.events] == pytest.approx([e.t for e in run.events], abs=1e-9)


@derandomized
@given(values=values, initial=starts, split=st.floats(0.05, 0.95))
def test_a_run_may_be_interrupted(fine, values, initial, split):
    # the state alone carries the motion of an autonomous scene
    autonomous = values | {"a": 0.0}
    whole = fine.run(autonomous, initial).checked()
    middle = whole(30 * split)
    scene = sf.scenes.mass_on_belt(**autonomous).until(30 * (1 - split)).starting(dict(zip("xu", middle, strict=True)))
    rest = sf.simulate(scene, 1e-13).checked()
    growth = np.exp(30 * max(0.0, 0.225 * values["gamma2"] - values["beta"]))
    assert np.max(np.abs(rest.final - whole.final)) < 1e-11 * min(growth, 1e3)


def test_reversed_time_of_a_frictionless_scene_returns_to_its_start():
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[-sp.sin(X) + sp.Abs(X) / 3])
    scene = sf.Scene(system=system, initial={X: 0.7, U: 0.4}, horizon=17.0)
    there = sf.simulate(scene, 1e-14).checked().final
    back = sf.simulate(scene.starting({X: there[0], U: -there[1]}), 1e-14).checked().final
    assert back == pytest.approx([0.7, -0.4], abs=1e-11)


def dimensional(mass, stiffness, length, excited):
    """The belt of Thomsen (1) in its own units: v_m = 1/2 length omega, and so on."""
    omega = np.sqrt(stiffness / mass)
    law = sf.laws.cubic(0.4, 0.25, 0.5 * length * omega)
    a, Omega = (0.01 * length, 9.0 * omega) if excited else (0.0, 0.0)
    c = 2 * 0.05 * mass * omega
    force = -c * U - stiffness * X + mass * a * Omega**2 * sp.sin(Omega * sf.TIME)
    contact = sf.Contact("belt", U - 0.2 * length * omega, stiffness * length, law)
    system = sf.System(q=[X], u=[U], mass=[[mass]], force=[force])
    return sf.Scene(system=system, contacts=[contact], initial={X: 0.0, U: 0.0}, horizon=30 / omega)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("excited", [False, True])
@pytest.mark.parametrize(
    ("mass", "stiffness", "length"), [(4.0, 16.0, 0.5), (0.3, 2e4, 1e-3), (1.5e-9, 1e-3, 2e-7), (2e5, 7e8, 0.1)]
)
def test_the_dimensional_belt_is_the_dimensionless_one(mass, stiffness, length, excited):
    omega = np.sqrt(stiffness / mass)
    own = sf.simulate(dimensional(mass, stiffness, length, excited), 1e-11).checked()
    reference = {"a": 0.01, "Omega": 9.0} if excited else {"a": 0.0}
    plain = sf.simulate(sf.scenes.mass_on_belt(**{**VARIED, **reference}, horizon=30.0), 1e-11).checked()
    assert own.final / [length, length * omega] == pytest.approx(plain.final, abs=1e-9)
    assert [e.after for e in own.events] == [e.after for e in plain.events]
    assert [e.t * omega for e in own.events] == pytest.approx([e.t for e in plain.events], abs=1e-8)
    assert own.stats["steps"] == pytest.approx(plain.stats["steps"], rel=0.05)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("mass", "stiffness", "length"), [(1.0, 1.0, 1.0), (1.0, 1e12, 1.0), (1e-9, 1e3, 1e-6), (1.0, 1e20, 1.0)]
)
@pytest.mark.parametrize("v_b", [1e-6, 1e-9])
def test_creep_looks_the_same_in_all_units(mass, stiffness, length, v_b):
    # a belt so slow that the law's slope at rest is all that matters: in units of v_b every such motion is the same
    omega = np.sqrt(stiffness / mass)
    law = sf.laws.cubic(0.4, 0.25, 0.5 * length * omega)
    force = -stiffness * X - 0.1 * mass * omega * U
    scene = sf.Scene(
        system=sf.System(q=[X], u=[U], mass=[[mass]], force=[force]),
        contacts=[sf.Contact("belt", U - v_b * length * omega, stiffness * length, law)],
        initial={X: length * (0.4 - 20 * v_b), U: v_b * length * omega},
        horizon=60 / omega,
    )
    run = sf.simulate(scene, 1e-10).checked()
    assert run.stats["events"] == 11
    assert run.events[0].t * omega == pytest.approx(19.9, abs=1e-5)
    assert (run.final / [length, length * omega] - [0.4, 0]) / v_b == pytest.approx([-0.792308, -1.727347], abs=2e-5)


def test_mirrored_belt_without_excitation_is_bit_for_bit():
    run, other = (sf.simulate(sf.scenes.mass_on_belt(v_b=v_b), 1e-10) for v_b in (0.2, -0.2))
    assert np.array_equal(other.final, -run.final)
    assert np.array_equal(other.t, run.t)


def test_powers_of_two_scale_to_rounding():
    own = sf.simulate(dimensional(4.0, 4.0, 0.5, False), 1e-11)
    plain = sf.simulate(dimensional(1.0, 1.0, 1.0, False), 1e-11)
    assert own.final * 2 == pytest.approx(plain.final, abs=1e-14)


@derandomized
@given(values=values, initial=starts)
def test_friction_at_the_ground_dissipates(ground, values, initial):
    still = {k: values[k] for k in ("beta", "gamma2")}
    run = ground.run(still, initial).checked()
    assert run["largest"] <= 1e-12
    x, u = run(fine_times(run))
    assert np.all(np.diff(x**2 + u**2) < 1e-11)


@derandomized
@given(shift=st.floats(-5, 5), x=st.floats(-1, 1))
def test_translated_springs_translate_the_motion(shifted, shift, x):
    here = shifted.run({SHIFT: 0.0}, {X: x})
    there = shifted.run({SHIFT: shift}, {X: x + shift})
    assert there.final - [shift, 0] == pytest.approx(here.final, abs=1e-10)
