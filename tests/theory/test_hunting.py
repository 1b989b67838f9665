"""A positioning stage under PID control: hunting in closed form, as a cycle, and in motions; gains without it."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

GAINS = {"k_p": 4.0, "k_d": 1.0, "k_i": 1.0}
FRICTION = {"F_s": 1.5, "F_c": 1.0}
U = sp.Symbol("u", real=True)


def test_reference_cycle():
    found = sf.theory.hunting(**GAINS, **FRICTION)
    assert found.offset == pytest.approx(0.0962508117411759, rel=1e-12)
    assert found.slip_time == pytest.approx(1.598243026518613, rel=1e-12)
    assert found.stick_time == pytest.approx(23.07988652927555, rel=1e-12)
    assert found.period == pytest.approx(49.35625911158832, rel=1e-12)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "change", [{}, {"k_d": 4.0}, {"k_d": 8.0}, {"k_i": 0.2}, {"k_i": 3.0, "F_s": 3.0}, {"m": 3.0, "k_d": 2.0}]
)
def test_motions_hunt_as_the_closed_form_says(change):
    given = {**GAINS, **FRICTION, "m": 1.0} | change
    found = sf.theory.hunting(**given)
    law = sf.laws.coulomb(given["F_s"], given["F_c"])
    gains = {n: given[n] for n in ("k_p", "k_d", "k_i", "m")}
    scene = sf.scenes.positioning_stage(law, **gains, x0=found.offset, horizon=3.9 * found.period)  # on the cycle
    run = sf.simulate(scene, 1e-13).checked()
    times = [e.t for e in run.events]
    assert len(times) >= 14
    assert [e.after != 0 for e in run.events[:6]] == [True, False] * 3
    assert np.diff(times)[:12:2] == pytest.approx(found.slip_time, rel=1e-8)
    assert np.diff(times)[1:12:2] == pytest.approx(found.stick_time, rel=1e-8)
    assert [run(t)[0] for t in times[1:8:2]] == pytest.approx([-found.offset, found.offset] * 2, rel=1e-8)


def test_the_cycle_is_found_as_an_orbit():
    found = sf.theory.hunting(**GAINS, **FRICTION)
    orbit = sf.limit_cycle(sf.scenes.positioning_stage(**GAINS))
    assert orbit.period == pytest.approx(found.period, rel=1e-10)
    assert orbit.half_range[0] == pytest.approx(found.offset, rel=1e-10)
    assert orbit.stick_time == pytest.approx(2 * found.stick_time, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"F_s": 1.0}, "does not exceed"),
        ({"k_i": 4.0}, "unstable"),
    ],
)
def test_gains_without_hunting(change, words):
    with pytest.raises(sf.NotFound, match=words):
        sf.theory.hunting(**{**GAINS, "F_s": 1.1, "F_c": 1.0, **change})


def test_without_kinetic_friction_the_waits_vanish_where_the_loop_becomes_unstable():
    waits = [sf.theory.hunting(k_p=4.0, k_d=1.0, k_i=4.0 * s, F_s=1.5, F_c=0.0).stick_time for s in (0.9, 0.99, 0.999)]
    assert waits == pytest.approx([0.85 * e for e in (0.1, 0.01, 0.001)], rel=0.2)


def test_equal_frictions_settle_and_do_not_hunt():
    scene = sf.scenes.positioning_stage(sf.laws.coulomb(1.0), **GAINS, x0=0.6, horizon=2000.0)
    run = sf.simulate(scene.wanting({"early": sf.At(sp.Symbol("x", real=True), 100.0), "late": sf.End()}))
    assert abs(run["late"][0]) < 0.2 * max(abs(run["early"]), 0.05)


def test_compensation_makes_the_hunting_smaller():
    offset, found = sf.theory.hunting(**GAINS, **FRICTION).offset, []
    for share in (0.0, 0.5, 0.9):
        scene = sf.scenes.positioning_stage(**GAINS, compensation=share, x0=offset, horizon=400.0)
        run = sf.simulate(scene.wanting({"path": sf.Trajectory()})).checked()
        found.append(np.max(np.abs(run.x[0][run.t > 200])))
    assert found[0] == pytest.approx(offset, rel=1e-6)
    assert found[2] < found[1] < 0.9 * found[0]


@pytest.mark.parametrize("name", ["k_p", "k_d", "k_i", "m", "F_s"])
def test_numbers_out_of_range(name):
    with pytest.raises(sf.SceneError, match=f"{name} is 0; it must be positive"):
        sf.theory.hunting(**{**GAINS, **FRICTION, name: 0.0})
