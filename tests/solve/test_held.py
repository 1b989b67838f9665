"""Held variables and resets against chains of runs between their instants."""

import functools
import itertools
import re

import control
import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
c = sp.Symbol("c", real=True)
K, D, T, tau, tk, dv = sp.symbols("K D T tau tk dv", positive=True)
FORCE = -x / 10 - u / 50
START = {"x": 0.1, "u": 0.0}


def plant(command, horizon=10.0, start=START, values=None, outputs=None, **more):
    system = sf.System([x], [u], [[1]], [FORCE + command])
    rail = sf.Contact("rail", slip=u - 0.05, normal=1, law=sf.laws.stribeck(0.4, 0.3, 0.1))
    return sf.Scene(system, [rail], values or {}, start, horizon, outputs or {"end": sf.End()}, **more)


@functools.cache
def program(length):
    return sf.prepare(plant(c, length, START, {c: 0.5}), 1e-12, "taylor")


def chained(instants, horizon, initial=0.0):
    """Return the end of runs between instants ``(time, change of (state, command))``."""
    state, now, command = dict(START), 0.0, initial
    for time, change in [*sorted(instants, key=lambda e: round(e[0], 9)), (horizon, None)]:
        if time - now > 1e-12:
            run = program(round(time - now, 12)).run({"c": command}, state).checked()
            state, now = dict(zip(("x", "u"), run.final.tolist(), strict=True)), time
        if change is not None:
            command = change(state, command)
    return np.array([*state.values(), command])


def sampled(period, offset, delay, step, horizon):
    """Return the instants of the controller below."""
    memory, waiting, found = [0.0], {}, []

    def sample(k):
        def change(state, command):
            value = 1.5 * (1 - state["x"]) - 0.8 * state["u"] + 0.3 * memory[-1]
            value = value if step is None else step * np.floor(value / step + 0.5)
            memory.append(value)
            waiting[k] = value
            return value if delay == 0 else command

        return change

    for k in range(int((horizon - offset) / period) + 1):
        if delay:
            found.append((offset + delay + k * period, lambda state, command, k=k: waiting[k]))
        found.append((offset + k * period, sample(k)))
    return [(t, e) for t, e in found if t < horizon]


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    ("period", "offset", "delay", "step"),
    [
        (0.7, 0.0, 0.0, None),
        (0.7, 0.2, 0.3, None),
        (0.7, 0.0, 0.7, None),
        (0.7, 0.1, 1.75, None),
        (0.5, 0.0, 0.2, 0.05),
        (0.3, 0.75, 0.1, None),
        (0.3, 0.75, 0.525, None),
    ],
)
def test_a_sampled_controller_is_a_chain_of_runs(period, offset, delay, step):
    previous = sp.Symbol("cmd.previous", real=True)
    cmd = sf.Held("cmd", 1.5 * (1 - x) - 0.8 * u + 0.3 * previous, period, offset, delay, step=step)
    horizon = 6.03
    found = sf.simulate(plant(cmd.symbol, horizon, held=[cmd]), 1e-12).checked()
    instants = sampled(period, offset, delay, step, horizon)
    instants = [e for _, e in sorted(enumerate(instants), key=lambda p: (round(p[1][0], 9), p[0]))]
    assert np.max(np.abs(found.final[:3] - chained(instants, horizon))) < 1e-10


def test_kicks_move_a_body_that_sticks():
    def kick(state, command):
        state["u"] += 0.5
        return command

    resets = [sf.Reset(at=[2.0, 3.5], set={u: [u + 0.5, 0.5 + u]})]
    found = sf.simulate(plant(sp.Float(0.1), resets=resets), 1e-12).checked()
    assert np.max(np.abs(found.final - chained([(2.0, kick), (3.5, kick)], 10.0, 0.1)[:2])) < 1e-10


def test_rates_that_coincide():
    fast = sf.Held("fast", update=-x, every=0.1)
    slow = sf.Held("slow", update=-u - fast.symbol / 2, every=0.3)
    found = sf.simulate(plant(fast.symbol + slow.symbol, 3.05, held=[slow, fast]), 1e-12).checked()
    values = [0.0, 0.0]

    def change(k):
        def take(state, command):
            values[0] = -state["x"]
            values[1] = -state["u"] - values[0] / 2 if k % 3 == 0 else values[1]
            return sum(values)

        return take

    assert np.max(np.abs(found.final[:2] - chained([(k * 0.1, change(k)) for k in range(31)], 3.05)[:2])) < 1e-11


