"""Contacts that open and strike against closed forms and numbers that were computed independently."""

import math
from functools import cache

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, y, theta, u, v, omega = sp.symbols("x y theta u v omega", real=True)
G = 9.81
FALL = sf.System(q=[y], u=[v], mass=[[1]], force=[-G])


def above(gap, restitution, start, horizon):
    """Return a ball of mass 1 under its weight above a floor or a table."""
    floor = sf.Contact("floor", slip=None, normal=sf.Unilateral(gap, restitution=restitution))
    return sf.Scene(FALL, [floor], initial=dict(zip((y, v), start, strict=True)), horizon=horizon)


def test_bounces_of_a_ball_end_at_the_limit_of_their_series():
    run = sf.simulate(above(y, 0.8, (1.0, 0.0), 5.0)).checked()
    assert run.events[-1].kind == "close"
    assert run.events[-1].t == pytest.approx(math.sqrt(2 / G) * 1.8 / 0.2, abs=1e-12)
    assert run.final.tolist() == [0.0, 0.0]
    assert run.energy_residual() < 1e-12


@pytest.mark.parametrize(("mu", "impacts", "speed", "t", "place"), [
    (0.05, 3, 15 / 7, 1.7519117270246, 4.5530151810739),
    (0.1, 2, 15 / 7, 1.1739614665629, 2.9458843996887),
])  # fmt: skip
def test_a_sphere_slips_until_it_rolls(mu, impacts, speed, t, place):
    system = sf.System([x, y, theta], [u, v, omega], sp.diag(1, 1, sp.Rational(2, 5)), [0, -G, 0])
    floor = sf.Contact("floor", u + omega, sf.Unilateral(y, restitution=0.8), sf.laws.coulomb(mu))
    start = {x: 0, y: 1, theta: 0, u: 3, v: 0, omega: 0}
    run = sf.simulate(sf.Scene(system, [floor], initial=start, horizon=3.0)).checked()
    last = run.events[impacts - 1]
    assert (last.kind, last.t) == ("impact", pytest.approx(t, abs=1e-12))
    assert run(last.t)[0] == pytest.approx(place, abs=1e-12)
    assert run(last.t + 1e-9)[3] == pytest.approx(speed, abs=1e-12)


def test_the_orbit_of_an_impact_oscillator_and_its_multipliers():
    z, r, w = 0.05, 0.7, 2.2
    system = sf.System([x], [u], [[1]], [-2 * z * u - x + sp.cos(w * sf.TIME)])
    stop = sf.Contact("stop", None, sf.Unilateral(-x, restitution=r))
    orbit = sf.limit_cycle(sf.Scene(system, [stop], initial={x: -0.3, u: 0}, horizon=200.0))
    period = 2 * math.pi / w
    assert orbit.period == pytest.approx(period, rel=1e-14)
    assert [e.t % period for e in orbit.events] == [pytest.approx(1.1070263803145, abs=1e-12)]
    assert np.prod(orbit.multipliers).real == pytest.approx(r**2 * math.exp(-2 * z * period), rel=1e-10)
    assert sorted(orbit.multipliers.imag) == pytest.approx([-0.3628963134, 0.3628963134], abs=1e-9)
    assert orbit.multipliers.real == pytest.approx([0.486387161] * 2, abs=1e-9)


def test_a_branch_meets_the_grazing_of_an_impact_oscillator():
    F = sp.Symbol("F", positive=True)
    system = sf.System([x], [u], [[1]], [-u / 10 - x + F * sp.cos(sp.Rational(4, 5) * sf.TIME)])
    stop = sf.Contact("stop", None, sf.Unilateral(1 - x, restitution=0.8))
    scene = sf.Scene(system, [stop], {F: 0.6}, {x: -0.3, u: 0}, 200.0)
    branch = sf.continue_cycle(scene, "F", span=(0.3, 0.6))
    (grazing,) = (s for s in branch.special if s.kind == "grazing")
    amplitude = math.hypot(1 - 0.64, 0.08)  # of the force that reaches the stop
    assert grazing.value == pytest.approx(amplitude, abs=1e-10)
    assert grazing.contact == "stop"


def test_a_block_slides_strikes_a_wall_and_stops():
    system = sf.System([x, y], [u, v], sp.eye(2), [0, -G])
    floor = sf.Contact("floor", u, sf.Unilateral(y), sf.laws.coulomb(0.25))
    wall = sf.Contact("wall", None, sf.Unilateral(sp.Rational(4, 5) - x, restitution=0.6))
    run = sf.simulate(sf.Scene(system, [floor, wall], initial={x: 0, y: 0, u: 3, v: 0}, horizon=2.0)).checked()
    assert run.final[0] == pytest.approx(0.427449541284404, abs=1e-13)
    assert run.events[-1].t == pytest.approx(0.855780142277312, abs=1e-13)


