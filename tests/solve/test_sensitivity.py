"""Derivatives through events, against differences of runs, closed forms, and CasADi's own integrator with events."""

import contextlib
import io
import itertools

import casadi as ca
import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
SCENES = sf.scenes
SAMPLED = sf.Signal(2 * np.sin(0.07 * np.arange(400)), 0.02)
CASES = {
    "belt": (SCENES.mass_on_belt(v_b=0.2, horizon=20.0), ("v_b", "beta", "x")),
    "shaken belt": (
        SCENES.mass_on_belt(v_b=0.3, a=0.02, Omega=7.0, horizon=12.0).starting({U: 0.05}),
        ("a", "Omega", "u"),
    ),
    "stop": (SCENES.coulomb_oscillator(0.03, delta_s=0.031), ("delta", "x0")),
    "before the stop": (SCENES.coulomb_oscillator(0.03, delta_s=0.05, horizon=7.0), ("delta", "omega_n")),
    "contact damper": (SCENES.contact_damper(f_n=2.0, mu_m=0.3, zeta=0.05, x0=0.05), ("f_n", "zeta", "r")),
    "drive slide": (SCENES.drive_slide(mu1=-0.4, mu2=0.5, p_star=-0.5, epsilon=0.3), ("mu1", "epsilon")),
    "drive stop": (SCENES.drive_stop(mu1=-0.5, mu2=1.5, lam=2.0), ("mu2", "lam")),
    "two slides": (
        SCENES.two_slides(r=0.5, zeta=2.0, s1=0.2, s2=0.3, fc1=1.0, fs1=7.8, horizon=60.0),
        ("fs1", "s2"),
    ),
    "isolator": (SCENES.rolling_isolator(C=1.0, m=1.0, motion=SAMPLED, profile=0.05), ("C",)),
}


@pytest.mark.one_in(12)
@pytest.mark.parametrize("name", CASES)
def test_derivatives_are_the_limit_of_differences(name):
    """Halved steps: the error of the differences falls to a quarter, and what is left after that is nothing."""
    scene, names = CASES[name]
    q, u = scene.system.q[0], scene.system.u[0]
    outputs = {
        "top": sf.Max(q),
        "size": sf.HalfRange(q),
        "fastest": sf.Max(sp.Abs(u)),
        "work": sf.Integral(u**2),
        "then": sf.At(q, 0.7 * scene.horizon),
        "friction": sf.Integral(sf.friction_force(scene.contacts[0].name) * u),
        "stop": sf.StopTime(),
    }
    scene = scene.wanting(outputs)
    run = sf.simulate(scene, 1e-12, sensitivities=names).checked()
    plain = sf.prepare(scene, 1e-14, route="taylor")
    numbers = {s.name: v for s, v in scene.numbers().items()}
    states = [s.name for s in scene.system.states]

    def difference(key, step):
        ends = []
        for value in (numbers[key] + step, numbers[key] - step):
            other = plain.run(initial={key: value}) if key in states else plain.run(values={key: value})
            ends.append(np.array([*other.final, *(other[o] for o in outputs)]))
        return (ends[0] - ends[1]) / (2 * step)

    for key in names:
        step = 3e-5 * max(1.0, abs(numbers[key]))
        coarse, fine = difference(key, 2 * step), difference(key, step)
        exact = np.array([*run.sensitivities[key], *(run.output_sensitivities[o][key] for o in outputs)])
        known = np.isfinite(fine)
        assert np.array_equal(known, np.isfinite(exact))
        limit = (4 * fine - coarse) / 3
        assert np.allclose(exact[known], limit[known], rtol=2e-9, atol=2e-9)
        falls = np.abs(coarse - exact)[known] > 1e-7
        ratio = np.abs(coarse - exact)[known][falls] / np.abs(fine - exact)[known][falls]
        assert np.allclose(ratio, 4.0, rtol=0.02)


