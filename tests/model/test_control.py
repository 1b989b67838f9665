"""Ready controllers against loops in plain Python on a plant whose motion between samples is known."""

import control
import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)


def loop(controller, period, delay, horizon, load=0.0):
    """Return the end of a unit mass under ``load`` and a controller, a function of (x, u) called at every sample."""
    state, command, now = np.array([0.0, 0.0]), 0.0, 0.0
    samples = [(k * period, 1, k) for k in range(int(horizon / period - 1e-9) + 1)]
    acts = [(t + delay, 0, k) for t, _, k in samples if t + delay < horizon]
    waiting = {}
    instants = sorted([*samples, *acts], key=lambda e: (round(e[0], 9), e[1]))
    for time, is_sample, k in [*instants, (horizon, 2, 0)]:
        h, force = time - now, command + load
        state = np.array([state[0] + h * state[1] + h * h / 2 * force, state[1] + h * force])
        now = time
        if is_sample == 1:
            waiting[k] = controller(*state)
            command = waiting[k] if delay == 0 else command
        elif is_sample == 0 and delay:
            command = waiting[k]
    return np.array([*state, command])


class PID:
    """A PID with limits and conditional back-calculation, written as engineers write it."""

    def __init__(self, ref, kp, ki, kd, period, limits):
        self.ref, self.kp, self.ki, self.kd, self.T, self.limits = ref, kp, ki, kd, period, limits
        self.integral = self.last = 0.0

    def __call__(self, position, _speed):
        error = self.ref - position
        proportional = self.kp * error - self.kd * (position - self.last) / self.T
        integral = self.integral + self.ki * self.T * error
        wanted = proportional + integral
        low, high = self.limits
        command = min(max(wanted, low), high)
        self.integral = integral + (command - wanted)  # so much that the command just stands at the limit
        self.last = position
        return command


@pytest.mark.one_in(4)
@pytest.mark.parametrize("k", range(8))
def test_a_pid_with_limits_is_the_loop_that_engineers_write(k):
    rng = np.random.default_rng(k)
    kp, kd, ki = rng.uniform(2, 6), rng.uniform(1, 4), rng.uniform(0.5, 4)
    period, limits = float(rng.uniform(0.02, 0.1)), (-float(rng.uniform(0.2, 0.8)), float(rng.uniform(0.2, 0.8)))
    delay = float(rng.uniform(0, period)) if k % 2 else 0.0
    held = sf.control.pid(x, 1, kp, ki, kd, every=period, delay=delay, limits=limits)
    system = sf.System([x], [u], [[1]], [held[-1].symbol + 0.1])
    extremes = {"low": sf.Min(held[-1].symbol), "high": sf.Max(held[-1].symbol), "path": sf.Trajectory()}
    scene = sf.Scene(system, [], {}, {x: 0.0, u: 0.0}, 9.97, extremes, held=held)
    run = sf.simulate(scene, 1e-13).checked()
    assert limits[0] <= run["low"] < run["high"] == limits[1]
    expected = loop(PID(1, kp, ki, kd, period, limits), period, delay, 9.97, 0.1)
    assert np.max(np.abs(run.final[[0, 1, run.names.index("pid")]] - expected)) < 1e-9


def test_windup_is_what_the_limits_prevent():
    def overshoot(limits, clipped):
        held = sf.control.pid(x, 1, 2.0, 1.5, 2.0, every=0.05, rate=u, limits=limits)
        command = held[-1].symbol if limits else sp.Max(-clipped, sp.Min(clipped, held[-1].symbol))
        scene = sf.Scene(
            sf.System([x], [u], [[1]], [command]), [], {}, {x: -4.0, u: 0.0}, 40.0, {"x": sf.Max(x)}, held=held
        )
        return sf.simulate(scene)["x"]

    assert overshoot((-0.5, 0.5), 0.5) < 0.5 * overshoot(None, 0.5)


def test_friction_compensation_is_zero_within_its_dead_band():
    band, force = 0.05, 0.3
    times = 0.1 * np.arange(1, 80)
    held = sf.control.friction_compensation(u, force, dead_band=band, every=0.1)
    outputs = {"u": sf.Samples(u, times), "c": sf.Samples(held[0].symbol, times + 0.05)}
    system = sf.System([x], [u], [[1]], [-x + held[0].symbol / 10 - u / 20])
    run = sf.simulate(sf.Scene(system, [], {}, {x: 0.3, u: 0.0}, 8.0, outputs, held=held), 1e-11)
    expected = np.where(np.abs(run["u"]) <= band, 0.0, force * np.sign(run["u"]))
    assert np.array_equal(run["c"], expected)
    assert {-force, 0.0, force} == set(run["c"].tolist())


def test_compensation_moves_a_body_further_and_leaves_one_at_rest():
    floor = sf.Contact("floor", u, 1, sf.laws.coulomb(0.3))
    for start, moves in ((0.0, False), (1.0, True)):
        held = sf.control.friction_compensation(u, 0.29, dead_band=1e-3, every=1e-3)
        system = sf.System([x], [u], [[1]], [held[0].symbol])
        plain = sf.Scene(sf.System([x], [u], [[1]], [0]), [floor], {}, {x: 0.0, u: start}, 5.0)
        helped = sf.Scene(system, [floor], {}, {x: 0.0, u: start}, 5.0, held=held)
        far, near = sf.simulate(helped).final[0], sf.simulate(plain).final[0]
        assert far > 2 * near if moves else far == near == 0.0


