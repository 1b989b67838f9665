"""The contact damper: decay times, energies and decisions by events, against the averaged law and known numbers."""

import numpy as np
import pytest

import symfric as sf
from symfric.errors import SceneError
from symfric.scenefile import read_scene_text, ready_scenes
from symfric.theory import transient

DECAYS = [  # f_n, mu_m, time, half cycles, position at rest; no damping, from 10 mm
    (3.5, 0.05, 0.71432458228639, 5, -7.6297032471e-4),
    (3.5, 0.1, 0.42866708245224, 3, 1.2760884326e-3),
    (5.0, 0.2, 0.30012385106254, 3, 6.0408991310e-4),
    (10.0, 0.1, 1.3000278279274, 26, -4.2525851766e-5),
    (20.0, 0.05, 6.7500063539546, 270, -1.9489441565e-5),
]


@pytest.fixture(scope="module")
def program():
    return sf.prepare(sf.scenes.contact_damper(f_n=7.0, mu_m=0.07, zeta=0.01, v0=0.1, horizon=8.0), 1e-12)


@pytest.fixture(scope="module")
def literal():
    scene = sf.scenes.contact_damper(f_n=7.0, mu_m=0.07, zeta=0.01, v0=0.1, literal=True, horizon=8.0)
    return sf.prepare(scene, 1e-12)


def run_of(program, **values):
    return program.run({"zeta": 0.0, "v0": 0.0, **values}).checked()


# --- The numbers ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("f_n", "mu_m", "time", "halves", "rest"), DECAYS)
def test_decay_without_damping(program, f_n, mu_m, time, halves, rest):
    run = run_of(program, f_n=f_n, mu_m=mu_m)
    assert run["stop_time"] == pytest.approx(time, rel=1e-12)
    assert run.final[0] == pytest.approx(rest, rel=1e-9)
    assert len(run.events) == halves
    assert run.final[1] == 0.0
    assert abs(transient.averaged_decay_time(run.scene) - time) < 0.25 / f_n


@pytest.mark.parametrize(("zeta", "ratio"), [(0.005, 0.29074984260261), (0.05, 2.5014907327626)])
def test_ratio_of_viscous_to_contact_energy(program, zeta, ratio):
    assert transient.energy_balance(run_of(program, f_n=10, mu_m=0.1, zeta=zeta)).ratio == pytest.approx(
        ratio, rel=1e-12
    )


def test_steel_rod(program):
    run = run_of(program, f_n=5.3, mu_m=0.19, zeta=0.009, m=0.679)
    assert run["stop_time"] == pytest.approx(0.28305669021542, rel=1e-12)
    assert len(run.events) == 3


def test_loose_tolerance_keeps_nine_digits():
    run = sf.simulate(sf.scenes.contact_damper(f_n=10, mu_m=0.1))
    assert run["stop_time"] == pytest.approx(1.3000278279274, rel=1e-9)


def test_the_mass_does_not_matter_at_equal_load_over_weight(program):
    light, heavy = (run_of(program, f_n=5, mu_m=0.1, m=m) for m in (0.3, 3.0))
    assert light["stop_time"] == pytest.approx(heavy["stop_time"], rel=1e-12)
    assert heavy["E_contact"] == pytest.approx(10 * light["E_contact"], rel=1e-12)


# --- Energies ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("zeta", [0.0, 0.05])
@pytest.mark.parametrize(("x0", "v0"), [(0.01, 0.0), (0.0, -0.4), (-0.02, 0.3)])
def test_energies_balance_with_what_stays_in_the_spring(program, literal, zeta, x0, v0):
    for p in (program, literal):
        balance = transient.energy_balance(run_of(p, f_n=3.5, mu_m=0.1, zeta=zeta, x0=x0, v0=v0))
        assert abs(balance.gap) < 1e-12
        assert balance.kinetic == 0.0
        assert balance.printed_gap == pytest.approx(balance.elastic / balance.input, rel=1e-9)


@pytest.mark.parametrize(("mu_m", "share"), [(0.1, 0.0163), (0.2, 0.0743)])
def test_printed_balance_lacks_what_stays_in_the_spring(program, mu_m, share):
    assert transient.energy_balance(run_of(program, f_n=3.5, mu_m=mu_m)).printed_gap == pytest.approx(share, abs=5e-5)