def test_stop_of_a_coulomb_oscillator_in_closed_form():
    """It stops at x0 - 2 n delta with a sign for every half cycle; n does not change, so the slopes are plain."""
    scene = SCENES.coulomb_oscillator(0.03, delta_s=0.031)
    run = sf.simulate(scene, 1e-12, sensitivities=["delta", "x0", "omega_n"])
    halves = int(run.stats["events"])
    sign = (-1) ** halves
    assert run.sensitivities["x0"][0] == pytest.approx(sign, abs=1e-12)
    assert run.sensitivities["delta"][0] == pytest.approx(-2 * halves * sign, abs=1e-10)
    assert run.output_sensitivities["stop_time"]["omega_n"] == pytest.approx(-halves * np.pi, abs=1e-9)
    assert run.output_sensitivities["omega_n"]["stop_time"] == run.output_sensitivities["stop_time"]["omega_n"]


def test_a_second_opinion():
    """CasADi's Runge-Kutta integrator with its own events, of which the first derivatives are right."""
    y, p, t = ca.SX.sym("y", 3), ca.SX.sym("p", 2), ca.SX.sym("t")  # x, u, direction of slip; delta, start
    rate = ca.vertcat(y[1], -y[0] - y[2] * p[0], 0)
    none = ca.SX(0, 1)
    arguments = [ca.SX.sym("index"), t, y, ca.SX.sym("z", 0), p, ca.SX.sym("u", 0)]
    after = ca.Function("after", arguments, [ca.vertcat(y[0], y[1], -y[2]), none], ca.event_in(), ca.event_out())
    dae = {"x": y, "t": t, "p": p, "ode": rate, "zero": y[1] * y[2]}
    options = {"abstol": 1e-12, "reltol": 1e-12, "transition": after}
    with contextlib.redirect_stderr(io.StringIO()):
        flow = ca.integrator("flow", "erk", dae, 0, 8.0, options)
    q = ca.MX.sym("q", 2)
    end = flow(x0=ca.vertcat(q[1], 0, -1), p=q)["xf"][:2]
    theirs = np.array(ca.Function("slopes", [q], [ca.jacobian(end, q)])([0.03, 1.0]))
    scene = SCENES.coulomb_oscillator(0.03, delta_s=0.03, horizon=8.0)
    run = sf.simulate(scene, 1e-12, sensitivities=["delta", "x0"])
    ours = np.column_stack([run.sensitivities[n] for n in ("delta", "x0")])
    assert run.stats["events"] == 2
    assert np.allclose(ours, theirs, atol=1e-8)


def belt_until_it_grazes(excess):
    """An oscillation about x = 0.3 that just reaches the speed of the belt."""
    mu = sf.laws.coulomb(0.5, 0.3)
    return SCENES.mass_on_belt(mu, v_b=0.2, beta=0.0, horizon=6.0).starting({X: 0.1 - excess, U: 0.0})


def test_a_graze_has_no_derivative():
    for excess in (0.0, 1e-13):
        run = sf.simulate(belt_until_it_grazes(excess), 1e-10, sensitivities=["v_b"])
        if run.stats["events"] or run.stats["grazes"]:
            assert run.status == sf.Status.NO_DERIVATIVE
            assert np.all(np.isnan(run.sensitivities["v_b"]))
            with pytest.raises(sf.RunFailed, match="not differentiable"):
                run.checked()
    run = sf.simulate(belt_until_it_grazes(1e-3), 1e-10, sensitivities=["v_b"])
    assert run.status == sf.Status.OK
    assert run.stats["events"] == 2


def test_two_events_at_one_time_have_no_derivative():
    """Two equal blocks that stop together: with different starts, one of them would be the first."""
    x, u = sp.symbols("x1 x2", real=True), sp.symbols("u1 u2", real=True)
    spring = sp.Symbol("spring", positive=True)
    force = [-x[0] + spring * (x[1] - x[0]), -x[1] + spring * (x[0] - x[1])]
    contacts = [sf.Contact(f"floor {k}", slip=u[k], normal=1, law=sf.laws.coulomb(0.3)) for k in (0, 1)]
    initial = {**dict.fromkeys(x, 1.0), **dict.fromkeys(u, 0.0)}
    scene = sf.Scene(sf.System(x, u, sp.eye(2), force), contacts, {spring: 0.5}, initial, 5.0)
    assert sf.simulate(scene, sensitivities=["x1"]).status == sf.Status.NO_DERIVATIVE
    apart = scene.starting({x[0]: 1.05})
    run = sf.simulate(apart, 1e-12, sensitivities=["x1"]).checked()
    ends = [sf.simulate(apart.starting({x[0]: 1.05 + d}), 1e-13).final for d in (1e-5, -1e-5)]
    assert np.allclose(run.sensitivities["x1"], (ends[0] - ends[1]) / 2e-5, atol=1e-8)


