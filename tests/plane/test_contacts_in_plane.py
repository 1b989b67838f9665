"""Contacts in the plane: runs against closed forms, line contacts, a foreign simulator, turned scenes and differences."""

import math
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.errors import NoRoute
from symfric.model.in_plane import with_speeds
from tests.plane.compiled_regularised import regularised as compiled
from tests.plane.plane_reference import Simulator
from tests.plane.plane_scenes import before_a_fast_turn, before_a_near_coincidence, drawn

x, y, u, w = sp.symbols("x y u w", real=True)
t = sf.TIME
LAWS = {
    "coulomb": sf.laws.coulomb(0.5),
    "drop": sf.laws.coulomb(0.7, 0.5),
    "stribeck": sf.laws.stribeck(0.8, 0.5, 0.3),
}


def block(force, law, start, horizon, *, normal=1, slip=(u, w), values=None):
    system = sf.System([x, y], [u, w], [[1, 0], [0, 1]], force)
    contact = sf.Contact("table", slip, normal, law)
    return sf.Scene(system, [contact], values or {}, dict(zip((x, y, u, w), start, strict=True)), horizon)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("ratio", [1.05, 1.5, 1.8, 3.0])
def test_a_block_stops_on_an_incline_as_in_closed_form(ratio):
    a, g = math.radians(20), 9.81
    law = sf.laws.coulomb(ratio * math.tan(a))
    time = ratio / (g * math.sin(a) * (ratio**2 - 1))  # sideways at speed 1; its speed over the angle is a power
    scene = block([0, g * math.sin(a)], law, (0, 0, 1, 0), 2.0 * time, normal=g * math.cos(a))
    run = sf.simulate(scene, tolerance=1e-13).checked()
    assert [e.kind for e in run.events] == ["stick"]
    assert run.events[0].t == pytest.approx(time, abs=1e-12 * time)
    assert run.energy_residual() < 1e-12
    if ratio == 1.5:  # by two methods
        assert run.final[:2] == pytest.approx([0.11176622324782, 0.05960865239884], abs=1e-13)


def test_coupled_springs_stop_where_two_methods_say():
    force = [-x - 0.3 * y, -0.3 * x - 2.5 * y]
    run = sf.simulate(block(force, sf.laws.coulomb(0.1), (1, 0.4, 0.3, -0.6), 30.0), tolerance=1e-14)
    assert run.events[0].t == pytest.approx(21.380823098424524, abs=1e-12)  # polar, 22 digits, time scaled by the speed
    assert run.final == pytest.approx([0.0397606991051733, -0.00738456839793284, 0, 0], abs=1e-14)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("angle", [0.0, 0.8])
def test_a_motion_on_a_line_is_that_of_a_line_contact(law, angle):
    c, s = math.cos(angle), math.sin(angle)
    drive = 1.2 * sp.cos(0.9 * t)
    line = sf.Contact("table", u, 1, LAWS[law])
    along = sf.Scene(sf.System([x], [u], [[1]], [drive - x]), [line], {}, {x: 0, u: 0.3}, 20.0)
    a, b = drive - (c * x + s * y), s * x - c * y
    plane = block([c * a - s * b, s * a + c * b], LAWS[law], (0, 0, 0.3 * c, 0.3 * s), 20.0)
    one, two = sf.simulate(along, tolerance=1e-13), sf.simulate(plane, tolerance=1e-13)
    turned = np.array([[c, s], [-s, c]])
    (q, across), (v, sideways) = turned @ two.final[:2], turned @ two.final[2:]
    assert [q, v] == pytest.approx(one.final, abs=1e-11)
    assert [across, sideways] == pytest.approx([0, 0], abs=1e-11)
    sticks = [e.t for e in one.events if 0 in (e.before, e.after)]
    assert [e.t for e in two.events] == pytest.approx(sticks, abs=1e-11)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("law", LAWS)
def test_a_turned_scene_gives_the_turned_motion(law):
    def final(phi):
        c, s = math.cos(phi), math.sin(phi)
        a, b = c * x + s * y, c * y - s * x
        f, g = 0.8 * sp.cos(t) - a - 0.3 * b, 0.7 * sp.sin(1.4 * t) - 0.3 * a - 2.5 * b
        start = (0, 0, c * 0.3 - s * 0.2, s * 0.3 + c * 0.2)
        run = sf.simulate(block([c * f - s * g, s * f + c * g], LAWS[law], start, 20.0), tolerance=1e-13)
        back = np.array([[c, s], [-s, c]])
        return np.concatenate([back @ run.final[:2], back @ run.final[2:]])

    assert final(0.7) == pytest.approx(final(0.0), abs=1e-12)