def test_chatter_ends_on_a_moving_table():
    table = sp.Rational(4, 1000) * sp.sin(40 * sf.TIME)
    run = sf.simulate(above(y - table, 0.5, (0.1, 0.0), 1.0), tolerance=1e-13).checked()
    assert run.events[-1].kind == "close"
    assert run.events[-1].t == pytest.approx(0.698778523575088, abs=1e-13)


def test_a_ball_rides_lifts_bounces_and_rides_again():
    table = 1.6 * G / 400 * sp.sin(20 * sf.TIME)
    run = sf.simulate(above(y - table, 0.3, (0.0, 1.6 * G / 20), 1.0), tolerance=1e-13).checked()
    kinds = [e.kind for e in run.events]
    lift, land = run.events[kinds.index("open")].t, run.events[kinds.index("close")].t
    assert lift == pytest.approx(math.asin(1 / 1.6) / 20, abs=1e-13)
    assert run.events[1].t == pytest.approx(0.22558788324367, abs=1e-11)
    assert land == pytest.approx(0.263638010301226, abs=1e-11)


def test_a_mass_strikes_a_plastic_stop_under_friction():
    speed = sf.SPEED
    law = sf.laws.custom(3 + speed + 5 * sp.exp(-2 * speed), 8.008)
    contacts = [sf.Contact("f", u, 1, law), sf.Contact("stop", None, sf.Unilateral(x + sp.Rational(2, 5)))]
    system = sf.System([x], [u], [[1]], [-500 * (x + sp.Rational(1, 4))])
    run = sf.simulate(sf.Scene(system, contacts, initial={x: 0, u: -5}, horizon=2.0), tolerance=1e-12).checked()
    assert run.events[0].t == pytest.approx(0.0605970956085218, abs=1e-11)
    assert run.before(run.events[0].t)[1] == pytest.approx(-6.10565383813644, abs=1e-9)
    assert run.events[-1].t == pytest.approx(1.04597374851725, abs=1e-10)
    assert run.final[0] == pytest.approx(-0.247513987281765, abs=1e-10)


def rod(mu, start, horizon=2.0, values=None):
    """Return a uniform rod above a floor, whose lower end is the tip; theta from the vertical."""
    low, high = (y - s * sp.cos(theta) / 2 for s in (1, -1))
    slips = (u - s * sp.cos(theta) * omega / 2 for s in (1, -1))
    law = sf.laws.coulomb(mu)
    ends = zip(("tip", "top"), slips, (low, high), strict=True)
    contacts = [sf.Contact(name, slip, sf.Unilateral(gap), law) for name, slip, gap in ends]
    system = sf.System([x, y, theta], [u, v, omega], sp.diag(1, 1, sp.Rational(1, 12)), [0, -G, 0])
    return sf.Scene(system, contacts, values or {}, dict(zip(system.states, start, strict=True)), horizon)


@pytest.mark.long(beside="test_a_sphere_slips_until_it_rolls")
def test_a_falling_rod_slips_both_ways_and_lands_flat():
    scene = rod(0.3, [0.5 * math.sin(0.1), 0.5 * math.cos(0.1), 0.1, 0, 0, 0])
    run = sf.simulate(scene, tolerance=1e-12).checked()
    slips, turns, lands = run.events[:3]
    assert [e.kind for e in (slips, turns, lands)] == ["slip", "reverse", "close"]
    assert [e.t for e in (slips, turns, lands)] == pytest.approx(
        [0.5520154826720565, 0.7661680939457, 0.913356812168318], abs=1e-11
    )
    before = run.before(lands.t)
    assert before[5] == pytest.approx(5.14055691490671, abs=1e-9)
    assert before[3] - 0.5 * math.cos(before[2]) * before[5] == pytest.approx(0.93111383930758, abs=1e-10)
    assert run.energy_residual() < 1e-11
    assert abs(run.final[3:]).max() == 0.0  # at rest, exactly


def tip_start(angle, slide):
    return [0.0, 0.5 * math.cos(angle), angle, slide, 0.0, 0.0]