def test_a_start_on_the_edge_has_derivatives_only_along_it():
    scene = SCENES.coulomb_oscillator(0.03, delta_s=0.031, horizon=2.0)  # starts at rest and slips at once
    assert sf.simulate(scene, sensitivities=["x0"]).status == sf.Status.OK
    assert sf.simulate(scene, sensitivities=["u"]).status == sf.Status.NO_DERIVATIVE


def test_a_start_that_sticks_forgets_its_slip():
    """A little slip at the start is gone at once: what is left is what the impulse of friction does."""
    scene = SCENES.mass_on_belt(v_b=0.2, horizon=1.0).starting({X: -0.1, U: 0.2})
    run = sf.simulate(scene, 1e-12, sensitivities=["u", "x", "v_b"])
    assert run.stats["events"] == 0
    assert np.allclose(run.sensitivities["u"], 0.0)
    assert np.allclose(run.sensitivities["x"], [1.0, 0.0])
    assert np.allclose(run.sensitivities["v_b"], [1.0, 1.0])


def test_second_derivatives_of_a_smooth_stretch():
    """Of a pendulum on a moving belt that never sticks, against differences of first derivatives."""
    v_b, k = sp.symbols("v_b k", positive=True)
    system = sf.System([X], [U], [[1]], [-k * sp.sin(X) - sp.Rational(1, 10) * U])
    contact = sf.Contact("belt", slip=U - v_b, normal=1, law=sf.laws.stribeck(0.4, 0.25, 0.3))
    outputs = {"work": sf.Integral(X * U**2), "then": sf.At(X, 3.0), "top": sf.Max(X)}
    scene = sf.Scene(system, [contact], {v_b: 2.0, k: 1.3}, {X: 0.1 * k, U: 0.2}, 6.0, outputs)
    names = ["v_b", "k", "u"]
    run = sf.simulate(scene, 1e-13, sensitivities=names, order=2).checked()
    assert run.stats["events"] == 0
    first = sf.prepare(scene, 1e-13, sensitivities=names)
    start = {"v_b": 2.0, "k": 1.3, "u": 0.2}
    for j, name in enumerate(names):
        step, ends = 1e-5, []
        for way in (1, -1):
            value = start[name] + way * step
            ends.append(first.run(initial={name: value}) if name == "u" else first.run(values={name: value}))
        for other in names[: j + 1]:
            pair = (other, name)
            slope = (ends[0].sensitivities[other] - ends[1].sensitivities[other]) / (2 * step)
            assert np.allclose(run.second_sensitivities[pair], slope, rtol=1e-7, atol=1e-8)
            for output in ("work", "then"):
                slopes = [e.output_sensitivities[output][other] for e in ends]
                exact = run.second_output_sensitivities[output][pair]
                assert exact == pytest.approx((slopes[0] - slopes[1]) / (2 * step), rel=1e-6, abs=1e-8)
    assert "top" not in run.second_output_sensitivities


def test_an_event_leaves_no_second_derivative():
    run = sf.simulate(CASES["belt"][0], sensitivities=["v_b"], order=2).checked()
    assert np.all(np.isfinite(run.sensitivities["v_b"]))
    assert np.all(np.isnan(run.second_sensitivities["v_b", "v_b"]))
    with pytest.raises(sf.SceneError, match="order 1 or 2"):
        sf.simulate(CASES["belt"][0], sensitivities=["v_b"], order=3)


def test_errors_at_the_door():
    scene = CASES["belt"][0]
    with pytest.raises(sf.SceneError, match="did you mean v_b"):
        sf.simulate(scene, sensitivities=["vb"])
    with pytest.raises(sf.SceneError, match="twice"):
        sf.simulate(scene, sensitivities=["x", "x"])
    with pytest.raises(sf.SceneError, match="give a sequence"):
        sf.simulate(scene, sensitivities="v_b")
    with pytest.raises(sf.NoRoute, match="'integrators' declines: cvodes has no events"):
        sf.simulate(scene, route="integrators", sensitivities=["v_b"])
    with pytest.raises(sf.SceneError, match="ask for them"):
        _ = sf.simulate(scene).sensitivities