def agrees(seed):
    """Assert that a drawn scene moves as in the foreign simulator, and that its balance of energy holds."""
    scene = drawn(seed)
    run, other = sf.simulate(scene.scene(), tolerance=1e-12).checked(), Simulator(scene.problem()).run()
    assert run.final == pytest.approx(other.final, abs=5e-10)
    assert [e.kind for e in run.events] == [kind for _, _, kind in other.events]
    assert [e.t for e in run.events] == pytest.approx([when for when, _, _ in other.events], abs=1e-8)
    assert run.energy_residual() < 1e-10


@pytest.mark.long(beside="test_coupled_springs_stop_where_two_methods_say")
@pytest.mark.parametrize("seed", [1, 10, 22])
def test_random_scenes_against_a_foreign_simulator(seed):
    agrees(seed)


@pytest.mark.long(beside="test_coupled_springs_stop_where_two_methods_say")
@pytest.mark.parametrize("seed", range(40, 340))
def test_more_random_scenes_against_a_foreign_simulator(seed):
    agrees(seed)


SPEEDS = (1e-3, 1e-4, 1e-5)  # over which friction is regularised


def trend(scene, final):
    return [np.max(np.abs(compiled(scene, eps) - final)) for eps in SPEEDS]


def falls(errors):
    """Whether errors fall over two decades of the speed; slow releases may cost one of them most of its gain."""
    return errors[-1] < max(0.15 * errors[0], 1e-8)


@pytest.mark.long(beside="test_coupled_springs_stop_where_two_methods_say")
@pytest.mark.parametrize("first", range(1000, 3000, 100))
def test_hundreds_of_random_scenes_are_limits_of_regularised_ones(first):
    """From 1e-3 to 1e-5 of the speed of regularisation the difference falls, and tolerances agree."""
    for seed in range(first, first + 100):
        drawn_scene = drawn(seed)
        scene = drawn_scene.scene()
        loose, run = (sf.simulate(scene, tolerance=tolerance).checked() for tolerance in (1e-9, 1e-12))
        assert loose.final == pytest.approx(run.final, abs=1e-7), seed
        assert run.energy_residual() < 1e-10, seed
        errors = trend(drawn_scene, run.final)
        if not falls(errors):  # at a turn, or between two events, that the speeds of regularisation do not resolve
            motion = Simulator(drawn_scene.problem()).run()
            assert run.final == pytest.approx(motion.final, abs=1e-6), seed
            turn = before_a_fast_turn(drawn_scene, motion, SPEEDS[-1])
            end = min(turn, before_a_near_coincidence(drawn_scene, motion, 10 * SPEEDS[-1]))
            assert end > 1, (seed, errors)
            drawn_scene = replace(drawn_scene, horizon=end)
            errors = trend(drawn_scene, motion.at(end))
            if not falls(errors):  # slow releases
                errors.append(np.max(np.abs(compiled(drawn_scene, 0.1 * SPEEDS[-1]) - motion.at(end))))
        assert falls(errors), (seed, errors)


def dragged(a=0.3):
    k, v_b, mu, force = sp.symbols("k v_b mu a", positive=True)
    law = sf.laws.stribeck(mu, 0.7 * mu, 0.3)
    values = {k: 1.0, v_b: 0.2, mu: 0.4, force: a}
    forces = [force * sp.cos(1.3 * t) - k * x, -2.5 * y]
    return block(forces, law, (0, 0.3, 0, 0.1), 9.0, slip=(u - v_b, w), values=values)


def test_derivatives_pass_stops_and_releases():
    run = sf.simulate(dragged(), tolerance=1e-10, sensitivities=["v_b", "k", "y"]).checked()
    assert {e.kind for e in run.events} == {"stick", "slip"}
    program = sf.prepare(dragged(), tolerance=1e-13)
    middle = {"v_b": 0.2, "k": 1.0, "y": 0.3}
    for name, derivative in run.sensitivities.items():
        kind = "initial" if name == "y" else "values"
        ends = [program.run(**{kind: {name: middle[name] + step}}).final for step in (1e-5, -1e-5)]
        assert derivative == pytest.approx((ends[0] - ends[1]) / 2e-5, abs=5e-7)


@pytest.mark.long(beside="test_maps_have_the_bits_of_single_runs")
def test_cycle_with_multipliers_and_maps():
    scene = dragged()
    orbit = sf.limit_cycle(scene, tolerance=1e-13)
    start = orbit.run.x[:, 0]
    period = sf.prepare(scene.until(orbit.period), 1e-13)

    def image(at):
        return period.run(initial=dict(zip(orbit.run.names, at, strict=True))).final

    slopes = np.column_stack([(image(start + h) - image(start - h)) / 2e-6 for h in np.eye(4) * 1e-6])
    found = np.sort(np.abs(np.linalg.eigvals(slopes)))
    assert np.sort(np.abs(orbit.multipliers)) == pytest.approx(found, abs=1e-6)


def test_maps_have_the_bits_of_single_runs():
    fastest = dragged().wanting({"s": sf.Max(sf.slip("table"))})
    values = np.linspace(0.1, 0.5, 3)
    batch = sf.prepare(fastest).map(values={"v_b": values}).outputs["s"]
    assert batch.tolist() == [sf.simulate(fastest.where({"v_b": v}))["s"] for v in values]