@cache
def upright():
    """Return the program of such a rod for any friction and start."""
    return sf.prepare(rod(sp.Symbol("mu", positive=True), tip_start(math.pi / 4, 0.0), 0.01, {"mu": 1.0}))


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("mu", "angle", "slide", "paradox"), [
    (1.8, math.pi / 4, -1.0, True),
    (1.8, math.pi / 4, 1.0, False),
    (1.6, math.pi / 4, -1.0, False),
    (1.4, math.pi / 2 - math.atan(2), -1.0, True),
    (1.3, math.pi / 2 - math.atan(2), -1.0, False),
])  # fmt: skip
def test_the_paradox_of_painleve_is_a_status(mu, angle, slide, paradox):
    # the tip accelerates by 1 + 3 cos a (cos a - mu sin a) per normal force over mass, a from the floor
    a = math.pi / 2 - angle
    assert (1 + 3 * math.cos(a) * (math.cos(a) - mu * math.sin(a)) < 0) == (paradox or (slide > 0 and mu > 5 / 3))
    start = dict(zip(("x", "y", "theta", "u", "v", "omega"), tip_start(angle, slide), strict=True))
    run = upright().run({"mu": mu}, start)
    assert (run.status == sf.Status.PAINLEVE) == paradox
    assert not paradox or "Painleve" in run.advice


def test_a_follower_leaves_its_cam_at_the_speed_of_the_closed_form():
    stiffness, mass, throw, pressed = 400.0, 0.5, 0.01, 0.02
    leaves = math.sqrt(stiffness * (2 * throw + pressed) / (mass * throw))
    for factor, opens in ((0.9999, False), (1.0001, True)):
        gap = x - throw * (1 - sp.cos(factor * leaves * sf.TIME))
        system = sf.System([x], [u], [[mass]], [-stiffness * (x + pressed)])
        cam = sf.Contact("cam", None, sf.Unilateral(gap))
        outputs = {"least": sf.Min(sf.normal_force("cam")), "events": sf.Events()}
        scene = sf.Scene(system, [cam], initial={x: 0, u: 0}, horizon=0.2, outputs=outputs)
        run = sf.simulate(scene).checked()
        assert any(e.kind == "open" for e in run.events) == opens
        assert run["least"] >= -1e-12


def test_a_rocking_block_loses_speed_by_housners_ratio_and_comes_to_rest():
    half_width, half_height = math.sin(0.2), math.cos(0.2)
    s, c = sp.sin(theta), sp.cos(theta)
    corners = (("left", -1), ("right", 1))
    contacts = [
        sf.Contact(
            name,
            u + (half_height * c - side * half_width * s) * omega,
            sf.Unilateral(y + side * half_width * s - half_height * c),
            sf.laws.coulomb(0.5),
        )
        for name, side in corners
    ]
    system = sf.System([x, y, theta], [u, v, omega], sp.diag(1, 1, sp.Rational(1, 3)), [0, -sp.Rational(16, 3), 0])
    start = [0.0, half_height * math.cos(0.1) + half_width * math.sin(0.1), 0.1, 0, 0, 0]
    run = sf.simulate(
        sf.Scene(system, contacts, initial=dict(zip(system.states, start, strict=True)), horizon=20.0)
    ).checked()
    lands = [e.t for e in run.events if e.kind == "close"][:8]
    ratios = [run(t)[5] / run.before(t)[5] for t in lands]
    assert ratios == pytest.approx([1 - 1.5 * math.sin(0.2) ** 2] * 8, abs=1e-9)
    assert abs(run.final[3:]).max() < 1e-30
    assert run.energy_residual() < 1e-7


@pytest.mark.long(beside="test_the_orbit_of_an_impact_oscillator_and_its_multipliers")
def test_derivatives_through_impacts():
    z, w, r = sp.symbols("z w r", positive=True)
    system = sf.System([x], [u], [[1]], [-2 * z * u - x + sp.cos(w * sf.TIME)])
    stop = sf.Contact("stop", None, sf.Unilateral(-x, restitution=r))
    values = {"z": 0.05, "w": 2.2, "r": 0.7}
    scene = sf.Scene(system, [stop], values, {x: -0.3, u: 0}, 13.0)
    run = sf.simulate(scene, tolerance=1e-13, sensitivities=["z", "w", "r", "x"]).checked()
    h = 1e-5
    for name in ("z", "w", "r"):
        a, b = (sf.simulate(scene.where({name: values[name] + d}), tolerance=1e-13).final for d in (h, -h))
        assert run.sensitivities[name] == pytest.approx((a - b) / (2 * h), rel=1e-6, abs=1e-7)
    a, b = (sf.simulate(scene.starting({"x": -0.3 + d}), tolerance=1e-13).final for d in (h, -h))
    assert run.sensitivities["x"] == pytest.approx((a - b) / (2 * h), rel=1e-6, abs=1e-7)