def test_other_values_and_starts_of_one_program():
    program = sf.prepare(CASES["belt"][0].wanting({"end": sf.End()}), 1e-12, sensitivities=["beta"])
    moved = program.run(values={"v_b": 0.3, "a": 0.01, "Omega": 3.0}, initial={"x": 0.1})
    same = sf.simulate(
        CASES["belt"][0].where({"v_b": 0.3, "a": 0.01, "Omega": 3.0}).starting({"x": 0.1}),
        1e-12,
        sensitivities=["beta"],
    )
    assert np.allclose(moved.sensitivities["beta"], same.sensitivities["beta"], rtol=1e-9)


RELEASE = SCENES.mass_on_belt(v_b=0.2, horizon=25.0).starting({X: -0.4, U: 0.2})


@pytest.fixture(scope="module")
def half_range():
    wanted = {"half_range": sf.HalfRange(X), "end": sf.End()}
    return sf.as_function(RELEASE.wanting(wanted), ["v_b", "beta"], ["half_range", "end"])


def test_a_scene_as_a_casadi_function(half_range):
    assert half_range.name_in() == ["v_b", "beta"]
    assert half_range.name_out() == ["half_range", "end"]
    v = ca.MX.sym("v")
    inside = ca.Function("inside", [v], [ca.jacobian(2 * half_range(v_b=v, beta=v / 4)["half_range"], v)])
    step = 1e-5
    ends = [2 * float(half_range(0.2 + d, (0.2 + d) / 4)[0]) for d in (step, -step)]
    assert float(inside(0.2)) == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-8)
    forward, reverse = half_range.forward(1), half_range.reverse(1)
    assert forward.n_out() == 2
    assert reverse.n_out() == 2


@pytest.mark.parametrize("hessian", ["limited-memory", "exact"])
def test_ipopt_drives_a_half_range_to_a_target(half_range, hessian):
    v = ca.MX.sym("v")
    size = half_range(v_b=v, beta=0.05)["half_range"]
    options = {"print_time": 0, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-12}
    problem = {"x": v, "f": 0 * v, "g": size - 0.5}
    solver = ca.nlpsol("solver", "ipopt", problem, {**options, "ipopt.hessian_approximation": hessian})
    found = solver(x0=0.2, lbx=0.05, ubx=0.3, lbg=0, ubg=0)
    reached = sf.simulate(RELEASE.where({"v_b": float(found["x"])}).wanting({"size": sf.HalfRange(X)}), 1e-13)
    assert reached["size"] == pytest.approx(0.5, abs=1e-9)


def test_a_root_finder_takes_it_too(half_range):
    v = ca.MX.sym("v")
    finder = ca.rootfinder("finder", "newton", {"x": v, "g": half_range(v_b=v, beta=0.05)["half_range"] - 0.5})
    assert float(half_range(finder(x0=0.2)["x"], 0.05)[0]) == pytest.approx(0.5, abs=1e-11)


def test_what_cannot_be_a_function():
    scene = RELEASE.wanting({"size": sf.HalfRange(X), "path": sf.Trajectory()})
    with pytest.raises(sf.SceneError, match="Trajectory"):
        sf.as_function(scene, ["v_b"], ["path"])
    with pytest.raises(sf.SceneError, match="did you mean size"):
        sf.as_function(scene, ["v_b"], ["siz"])
    with pytest.raises(sf.SceneError, match="did you mean v_b"):
        sf.as_function(scene, ["v_bb"], ["size"])


