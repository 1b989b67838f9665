"""Steps of fixed length: of order four through stick and slip, exactly at rest, honest about what they do not resolve."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.export.step_function import LOST_CONTACT, MANY_EVENTS, NOT_FINITE
from tests.export.scenes_for_steps import COULOMB, PUSH, SCENES, floor, k, one, pair, u, u2, v_b, x


@pytest.mark.one_in(30)
@pytest.mark.parametrize("name", SCENES)
def test_the_error_falls_with_the_fourth_power_of_the_step(name):
    coarse, fine = (sf.export.stepper(SCENES[name], h).error() for h in (0.02, 0.01))
    assert fine < 1e-5
    assert 3.5 < np.log2(coarse / fine) < 5.0


def test_a_bare_sign_would_be_of_first_order():
    def march(h):
        y, rate = np.array([1.0, 0.0]), lambda y, t: np.array([y[1], -y[0] + np.cos(1.3 * t) / 2 - 0.3 * np.sign(y[1])])
        for j in range(round(12.0 / h)):
            t, k1 = j * h, rate(y, j * h)
            k2 = rate(y + h / 2 * k1, t + h / 2)
            k3 = rate(y + h / 2 * k2, t + h / 2)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + h * k3, t + h))
        return y

    exact = sf.simulate(one(PUSH, floor(COULOMB)), 1e-12).final
    assert np.max(np.abs(march(0.01) - exact)) > 1e-4
    assert sf.export.stepper(one(PUSH, floor(COULOMB)), 0.01).error() < 1e-7


def test_sticking_is_exact():
    for name in ("drop after rest", "pad between masses", "moving table"):
        run = sf.export.stepper(SCENES[name], 0.01).run()
        for j, contact in enumerate(run.contact.values):
            rests = run["mode"].values[j] == 0
            slips = np.abs(run[f"{contact}.slip"].values)
            assert np.max(slips[rests], initial=0.0) <= 1e-15 * np.max(slips)
        assert np.any(run["mode"].values == 0)
    at_rest = sf.export.stepper(one(-x + sp.Rational(1, 5), floor(COULOMB), start=0.3), 0.1).run()
    assert np.all(at_rest.x.values[0] == 0.3)  # not even rounding moves it


def test_modes_and_forces_are_those_of_the_event_driven_run():
    scene = SCENES["drop after rest"]
    run, steps = sf.simulate(scene, 1e-11), sf.export.stepper(scene, 0.01).run()
    far = np.min(np.abs(steps.t.values[:, None] - [e.t for e in run.events]), axis=1) > 0.011
    modes = run.mode[0][np.searchsorted(run.t, steps.t.values[far], side="right") - 1]
    assert np.array_equal(steps["mode"].values[0][far], modes)
    slipping = steps["mode"].values[0] != 0
    friction = steps["floor.friction"].values[slipping]
    assert np.allclose(friction, -0.2 * steps["mode"].values[0][slipping], rtol=1e-14)
    assert np.all(np.abs(steps["floor.friction"].values) <= 0.3 * (1 + 1e-12))


def test_outputs_may_be_any_expression():
    run = sf.export.stepper(
        SCENES["belt"], 0.05, {"pull": -x, "power": sf.friction_force("belt") * sf.slip("belt")}
    ).run()
    assert np.array_equal(run.pull.values, -run.x.values[0])
    assert np.all(run.power.values <= 1e-15)
    assert set(run.data_vars) == {"x", "mode", "status", "pull", "power"}


def test_parameters_may_change_between_steps():
    """A contact that stuck to a belt slips if the belt jumps to another speed, as in a run from there."""
    s = sf.export.stepper(SCENES["belt"], 0.01)
    y, m = s.start(s.initial, 0.0, s.values, [], [])
    for n in range(100):
        y, m, _ = s.advance(y, m, n * s.step, s.values, [], [], s.step)
    assert s.look(y, m, 1.0, s.values, [])[1] == 0  # it sticks
    for speed in (0.35, 0.1, -0.2):
        changed = s.values.copy()
        changed[s.parameters.index("v_b")] = speed
        after, kept = y, m
        for n in range(100, 400):
            after, kept, status = s.advance(after, kept, n * s.step, changed, [], [], s.step)
            assert status == 0
        scene = SCENES["belt"].where({"v_b": speed}).starting(dict(zip(s.states, np.array(y).ravel(), strict=True)))
        exact = sf.simulate(scene.until(3.0).wanting({"end": sf.End()}), 1e-12).final
        assert np.array(after).ravel() == pytest.approx(exact, abs=1e-8)


def test_what_a_step_does_not_resolve_is_said():
    many = sf.export.stepper(SCENES["pad between masses"], 0.01, events=1).run()
    assert int(many.status.max()) <= MANY_EVENTS
    rattle = one(-x + 5 * sp.cos(40 * sf.TIME), floor(COULOMB))
    assert int(sf.export.stepper(rattle, 0.3, events=1).run().status.max()) == MANY_EVENTS
    lifted = one(PUSH, [sf.Contact("floor", slip=u, normal=1 - sf.TIME / 4, law=COULOMB)])
    statuses = sf.export.stepper(lifted, 0.01).run(until=6.0)
    assert np.all((statuses.status.values == LOST_CONTACT) == (statuses.t.values > 4.0))
    stiff = one(-(10**6) * x - 2000 * u)
    steps = sf.export.stepper(stiff, 0.01)
    assert int(steps.run().status.max()) == NOT_FINITE
    assert steps.error() == np.inf


def test_after_too_many_events_a_step_is_of_first_order():
    """Friction never drives: the energy of a body that only slides falls, however coarse the step."""
    sliding = one(-x, floor(COULOMB), start=3.0)
    for h in (0.5, 1.0):
        run = sf.export.stepper(sliding, h, events=1).run(until=30.0)
        assert np.max(np.diff(np.sum(run.x.values**2, axis=0))) <= 1e-3 * h**4
        assert abs(float(run.x[0, -1])) <= 0.3 + 0.05 * h


def test_the_functions_are_casadi_functions():
    s = sf.export.stepper(SCENES["belt"], 0.01)
    y = ca.MX.sym("y", 2)
    after, _, _ = s.advance(y, s.start(s.initial, 0, s.values, [], [])[1], 0, s.values, [], [], 0.01)
    slope = ca.Function("slope", [y], [ca.jacobian(after, y)])(s.initial)
    assert np.linalg.det(np.array(slope)) == pytest.approx(1.0, abs=0.05)


def parallel():
    return pair(sf.Contact("again", slip=u2 - v_b, normal=1, law=COULOMB))


def cells():
    profile = sp.Piecewise((1, x < 0), (2, True))
    return one(PUSH, [sf.Contact("floor", slip=u, normal=1, law=COULOMB, profile=profile)])


REFUSED = {
    "hold the same motion": parallel,
    "jumps from cell to cell": cells,
    "infinite slope": lambda: one(PUSH, floor(sf.laws.cubic(0.4, 0.25, 0.5).averaged(0.3))),
    "no value for k": lambda: one(-k * x, values={k: None}),
}


@pytest.mark.parametrize("reason", REFUSED)
def test_scenes_that_a_step_does_not_take_are_refused_by_name(reason):
    with pytest.raises(sf.SceneError, match=reason):
        sf.export.stepper(REFUSED[reason](), 0.01)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"step": 0.0}, "step is 0; it must be positive"),
        ({"step": "1ms"}, "step is '1ms', not a number"),
        ({"step": 0.1, "events": 0}, "events is 0; give a whole number"),
        ({"step": 0.1, "outputs": [x]}, "give a mapping of names to expressions"),
        ({"step": 0.1, "outputs": {"pull": sp.Symbol("w_b")}}, "output 'pull' contains w_b.*did you mean v_b"),
    ],
)
def test_arguments_are_checked(arguments, said):
    with pytest.raises(sf.SceneError, match=said):
        sf.export.stepper(SCENES["belt"], **arguments)


@pytest.mark.parametrize("way", [-1, 1])
def test_a_start_at_the_bound_is_decided_by_what_follows(way):
    """The force is exactly the static bound at the start; it falls, and the body stays, or it grows, and it slips."""
    scene = one(sp.Rational(3, 10) * (1 + way * sf.TIME / 10), floor(sf.laws.coulomb(0.3, 0.2)))
    run = sf.export.stepper(scene, 0.1).run()
    assert np.all(run["mode"].values[0, 1:] == (1 if way > 0 else 0))
    assert float(run.x[0, -1]) == pytest.approx(sf.simulate(scene, 1e-11).final[0], rel=1e-9)


def test_samples_happen_at_their_instants_whatever_the_step():
    scene = SCENES["sampled"].wanting({"path": sf.Trajectory()})
    exact = sf.simulate(scene, 1e-12)
    for h in (0.1, 0.04, 0.013):  # whole parts of the period and not
        run = sf.export.stepper(scene, h).run(until=11.0)
        command = run.x.sel(state="c1").values
        assert np.max(np.abs(command - exact(run.t.values + 1e-12)[2])) < 0.2 * h**4
        assert np.count_nonzero(np.diff(command)) == round(11.0 / 0.4 - 0.5)


def test_a_start_at_any_time_knows_which_samples_have_been():
    scene = SCENES["late samples"]
    s, run = sf.export.stepper(scene, 0.01), sf.simulate(scene, 1e-12)
    for begin in (0.005, 0.4, 1.2, 3.333):
        y, now = run.before(begin), begin
        y, m = s.start(y, now, s.values, [], [])
        for _ in range(200):
            y, m, status = s.advance(y, m, now, s.values, [], [], 0.01)
            now += 0.01
            assert status == 0
        assert np.max(np.abs(np.array(y).ravel() - run(now + 1e-12))) < 1e-9


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["kicked", "commanded belt"])
def test_a_slip_that_jumps_ends_sticking_as_in_the_event_driven_run(name):
    run, exact = sf.export.stepper(SCENES[name], 0.01).run(), sf.simulate(SCENES[name], 1e-12)
    t = run.t.values
    step = exact.path.step_of(t)
    clear = (t - exact.path.t[step] > 1e-6) & (exact.path.t[step] + exact.path.h[step] - t > 1e-6)
    assert np.array_equal(run["mode"].values[0][clear], exact.path.mode[step[clear], 0])
    releases = [e.t for e in exact.events if e.before == 0]
    assert np.any(np.isin(np.round(releases, 9), np.round(exact.jumps, 9)))
    assert set(np.unique(run["mode"])) == {-1, 0, 1}


def test_held_inputs_jump_between_steps():
    F = sp.Symbol("F", real=True)
    samples = 0.4 * np.sin(0.9 * np.arange(60))
    belt = sf.Contact("belt", u - 0.2, 1, sf.laws.stribeck(0.4, 0.2, 0.3))
    system = sf.System([x], [u], [[1]], [-x - 0.02 * u + F])
    held = sf.Scene(system, [belt], {}, {x: 0.1, u: 0}, 10.0, inputs={F: sf.Signal(samples, dt=0.4, hold=True)})
    steps = sp.Piecewise(*((float(v), 0.4 * (i + 1) > sf.TIME) for i, v in enumerate(samples)), (0, True))
    written = sf.Scene(replace(system, force=[-x - 0.02 * u + steps]), [belt], {}, {x: 0.1, u: 0}, 10.0)
    coarse, fine = (sf.export.stepper(held, h).error() for h in (0.04, 0.02))
    assert fine < 1e-5
    assert 8 < coarse / fine < 32
    other = sf.export.stepper(written, 0.02).run().x.values
    assert sf.export.stepper(held, 0.02).run().x.values == pytest.approx(other, abs=1e-9)


def test_a_ball_bounces_in_steps_of_any_length_as_in_closed_form():
    e, g, height = 0.8, 9.81, 1.0
    ball = one(sp.Float(-g), start=height, resets=[sf.Reset(guard=x, set={u: -e * u})])
    first, n = np.sqrt(2 * height / g), 6
    bounces = first * np.cumsum([1.0, *(2 * e**k for k in range(1, n))])
    for h in (0.1, 0.013):
        run = sf.export.stepper(ball, h).run(until=np.floor(bounces[-1] / h) * h)
        assert run.status.max() == 0
        k = np.searchsorted(bounces, run.t.values, side="right")
        past, speed = run.t.values - np.append(0.0, bounces)[k], np.where(k == 0, 0.0, g * first * e**k)
        height_then = np.where(k == 0, height, 0.0) + speed * past - g / 2 * past**2
        assert np.max(np.abs(run.x.values[0] - height_then)) < 1e-12


def test_a_crossing_by_a_sample_or_from_outside_counts():
    """A kick that carries the guard across zero sets off the reset; so does a state set between two steps."""
    resets = [sf.Reset(at=[1.0], set={x: x - 2}), sf.Reset(guard=x, set={u: sp.Integer(3)})]
    s = sf.export.stepper(one(sp.Float(0), resets=resets), 0.25)
    run = s.run(until=1.5)
    assert np.allclose(run.x.values, [[1, 1, 1, 1, -1, -0.25, 0.5], [0, 0, 0, 0, 0, 3, 3]], atol=1e-15)
    y, m = s.start(s.initial, 0.0, s.values, [], [])
    y, m, _ = s.advance([-2.0, 0.0], m, 0.0, s.values, [], [], 0.25)
    assert np.array(y).ravel() == pytest.approx([-1.25, 3.0])


def test_a_start_at_a_zero_counts_when_the_expression_leaves_it():
    resets = [sf.Reset(guard=x, set={u: u / 2})]
    for speed, after in ((-1.0, -0.5), (1.0, 1.0)):
        run = sf.export.stepper(one(sp.Float(0), start=0.0, resets=resets).starting({"u": speed}), 0.1).run(until=0.2)
        assert run.x.values[1, -1] == after


def test_more_values_on_their_way_than_places_are_said():
    relay = sf.Held("relay", -sp.sign(x), when=x, delay=30.0, initial=-1, waiting=1)
    run = sf.export.stepper(one(-x, held=[relay]), 0.1).run()
    assert run.status.max() == NOT_FINITE


def test_more_samples_in_a_step_than_it_takes_are_refused():
    with pytest.raises(sf.SceneError, match="5 of their instants fall into it, and it takes events=4"):
        sf.export.stepper(SCENES["sampled"], 2.0)
    assert sf.export.stepper(SCENES["sampled"], 2.0, events=9).run(until=4.0).status.max() == 0


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (lambda s: sf.export.stepper(s, 0.1, events=10**7), "events is 10000000; .* from 1 to 100"),
        (lambda s: sf.export.stepper(s, 0.1).run(until=-1), "until is -1, -10 steps"),
        (lambda s: sf.export.stepper(s, 0.1).error(until=0), "until is 0"),
        (lambda s: sf.export.stepper(s, 0.1).run(until=1e12), r"until is 1e\+12, 1e\+13 steps"),
        (lambda s: sf.laws.iwan(1, -0.5, 1, elements=10**8), "elements of iwan is 100000000; .* from 1 to 1000"),
    ],
)
def test_what_would_not_end_is_refused(asked, words):
    with pytest.raises(sf.SceneError, match=words):
        asked(sf.scenes.mass_on_belt(v_b=0.2))


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="nowhere'$"):
        sf.export.write_c(sf.scenes.mass_on_belt(v_b=0.2), tmp_path / "nowhere" / "belt.c", step=1e-3)