def controlled(**more):
    cmd = sf.Held("cmd", update=K * (1 - x) - D * u, every=T, delay=tau)
    values = {K: 1.5, D: 0.8, T: 0.3, tau: 0.1, tk: 2.0, dv: 0.5}
    kick = sf.Reset(at=[tk], set={u: u + dv})
    return plant(cmd.symbol, 9.95, values=values, held=[cmd], resets=[kick], **more)


def test_derivatives_by_gains_periods_and_delays():
    scene = controlled()
    names = ("K", "D", "T", "tau", "tk", "dv")
    run = sf.simulate(scene, 1e-12, sensitivities=names)
    program, h = sf.prepare(scene, 1e-13), 1e-5
    values = {s.name: v for s, v in scene.values.items()}
    for n in names:
        far, near = (
            (program.run({n: values[n] + s}).final - program.run({n: values[n] - s}).final) / (2 * s)
            for s in (2 * h, h)
        )
        assert np.max(np.abs(run.sensitivities[n] - (4 * near - far) / 3)) < 1e-6


def test_a_scene_with_a_belt_of_commanded_speed_can_be_changed():
    x, u, mu = *sp.symbols("x u", real=True), sp.Symbol("mu", positive=True)
    speed = sf.Held("speed", update=sp.Rational(1, 5) * sp.sign(sp.sin(sf.TIME)), every=0.5)
    belt = sf.Contact("belt", slip=u - speed.symbol, normal=1, law=sf.laws.coulomb(mu))
    scene = sf.Scene(sf.System([x], [u], [[1]], [-x]), [belt], {mu: 0.4}, {x: 0.0, u: 0.0}, 20.0, held=[speed])
    changed = scene.where({"mu": 0.3}).starting({"x": 0.1}).until(10.0).wanting({"most": sf.Max(x)})
    again = scene.where({mu: 0.4}).starting({x: 0.0}).until(20.0)
    assert sf.simulate(changed).checked().outputs["most"] > 0.1
    assert np.array_equal(sf.simulate(again).final, sf.simulate(scene).final)
    assert sf.simulate(changed).energy_residual() < 1e-8


def test_map_equals_runs():
    program = sf.prepare(controlled())
    periods = np.linspace(0.2, 0.4, 20)
    batch = program.map({"T": periods})
    assert np.array_equal(batch.final.T, [program.run({"T": t}).final for t in periods])


def test_a_sweep_over_gain_sampling_time_and_dead_time_equals_runs():
    cmd = sf.Held("cmd", update=K * (1 - x) - 0.8 * u, every=T, delay=tau, waiting=3)
    scene = plant(cmd.symbol, 4.0, values={K: 1.5, T: 0.3, tau: 0.1}, held=[cmd], outputs={"most": sf.Max(x)})
    grid = {"K": [1.0, 2.0], "T": [0.1, 0.25], "tau": [0.02, 0.1, 0.28]}
    swept = sf.sweep(scene, grid)
    assert not swept["status"].any()
    run = sf.prepare(scene).run
    for k, e, d in itertools.product(*grid.values()):
        assert float(swept["most"].sel(K=k, T=e, tau=d)) == run({"K": k, "T": e, "tau": d})["most"]


def late(every, delay, **more):
    values = {s: v for s, v in ((T, 0.3), (tau, more.pop("late", 0.7))) if s in (every, delay)}
    cmd = sf.Held("cmd", update=1.5 * (1 - x) - 0.8 * u, every=every, offset=0.1, delay=delay, **more)
    return plant(cmd.symbol, 5.95, values=values, held=[cmd])


@pytest.mark.one_in(8)
@pytest.mark.parametrize("delay", [0.0, 0.2, 0.3, 0.5, 0.6, 0.75, 0.9])
def test_a_delay_by_parameters_equals_one_by_numbers(delay):
    """With room for three values on their way, also where the delay is a whole number of periods."""
    expected = sf.simulate(late(0.3, delay), 1e-12).final[:3]
    found = sf.prepare(late(T, tau, waiting=3), 1e-12).run({"tau": delay})
    assert np.max(np.abs(found.checked().final[:3] - expected)) < 1e-12


