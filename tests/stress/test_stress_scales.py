"""Scenes over many decades, long runs and a million events, against closed forms and scaled copies."""

import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
m, k, N, v_b, F, Omega = sp.symbols("m k N v_b F Omega", positive=True)
MU_S, MU_K = 0.4, 0.3


def belt(law, horizon, *, force=-k * X, **values):
    names = {s.name: s for s in (m, k, N, v_b, F, Omega)}
    system = sf.System(q=[X], u=[U], mass=[[m]], force=[force])
    values = {names[n]: x for n, x in values.items()}
    return sf.Scene(system, [sf.Contact("belt", U - v_b, N, law)], values, {X: 0.0, U: 0.0}, horizon, {"end": sf.End()})


def stick_slip(speed):
    """Period of a unit mass on a unit spring: it sticks over 2 (mu_s - mu_k), and slips round a circle about mu_k."""
    drop = MU_S - MU_K
    return 2 * drop / speed + 2 * (math.pi - math.atan(drop / speed))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("route", ["exact", "taylor"])
def test_a_million_events(route):
    speed, periods = 0.5, 500_000
    period = stick_slip(speed)
    start = MU_S / speed  # carried from rest at x = 0 to the static bound; the belt catches it at once
    scene = belt(sf.laws.coulomb(MU_S, MU_K), start + (periods - 0.5) * period, m=1, k=1, N=1, v_b=speed)
    run = sf.prepare(scene, 1e-13, route).run(initial={"u": speed}).checked()
    assert run.stats["events"] == 2 * periods - 1
    slip = 2 * (math.pi - math.atan((MU_S - MU_K) / speed))
    phase = 0.5 * period  # after the last release, which was at (mu_s, v)
    assert phase < slip
    turned = math.atan((MU_S - MU_K) / speed) + phase
    radius = math.hypot(MU_S - MU_K, speed)
    expected = [MU_K + radius * math.sin(turned), radius * math.cos(turned)]
    assert run.final == pytest.approx(expected, abs=1e-8)  # of a time of 3e6, to its rounding and that of each event


@pytest.mark.parametrize("route", ["exact", "taylor"])
@pytest.mark.parametrize("horizon", [1e3, 1e6])
def test_a_long_free_slip_keeps_its_phase(route, horizon):
    # on Coulomb friction a mass that is slower than the belt circles about mu N
    run = sf.prepare(belt(sf.laws.coulomb(0.3), horizon, m=1, k=1, N=1, v_b=0.5), 1e-14, route).run().checked()
    first = -0.3 * np.array([math.cos(horizon), -math.sin(horizon)])
    assert run.stats["events"] == 0
    assert run.final == pytest.approx(np.array([0.3, 0.0]) + first, abs=1e-15 * horizon + 1e-12)


@pytest.mark.one_in(9)
@pytest.mark.parametrize("power", range(-6, 7, 2))
@pytest.mark.parametrize("which", ["time", "length", "force"])
def test_units_over_twelve_decades(power, which):
    law = sf.laws.coulomb(MU_S, MU_K)
    one = sf.simulate(belt(law, 30.0, m=1, k=1, N=1, v_b=0.2), 1e-12).checked()
    unit = 10.0**power
    time, length, force = (unit if which == name else 1.0 for name in ("time", "length", "force"))
    values = {"m": force * time**2 / length, "k": force / length, "N": force, "v_b": 0.2 * length / time}
    for route in ("exact", "taylor"):
        run = sf.simulate(belt(law, 30.0 * time, **values), 1e-11, route).checked()
        assert run.stats["events"] == one.stats["events"] > 4
        assert run.final * [1 / length, time / length] == pytest.approx(one.final, abs=1e-9)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("fast", [1e2, 1e4, 1e6])
def test_excitation_up_to_a_million_radians_a_second(fast):
    # the same motion with another unit of time
    law = sf.laws.stribeck(0.4, 0.25, 0.3)
    force = F * sp.sin(Omega * sf.TIME) - k * X
    slow = sf.simulate(belt(law, 40.0, force=force, m=1, k=0.5, N=1, v_b=0.1, F=0.9, Omega=1), 1e-12).checked()
    values = {"m": fast**-2, "k": 0.5, "N": 1, "v_b": 0.1 * fast, "F": 0.9, "Omega": fast}
    law = sf.laws.stribeck(0.4, 0.25, 0.3 * fast)
    run = sf.simulate(belt(law, 40.0 / fast, force=force, **values), 1e-12).checked()
    assert run.stats["events"] == slow.stats["events"] > 10
    assert run.final / [1, fast] == pytest.approx(slow.final, abs=1e-9)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("v_s", [1e-3, 1e-5, 1e-6])
def test_a_stiff_law_stays_near_the_set_valued_one(v_s):
    law = sf.laws.coulomb(0.4)
    exact = sf.simulate(belt(law, 2.0, m=1, k=1, N=1, v_b=0.2), 1e-12).final
    for tolerance in (1e-6, 1e-10):
        scene = belt(law.regularised(v_s), 2.0, m=1, k=1, N=1, v_b=0.2)
        run = sf.simulate(scene, tolerance, sf.Taylor(max_steps=3_000_000)).checked()
        assert run.final == pytest.approx(exact, abs=3 * v_s + 10 * tolerance)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("tolerance", [10.0**-k for k in range(3, 16)])
def test_tolerances_from_1e_3_to_1e_15(tolerance):
    speed = 0.5
    scene = belt(sf.laws.coulomb(MU_S, MU_K), 0.25 + MU_S / speed + 3 * stick_slip(speed), m=1, k=1, N=1, v_b=speed)
    run = sf.simulate(scene.starting({"u": speed}), tolerance, "taylor").checked()
    turned = math.atan((MU_S - MU_K) / speed) + 0.25
    radius = math.hypot(MU_S - MU_K, speed)
    expected = [MU_K + radius * math.sin(turned), radius * math.cos(turned)]
    assert run.final == pytest.approx(expected, abs=10 * tolerance + 1e-14)