def test_friction_across_the_sliding_direction_damps():
    scene = dragged(a=0.0)
    found, speed = sf.stability(scene), math.exp(-0.2 / 0.3)
    assert found.B[1, 1] == pytest.approx(0.4 * (0.7 + 0.3 * speed) / 0.2, rel=1e-12)  # mu N/v
    assert found.B[0, 0] == pytest.approx(-0.4 * speed, rel=1e-12)  # N mu'(v)
    assert dict(sf.equilibrium(scene).sliding) == {"table": pytest.approx(0.2)}


@pytest.mark.long(beside="test_coupled_springs_stop_where_two_methods_say")
def test_contacts_in_the_plane_and_along_a_line_together():
    X, U = sp.symbols("X U", real=True)
    force = [-x + 0.9 * sp.cos(t), -2 * y + 0.4 * sp.sin(1.3 * t), -X]
    system = sf.System([x, y, X], [u, w, U], [[1, 0, 0], [0, 1, 0], [0, 0, 2]], force)
    contacts = [sf.Contact("table", (u, w), 1, LAWS["drop"]), sf.Contact("rail", U - u, 0.5, LAWS["coulomb"])]
    scene = sf.Scene(system, contacts, {}, dict.fromkeys((x, y, X, u, w, U), 0.0), 30.0)
    runs = [sf.simulate(scene, tolerance=tolerance).checked() for tolerance in (1e-10, 1e-13)]
    assert runs[0].final == pytest.approx(runs[1].final, abs=1e-8)
    assert {e.contact for e in runs[1].events} == {"table", "rail"}
    assert runs[1].energy_residual() < 1e-11


@pytest.mark.long(beside="test_the_length_of_a_slip_written_by_hand_is_its_speed")
def test_outputs_of_a_vector():
    asked = {
        "x": sf.Max(sf.friction_force("table", 0)),
        "speed": sf.Min(sf.slip("table")),
        "lost": sf.Integral(-sf.friction_force("table", 0) * (u - 0.2) - sf.friction_force("table", 1) * w),
    }
    run = sf.simulate(dragged().wanting({**asked, "path": sf.Trajectory()}))
    assert abs(run["speed"]) < 1e-30
    assert 0 < run["x"] <= 0.4
    assert run["lost"] > 0
    assert set(run.mode.ravel()) == {0, 1}


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"slip": (u,)}, "1 entries"),
        ({"slip": (u, 2 * u)}, "parallel"),
        ({"slip": (u, w), "stiffness": 3}, "dry law"),
        ({"slip": (u, w), "law": sf.laws.dahl(0.3, 10)}, "dry law"),
        ({"slip": (u, x)}, "no velocity"),
        ({"slip": (u, w), "profile": sp.Piecewise((1, x < 0), (2, True))}, "continuous"),
    ],
)
def test_bad_contacts_are_named(changed, words):
    given = {"name": "table", "slip": (u, w), "normal": 1, "law": LAWS["coulomb"]} | changed
    system = sf.System([x, y], [u, w], [[1, 0], [0, 1]], [0, 0])
    with pytest.raises(sf.SceneError, match=words):
        sf.Scene(system, [sf.Contact(**given)], {}, dict.fromkeys((x, y, u, w), 0.0), 1.0)


@pytest.mark.parametrize(
    "question",
    [
        lambda s: s.regularised(1e-3),
        sf.separate,
        lambda s: sf.simulate(s, route="exact"),
        lambda s: sf.simulate(s, route="integrators"),
        lambda s: s.wanting({"f": sf.Max(sf.friction_force("table"))}),
    ],
)
def test_what_takes_lines_alone_says_so(question):
    with pytest.raises((sf.SceneError, NoRoute), match=r"plane|vector"):
        question(dragged())


def test_the_length_of_a_slip_written_by_hand_is_its_speed():
    """As a root it has no series where the contact stops, so that its integral would have no value."""
    slips, speed = (u - 0.2, 3 * w), sf.slip("table")
    square = (u - 0.2) ** 2 + 9 * w**2
    for written, told in (
        (sp.sqrt(square), speed),
        (2 / sp.sqrt(sp.expand(square)) + x, 2 / speed + x),
        (sp.expand(4 * square) ** sp.Rational(3, 2), 8 * speed**3),
        (sp.sqrt(u**2 + 9 * w**2), sp.sqrt(u**2 + 9 * w**2)),
        (square, square),
    ):
        assert sp.simplify(with_speeds(written, "table", slips) - told) == 0
    v_b = sp.Symbol("v_b", positive=True)
    wanted = {"way": sf.Integral(speed), "by hand": sf.Integral(sp.sqrt((u - v_b) ** 2 + w**2))}
    run = sf.simulate(dragged().wanting(wanted)).checked()
    assert run["by hand"] == run["way"] > 0