def test_the_places_of_a_delay_by_parameters_are_those_of_the_first_values():
    scene = late(T, tau)
    assert [h.waiting for h in scene.held] == [3]
    assert scene.where({"tau": 0.1}).held == scene.held
    assert np.max(np.abs(sf.simulate(scene).final[:3] - sf.simulate(late(0.3, 0.7)).final[:3])) < 1e-8
    late_values = sf.prepare(scene).map({"tau": [0.25, 0.55, 0.85, 0.95]})
    assert [s == sf.Status.OK for s in late_values.status] == [True, True, True, False]
    assert late_values.status[-1] == sf.Status.QUEUE_FULL
    assert np.array_equal(late_values.final[:, 1], sf.prepare(scene).run({"tau": 0.55}).final)
    with pytest.raises(sf.RunFailed, match="waiting"):
        sf.prepare(controlled()).run({"tau": 0.4}).checked()


def test_derivatives_by_a_delay_beyond_a_period():
    scene, h = late(T, tau), 1e-5
    run, program = sf.simulate(scene, 1e-12, sensitivities=["T", "tau"]), sf.prepare(scene, 1e-13)
    for name, value in (("T", 0.3), ("tau", 0.7)):
        near, far = (
            (program.run({name: value + s}).final - program.run({name: value - s}).final) / (2 * s) for s in (h, 2 * h)
        )
        assert np.max(np.abs(run.sensitivities[name] - (4 * near - far) / 3)) < 1e-6


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("first", "second", "exists"), [(T, T, True), (T, tau, False), (T, 2 * tau, False), (T, 0.5, False)]
)
def test_instants_that_coincide_for_some_values_alone_have_no_derivative(first, second, exists):
    """Which of the two comes first changes there; where they coincide always, the derivative is that of the pair."""
    one = sf.Held("one", 1 - x - u, every=first)
    other = sf.Held("other", sp.Symbol("one", real=True) / 2 - u, every=second)
    command = one.symbol + other.symbol / 4
    values = {s: 0.25 for s in (T, tau) if command.has(s) or any(sp.sympify(e).has(s) for e in (first, second))}
    scene = plant(command, 2.1, values=values, held=[one, other])
    run = sf.simulate(scene, 1e-12, sensitivities=[T])
    assert (run.status == sf.Status.OK) is exists
    if exists:
        ends = [sf.simulate(scene.where({T: 0.25 + h}), 1e-13).final for h in (1e-5, -1e-5)]
        assert np.max(np.abs((ends[0] - ends[1]) / 2e-5 - run.sensitivities["T"])) < 1e-5
    else:
        assert run.status == sf.Status.NO_DERIVATIVE
        assert np.all(np.isnan(run.sensitivities["T"]))


@pytest.mark.long(beside="test_derivatives_by_a_delay_beyond_a_period")
def test_continuation_in_a_delay_beyond_a_period():
    cmd = sf.Held("cmd", update=-2 * x - 0.6 * u, every=0.1, delay=tau)
    scene = plant(cmd.symbol + sp.sin(sp.pi * sf.TIME), 60.0, values={tau: 0.25}, held=[cmd])
    branch = sf.continue_cycle(scene, "tau", span=(0.21, 0.29))
    assert [branch.values[0], branch.values[-1]] == pytest.approx([0.21, 0.29])
    end = sf.limit_cycle(scene.where({"tau": 0.29}))
    assert branch.orbits[-1].half_range[0] == pytest.approx(end.half_range[0], abs=1e-9)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("offset", "delay"), [(0.08, 0.05), (0.02, 0.07), (0.04, 0.25)])
def test_multipliers_of_a_sampled_system(offset, delay):
    cmd = sf.Held("cmd", update=-2 * x - 0.6 * u, every=0.1, offset=offset, delay=delay)
    scene = plant(cmd.symbol + sp.sin(sp.pi * sf.TIME), 100.0, held=[cmd])
    orbit = sf.limit_cycle(scene)
    base = dict(zip(orbit.run.names, orbit.run.x[:, 0], strict=True))
    program = sf.prepare(scene.until(orbit.period), 1e-13)
    end = lambda n, h: program.run({}, {**base, n: base[n] + h}).final  # noqa: E731
    assert np.max(np.abs(end("x", 0.0) - orbit.run.x[:, 0])) < 1e-8
    columns = [
        (4 * (end(n, h) - end(n, -h)) / (2 * h) - (end(n, 2 * h) - end(n, -2 * h)) / (4 * h)) / 3
        for n, h in ((n, 1e-5) for n in base)
    ]
    expected = np.sort(np.abs(np.linalg.eigvals(np.array(columns).T)))
    assert np.max(np.abs(np.sort(np.abs(orbit.multipliers)) - expected)) < 1e-5