def test_a_run_cut_short_has_energy_of_motion(program):
    scene = sf.scenes.contact_damper(f_n=3.5, mu_m=0.1, horizon=0.05)
    balance = transient.energy_balance(sf.simulate(scene, 1e-11))
    assert balance.kinetic > 0
    assert abs(balance.gap) < 1e-11
    assert set(balance.to_dict()) >= {"input", "viscous", "contact", "elastic", "ratio"}


def test_constant_friction_is_the_limit_of_a_large_speed(program):
    run = run_of(program, f_n=4.0, mu_m=0.06, v_c=1e12)
    delta = 0.06 * 9.81 / (2 * np.pi * 4.0) ** 2
    assert len(run.events) == transient.half_cycles(delta, x0=0.01)
    assert run.final[0] == pytest.approx(transient.stop_position(delta, x0=0.01), rel=1e-9)
    assert run["stop_time"] == pytest.approx(transient.stop_time(delta, x0=0.01, omega_n=8 * np.pi), rel=1e-9)


# --- Decisions ---------------------------------------------------------------------------------------------------


def test_decisions_are_those_of_the_turning_points(program):
    run = run_of(program, f_n=3.5, mu_m=0.05)
    found = transient.decisions(run)
    limit = 0.05 * 9.81 / (7 * np.pi) ** 2
    assert found.margin == pytest.approx(np.abs(found.x) / limit - 1, rel=1e-9)
    assert found.t.size == 1 + len(run.events)
    assert found.x[[0, -1]] == pytest.approx([0.01, run.final[0]])
    assert np.all(found.margin[:-1] > 0)
    assert found.last < 0
    assert abs(found.closest) == np.min(np.abs(found.margin))


def test_a_razor_edge_shows(program):
    sharp = transient.decisions(run_of(program, f_n=5.0, mu_m=0.02))
    assert abs(sharp.closest) < 1e-4
    assert "closest" in repr(sharp)
    assert abs(transient.decisions(run_of(program, f_n=10.0, mu_m=0.1)).closest) > 0.1
    assert sharp.to_dict()["margin"][-1] == sharp.last


def test_decisions_of_any_mass_with_one_contact():
    found = transient.decisions(sf.simulate(sf.scenes.coulomb_oscillator(0.03, delta_s=0.05), 1e-11))
    turns = np.maximum(0.0, 1 - 0.06 * np.arange(found.t.size))
    assert found.margin == pytest.approx(turns / 0.05 - 1, abs=1e-8)
    belt = transient.decisions(sf.simulate(sf.scenes.mass_on_belt(v_b=0.2, horizon=20.0), 1e-10))
    assert belt.t.size
    assert np.all(belt.margin <= 0)


def test_start_inside_the_band_is_the_only_decision(program):
    run = run_of(program, f_n=3.5, mu_m=0.1, x0=1e-3)
    assert run["stop_time"] == 0.0
    assert transient.decisions(run).t.tolist() == [0.0]


# --- The literal law ---------------------------------------------------------------------------------------------


def test_literal_law_is_the_printed_force(literal):
    run = run_of(literal, f_n=3.5, mu_m=0.1)
    assert len(run.events) == 2
    assert run["stop_time"] == pytest.approx(0.2857900405856, rel=1e-9)
    assert abs(transient.averaged_decay_time(run.scene) - run["stop_time"]) < 0.25 / 3.5


def test_literal_law_takes_longer_from_the_other_side(literal):
    """The first stroke from x0 < 0 is forward, where the printed law falls: not one cycle but three halves."""
    assert len(run_of(literal, f_n=3.5, mu_m=0.1, x0=-0.01).events) == 3


@pytest.mark.parametrize(("f_n", "mu_m", "zeta"), [(20.0, 0.05, 0.0), (10.0, 0.1, 0.02)])
def test_literal_averaged_law(literal, f_n, mu_m, zeta):
    run = run_of(literal, f_n=f_n, mu_m=mu_m, zeta=zeta)
    assert abs(transient.averaged_decay_time(run.scene) - run["stop_time"]) < 0.25 / f_n
    a = np.array([0.0, 0.3, 2.0])
    assert transient.mean_friction(a, literal=True) == pytest.approx(
        [np.mean(np.cosh(x * np.sin(P)) * np.sin(P)) * np.pi / 2 for x in a], rel=1e-6
    )