@pytest.mark.parametrize("shape", ["sine", "square"])
def test_dither_frees_a_body_as_averaging_says(shape):
    a, load, rate, mu = 2.0, 0.1, 400.0, 0.2
    force = load + sf.control.dither(a, rate, shape=shape)
    floor = sf.Contact("floor", u, 1, sf.laws.coulomb(mu))
    scene = sf.Scene(sf.System([x], [u], [[1]], [force]), [floor], {}, {x: 0.0, u: 0.0}, 40.0)
    run = sf.simulate(scene.wanting({"late": sf.Samples(x, [20.0, 40.0])})).checked()
    drift = float(np.diff(run["late"])[0]) / 20
    # the body slips forward for the fraction s of the time with 2 s - 1 = load/mu; its fast velocity is a sine or
    # a triangle of the amplitude v
    share = 0.5 * (1 + load / mu)
    v = a / rate if shape == "sine" else a * np.pi / (2 * rate)
    expected = v * (-np.cos(np.pi * share) if shape == "sine" else 2 * share - 1)
    assert drift == pytest.approx(expected, rel=0.06)


def test_a_dither_may_be_sampled_and_have_symbols():
    a, w = sp.symbols("a w", positive=True)
    wave = sf.control.dither(a, w, phase=1)
    assert wave == a * sp.sin(w * sf.TIME + 1)
    held = sf.Held("shaken", wave - x, every=0.01)
    scene = sf.Scene(
        sf.System([x], [u], [[1]], [held.symbol]), [], {a: 1.0, w: 20.0}, {x: 0.0, u: 0.0}, 1.0, held=[held]
    )
    assert sf.simulate(scene, sensitivities=["a", "w"]).checked().sensitivities["a"].shape == (3,)
    with pytest.raises(sf.SceneError, match="must exceed 0"):
        sf.control.dither(1, 0)
    with pytest.raises(sf.SceneError, match="'sine' or 'square'"):
        sf.control.dither(1, 2, shape="saw")


def stable_system(rng, states, inputs, outputs):
    A = rng.normal(size=(states, states))
    A *= 0.8 / max(0.8, np.max(np.abs(np.linalg.eigvals(A))))
    return control.ss(
        A,
        rng.normal(size=(states, inputs)),
        rng.normal(size=(outputs, states)),
        rng.normal(size=(outputs, inputs)),
        0.25,
    )


def transfer_matrix(rng, inputs, outputs):
    draw = lambda n: rng.uniform(-0.5, 0.5, n).tolist()  # noqa: E731
    num = [[draw(rng.integers(1, 3)) for _ in range(inputs)] for _ in range(outputs)]
    den = [[[1.0, *draw(2)] for _ in range(inputs)] for _ in range(outputs)]
    return control.tf(num, den, 0.25)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("inputs", "outputs"), [(1, 1), (2, 1), (1, 2), (2, 3)])
@pytest.mark.parametrize("kind", ["state space", "transfer functions"])
def test_discrete_systems_of_python_control(kind, inputs, outputs):
    rng = np.random.default_rng(inputs + 10 * outputs)
    system = stable_system(rng, 3, inputs, outputs) if kind == "state space" else transfer_matrix(rng, inputs, outputs)
    measured = [x, u][:inputs]
    held = sf.control.discrete(system, measured, name="y")
    n, times = len(held), 0.25 * np.arange(30)
    wanted = {s.name: sf.Samples(s, times) for s in (x, u)}
    wanted |= {h.name: sf.Samples(h.symbol, times + 0.1) for h in held[n - outputs :]}
    plant = sf.System([x], [u], [[1]], [sp.cos(3 * sf.TIME) - x - u / 3])
    run = sf.simulate(sf.Scene(plant, [], {}, {x: 0.3, u: 0.1}, 8.0, wanted, held=held), 1e-12)
    given = np.array([run[s.name] for s in measured])
    got = np.array([run[h.name] for h in held[n - outputs :]])
    if kind == "state space":
        _, expected = control.forced_response(system, times, given)[:2]
    else:
        pairs = [[(i, j) for j in range(inputs)] for i in range(outputs)]
        parts = lambda i, j: control.tf(system.num[i][j], system.den[i][j], 0.25)  # noqa: E731
        expected = [sum(control.forced_response(parts(*e), times, given[e[1]])[1] for e in row) for row in pairs]
    assert np.max(np.abs(got - np.reshape(expected, got.shape))) < 1e-10


def test_gains_without_states_and_what_is_refused():
    (gain,) = sf.control.discrete(control.tf([2.0], [1.0], 0.1), [x])
    assert gain.update == 2.0 * x
    first = control.tf([1.0], [1.0, -0.5], 0.1)
    for wrong, message in (
        (control.tf([1.0], [1.0, -0.5], True), "no sampling time"),
        (control.tf([1.0], [1.0, 0.5]), "control.c2d"),
        (control.tf([1.0, 0, 0], [1.0, -0.5], 0.1), "input 1 to output 1.*non-proper"),
        (np.eye(2), "is a ndarray"),
    ):
        with pytest.raises(sf.SceneError, match=message):
            sf.control.discrete(wrong, [x])
    with pytest.raises(sf.SceneError, match="inputs has 2 entries, and the system takes 1"):
        sf.control.discrete(first, [x, u])


def test_its_equations_name_what_each_variable_is():
    held = sf.control.pid(x, 1, 2, 3, 4, every=0.25, delay=0.125)
    scene = sf.Scene(sf.System([x], [u], [[1]], [held[-1].symbol]), [], {}, {x: 0, u: 0}, 1.0, held=held)
    command = scene.equations()[-1]
    t = sp.Symbol("t_pid", real=True)
    integral, measured, state, acts = (sp.Function(n, real=True) for n in ("integral_pid", "measured_pid", "x", "pid"))
    expected = integral(t - 0.25) + 16 * measured(t - 0.25) - 18.75 * state(t) + 2.75
    assert command.lhs == acts(t + 0.125)
    assert sp.simplify(command.rhs - expected) == 0