def test_a_clock_that_starts_late_has_no_period():
    cmd = sf.Held("cmd", update=-2 * x, every=0.1, offset=0.3)
    with pytest.raises(sf.SceneError, match="no period"):
        sf.limit_cycle(plant(cmd.symbol, held=[cmd]))


def test_many_samples_are_cheap_and_no_events():
    cmd = sf.Held("cmd", update=-x, every=0.1)
    scene = plant(cmd.symbol, 2000.0, held=[cmd]).wanting({"events": sf.Events()})
    run = sf.simulate(scene).checked()
    assert run.stats["steps"] >= 20_000
    assert {e.contact for e in run.events} <= {"rail"}
    assert run.mode.shape[0] == 1 if run.raw.path is not None else True


def test_energy_is_balanced_over_samples():
    cmd = sf.Held("cmd", update=1 - x - u, every=0.3)
    assert (
        abs(sf.simulate(plant(cmd.symbol, held=[cmd]).wanting({"path": sf.Trajectory()}), 1e-11).energy_residual())
        < 1e-8
    )


def test_a_pid_with_limits_reaches_its_reference():
    held = sf.control.pid(x, 1.0, kp=4.0, ki=2.0, kd=3.0, every=0.02, rate=u, limits=(-1.2, 1.2))
    scene = plant(held[-1].symbol, 60.0, held=held).wanting({"high": sf.Max(held[-1].symbol), "end": sf.End()})
    run = sf.simulate(scene).checked()
    assert run["high"] == 1.2
    assert abs(run.final[0] - 1.0) < 0.05


def test_a_discrete_system_of_python_control():
    smooth = control.tf([0.1, 0], [1, -0.9], dt=0.25)
    held = sf.control.discrete(smooth, [x], name="y")
    run = sf.simulate(
        plant(sp.S.Zero, 5.0, held=held).wanting(
            {"x": sf.Samples(x, 0.25 * np.arange(20)), "y": sf.Samples(held[-1].symbol, 0.25 * np.arange(20) + 0.1)}
        ),
        1e-11,
    )
    y = 0.0
    for sample, got in zip(run["x"], run["y"], strict=True):
        y = 0.9 * y + 0.1 * sample
        assert got == pytest.approx(y, abs=1e-9)


def refused(match, error=sf.SceneError, **parts):
    with pytest.raises(error, match=match):
        plant(**{"command": sp.S.Zero, **parts})


def test_what_is_refused():
    a, b = sf.Held("a", c, 0.1), sp.Symbol("b", real=True)
    refused("no value for c", held=[a])
    refused("depend on each other", held=[sf.Held("a", b, 0.1), sf.Held("b", a.symbol, 0.1)])
    refused("two held variables are called 'a'", held=[sf.Held("a", x, 0.1), sf.Held("a", u, 0.2)])
    refused("a is a state; rename the input", held=[a], inputs={c: sf.Signal([0, 1], 1.0), "a": sf.Signal([0, 1], 1.0)})
    refused("which is no state", resets=[sf.Reset(at=[1.0], set={c: 0})])
    refused("held has no such variable", held=[sf.Held("a", sp.Symbol("d.previous", real=True), 0.1)])
    with pytest.raises(sf.SceneError, match="must exceed 0"):
        sf.Held("a", x, every=0.0)
    with pytest.raises(sf.SceneError, match="either its times"):
        sf.Reset(set={u: 0})
    scene = plant(sp.S.Zero, held=[sf.Held("a", x, 0.1)])
    with pytest.raises(sf.NoRoute, match="straight lines"):
        sf.prepare(scene, route="exact")
    with pytest.raises(sf.NoRoute, match="restart the motion"):
        sf.prepare(scene.regularised(1e-2), route=sf.Integrators(plugin="cvodes"))
    for question in (sf.equilibrium, sf.stability, sf.average, sf.separate):
        with pytest.raises(sf.SceneError):
            question(scene)


def test_a_sampled_pd_against_rational_arithmetic():
    cmd = sf.Held("cmd", update=-20 * x - 2 * u, every=0.1)
    rail = sf.Contact("rail", slip=u, normal=1, law=sf.laws.coulomb(0.2))
    scene = sf.Scene(sf.System([x], [u], [[1]], [cmd.symbol]), [rail], {}, {x: 1.0, u: 0.0}, 3.0, held=[cmd])
    assert sf.simulate(scene, 1e-14).final[0] == pytest.approx(0.0795605201999225, abs=1e-14)