P = (np.arange(20000) + 0.5) * np.pi / 40000


# --- The scene ---------------------------------------------------------------------------------------------------


def test_averaged_decay_time_takes_the_scene():
    scene = sf.scenes.contact_damper(f_n=8, mu_m=0.05, zeta=0.02, x0=0.0, v0=0.4, r=2.0, v_c=0.7)
    numbers = {"zeta": 0.02, "x0": 0.0, "v0": 0.4, "r": 2.0, "v_c": 0.7}
    assert transient.averaged_decay_time(scene) == transient.averaged_decay_time(8, 0.05, **numbers)
    assert transient.averaged_decay_time(scene.starting({"x": 0.01, "u": 0.0})) == transient.averaged_decay_time(
        8, 0.05, **{**numbers, "x0": 0.01, "v0": 0.0}
    )


@pytest.mark.parametrize("literal", [False, True])
@pytest.mark.parametrize(("f_n", "mu_m", "zeta", "x0"), [(1, 0.01, 0, 0.3), (15, 0.3, 0.1, 0.05), (30, 0.02, 0.3, 0.2)])
def test_the_default_horizon_is_long_enough(f_n, mu_m, zeta, x0, literal):
    scene = sf.scenes.contact_damper(f_n=f_n, mu_m=mu_m, zeta=zeta, x0=x0, literal=literal)
    assert transient.averaged_decay_time(scene) + 0.5 / f_n < scene.horizon


def test_the_bound_of_the_horizon_lies_below_the_mean_friction():
    a = np.concatenate([np.linspace(0, 50, 5001), np.geomspace(50, 1e6, 200)])
    assert np.all(transient.mean_friction(a) * (1 + a) ** 2 >= 1 - 1e-14)


def test_the_scene_is_a_model_of_scene_files():
    assert "contact_damper" in ready_scenes()
    file = (
        '[scene]\nmodel = "contact_damper"\nliteral = true\n[values]\nf_n = 3.5\nmu_m = 0.1\n[outputs]\nt = "stop_time"'
    )
    run = sf.simulate(read_scene_text(file).scene)
    assert run["t"] == pytest.approx(0.2857900405856, rel=1e-7)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"f_n": 0.0}, "f_n is 0"),
        ({"m": -1.0}, "m is -1"),
        ({"mu_m": -0.1}, "mu_m is -0.1"),
        ({"x0": np.nan}, "x0 is nan"),
        ({"f_n": "3"}, "f_n is '3'"),
        ({"literal": 1}, "literal is 1"),
    ],
)
def test_wrong_arguments_are_refused_by_name(arguments, message):
    with pytest.raises(SceneError, match=message):
        sf.scenes.contact_damper(**{"f_n": 3.5, "mu_m": 0.1, **arguments})


def test_what_does_not_apply_is_refused(program):
    oscillator = sf.scenes.coulomb_oscillator(0.1)
    scene = sf.scenes.contact_damper(f_n=3.5, mu_m=0.1)
    two = sf.scenes.mass_on_belt(v_b=0.2)
    with pytest.raises(SceneError, match="contact_damper"):
        transient.averaged_decay_time(two)
    with pytest.raises(SceneError, match="scene.where"):
        transient.averaged_decay_time(scene, zeta=0.1)
    with pytest.raises(SceneError, match="E_viscous"):
        transient.energy_balance(sf.simulate(oscillator))
    with pytest.raises(SceneError, match="sf.Trajectory|sf.Events"):
        transient.decisions(sf.simulate(scene.wanting({"end": sf.End()})))


def test_a_scene_without_friction_runs_on():
    scene = sf.scenes.contact_damper(f_n=3.5, mu_m=0.0)
    assert np.isnan(sf.simulate(scene, 1e-10)["stop_time"])
    with pytest.raises(sf.NotFound):
        transient.averaged_decay_time(scene)