def test_what_came_before_a_doubtful_event_keeps_its_derivatives():
    """Two equal blocks that stop together: peaks and values before have derivatives, those after have none."""
    x, u = sp.symbols("x1 x2", real=True), sp.symbols("u1 u2", real=True)
    spring = sp.Symbol("spring", positive=True)
    force = [-x[0] + spring * (x[1] - x[0]), -x[1] + spring * (x[0] - x[1])]
    contacts = [sf.Contact(f"floor {k}", slip=u[k], normal=1, law=sf.laws.coulomb(0.3)) for k in (0, 1)]
    initial = {**dict.fromkeys(x, 1.0), **dict.fromkeys(u, 0.0)}
    outputs = {
        "fastest": sf.Min(u[0]),
        "early": sf.At(x[0], 1.0),
        "late": sf.At(x[0], 4.5),
        "lowest": sf.Min(x[0]),
        "area": sf.Integral(x[0]),
    }
    scene = sf.Scene(sf.System(x, u, sp.eye(2), force), contacts, {spring: 0.5}, initial, 5.0, outputs)
    run = sf.simulate(scene, 1e-12, sensitivities=["x1"])
    assert run.status == sf.Status.NO_DERIVATIVE
    step = 1e-5
    ends = [sf.simulate(scene.starting({x[0]: 1.0 + d}), 1e-13) for d in (step, -step)]
    for name in ("fastest", "early"):
        slope = (ends[0][name] - ends[1][name]) / (2 * step)
        assert run.output_sensitivities[name]["x1"] == pytest.approx(slope, abs=1e-8)
    for name in ("late", "area"):
        assert np.isnan(run.output_sensitivities[name]["x1"])
        assert name in run.advice
    assert "fastest" not in run.advice
    assert np.all(np.isnan(run.sensitivities["x1"]))


def test_peaks_of_a_shaken_building_have_derivatives():
    """Forces of 1e6 N beside slips of 1e-3 m/s: no event of the record is a graze, and every peak has its slope."""
    draw = np.random.default_rng(5)
    motion = sf.motions.synthetic(seed=2, pga=0.3, unit="g")
    scene = SCENES.rolling_isolator(C=5e5, m=3e5, motion=motion, profile=0.001)
    names = ("peak_acceleration", "peak_velocity", "peak_displacement", "residual")
    sensitive, plain = sf.prepare(scene, 1e-10, sensitivities=["C", "mu"]), sf.prepare(scene, 1e-13)
    for _ in range(4):
        values = {"C": draw.uniform(1e3, 1e6), "mu": draw.uniform(1e-3, 0.1)}
        run = sensitive.run(values).checked()
        for name, p in itertools.product(names, values):
            step = 1e-5 * values[p]
            ends = [plain.run({**values, p: values[p] + d})[name] for d in (step, -step)]
            slope = (ends[0] - ends[1]) / (2 * step)
            assert run.output_sensitivities[name][p] == pytest.approx(
                slope, rel=1e-4, abs=1e-6 * abs(run[name] / values[p])
            )


@pytest.mark.one_in(2)
@pytest.mark.parametrize("route", [None, "integrators"])
def test_the_end_has_derivatives_among_the_outputs(route):
    scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=10.0)
    scene = scene.regularised(1e-2, "tanh") if route == "integrators" else scene
    scene = scene.wanting({"end": sf.End()})
    program = sf.prepare(scene, 1e-11, route, sensitivities=["v_b", "x"])
    run, step = program.run(), 1e-6
    found = run.output_sensitivities["end"]
    assert list(found) == ["v_b", "x"]
    for name in found:
        assert np.array_equal(found[name], run.sensitivities[name])
    sides = [sf.simulate(scene.where({"v_b": 0.2 + e * step}), 1e-11, route)["end"] for e in (1, -1)]
    assert found["v_b"] == pytest.approx((sides[0] - sides[1]) / (2 * step), abs=1e-3 if route else 1e-5)


def test_the_end_has_derivatives_in_a_map():
    scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=10.0).wanting({"end": sf.End(), "x": sf.At(X)})
    program, speeds = sf.prepare(scene, sensitivities=["v_b"]), np.array([0.2, 0.25, 0.3])
    batch = program.map(values={"v_b": speeds})
    found = batch.output_sensitivities["end"]["v_b"]
    assert found.shape == batch.outputs["end"].shape == (2, 3)
    assert found[0] == pytest.approx(batch.output_sensitivities["x"]["v_b"], abs=1e-12)
    for k, v_b in enumerate(speeds.tolist()):
        assert found[:, k] == pytest.approx(program.run({"v_b": v_b}).output_sensitivities["end"]["v_b"], abs=1e-12)