@pytest.mark.long(beside="test_kicks_move_a_body_that_sticks")
def test_random_kicks_stick_as_often_as_a_queue_is_empty():
    rate, mean, kicks = 0.8, 0.6, 2560
    rng = np.random.default_rng(5)
    times, sizes = np.cumsum(rng.exponential(1 / rate, kicks)), rng.exponential(mean, kicks)
    parts = zip(times.reshape(-1, 64).tolist(), sizes.reshape(-1, 64).tolist(), strict=True)
    resets = [sf.Reset(at=part, set={u: [u + size for size in heights]}) for part, heights in parts]
    floor = sf.Contact("floor", slip=u, normal=1, law=sf.laws.coulomb(1))
    horizon = float(times[-1])
    scene = sf.Scene(sf.System([x], [u], [[1]], [0]), [floor], {}, {x: 0.0, u: 0.0}, horizon, resets=resets)
    run = sf.simulate(scene).checked()
    stuck = np.sum(np.diff(np.append(run.path.t, horizon))[run.path.mode[:, 0] == 0]) / horizon
    assert stuck == pytest.approx(0.52, abs=0.03)
    assert run.final[0] / horizon == pytest.approx(0.5538, abs=0.08)


def timed(every=0.3, delay=0.1, first=1.0, waiting=None):
    """Return a scene whose instants are parameters."""
    cmd = sf.Held("cmd", update=-x, every=T, delay=tau, waiting=waiting)
    kicks = sf.Reset(at=[tk, 2], set={u: [u + 0.1, u - 0.2]})
    values = {T: every, tau: delay, tk: first}
    rail = sf.Contact("rail", slip=u, normal=1, law=sf.laws.coulomb(0.02))
    system, kept = sf.System([x], [u], [[1]], [cmd.symbol]), {"end": sf.End()}
    return sf.Scene(system, [rail], values, {x: 1.0, u: 0.0}, 3.05, kept, held=[cmd], resets=[kicks])


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"every": 0.0}, "every of 'cmd' is T = 0; it must exceed 0"),
        ({"delay": -0.01}, "delay of 'cmd' is tau = -0.01; it must not be below 0"),
        ({"first": 2.5}, "the times of a reset are 2.5, 2; they must increase"),
        ({"first": -0.5}, "the times of a reset are -0.5, 2; they must increase from 0 on"),
    ],
)
def test_values_that_make_instants_impossible_are_refused(values, said):
    with pytest.raises(sf.SceneError, match=re.escape(said)):
        timed(**values)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("route", ["taylor", "exact", "integrators"])
def test_values_of_a_run_that_make_instants_impossible_end_it(route):
    """A map has no exceptions: such a case has a status. Equal times are none."""
    program = sf.prepare(timed(waiting=1), 1e-9, route)
    assert program.run({"tk": 2.0}).status == sf.Status.OK
    for name, value in (("T", -0.1), ("T", 0.0), ("tau", -0.01), ("tau", 0.5), ("tk", 2.5), ("tk", -0.5)):
        try:
            assert program.run({name: value}).status == sf.Status.QUEUE_FULL, (name, value)
        except sf.SceneError:
            assert route == "integrators"
    if route == "taylor":
        batch = program.map({"tau": [0.1, -0.01, 0.02]})
        assert [s == sf.Status.OK for s in batch.status] == [True, False, True]


def test_guards_that_jump_are_refused():
    for e in (sp.sign(x), sp.Heaviside(x) - 0.5, sp.floor(x)):
        with pytest.raises(sf.SceneError, match="which jumps; give the expression whose zeros are meant"):
            sf.Reset(guard=e, set={u: 0})
        with pytest.raises(sf.SceneError, match="which jumps; give the expression whose zeros are meant"):
            sf.Held("relay", update=-sp.sign(x), when=e)


def test_a_kicked_oscillator_without_friction_by_all_routes():
    """No guard of this scene depends on the state."""
    kicks = sf.Reset(at=[1, 2.5], set={u: [u + 1, -u]})
    free = sf.Scene(sf.System([x], [u], [[1]], [-x]), (), {}, {x: 1.0, u: 0.0}, 5.0, {"end": sf.End()}, resets=[kicks])
    phasor = 1.0 + 0.0j  # x - i u, turned by exp(i t)
    phasor = phasor * np.exp(1j) - 1j
    phasor = np.conj(phasor * np.exp(1.5j)) * np.exp(2.5j)
    expected = [phasor.real, -phasor.imag]
    for route in ("exact", "taylor", "integrators"):
        assert sf.simulate(free, 1e-12, route).checked().final == pytest.approx(expected, abs=1e-10)
