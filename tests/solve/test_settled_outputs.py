"""Outputs of the settled part of a run: closed forms, dense evaluation, derivatives, cases, routes and refusals."""

import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve.integrators.route import Integrators
from symfric.solve.status import Status
from symfric.solve.taylor.route import Taylor

X, U = sp.symbols("x u", real=True)
K, D, F, W = sp.symbols("k d F w", positive=True)
BELT = sf.scenes.mass_on_belt(v_b=0.2)
V_B = BELT.parameter("v_b")


def oscillator(force, values=None, *, x=1.0, u=0.0, horizon=20.0):
    system = sf.System([X], [U], [[1]], [force])
    return sf.Scene(system, [], values or {}, {X: x, U: u}, horizon)


def two_masses(rng):
    """Two masses on two rough floors, the second one pushed: events of all kinds, coupled."""
    y, w = sp.symbols("y w", real=True)
    k, c, a, omega, mu = rng.uniform([0.5, 0.01, 0.8, 0.6, 0.1], [2.0, 0.1, 1.6, 1.4, 0.3])
    push = a * sp.cos(omega * sf.TIME)
    system = sf.System([X, y], [U, w], sp.eye(2), [-X - k * (X - y) - c * U, k * (X - y) + push])
    floors = [sf.Contact("one", U, 1, sf.laws.coulomb(mu)), sf.Contact("two", w, 1, sf.laws.coulomb(1.2 * mu, mu))]
    return sf.Scene(system, floors, {}, {X: 0.3, y: 0.0, U: 0.0, w: 0.0}, 40.0)


def dense(run, after, n=60):
    """Times, weights of Gauss and states within every part of a step that counts."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    ends = np.unique(np.concatenate([[after], run.t[run.t > after], [run.t_final]]))
    a, b = ends[:-1, None], ends[1:, None]
    t, w = (a + b) / 2 + (b - a) / 2 * nodes, (b - a) / 2 * weights
    fine = np.concatenate([np.linspace(l, r, n) for l, r in zip(ends[:-1], ends[1:], strict=True)])
    return t.ravel(), w.ravel(), fine


def settled(e, after):
    return {
        "max": sf.Max(e, after),
        "min": sf.Min(e, after=after),
        "half": sf.HalfRange(e, after),
        "mean": sf.Mean(e, after),
        "rms": sf.RMS(e, after),
        "period": sf.Period(e, after),
    }


@pytest.mark.parametrize("route", ["taylor", "exact"])
@pytest.mark.parametrize("after", [0.0, 2.9, 11.3])
def test_harmonic_motion_in_closed_form(after, route):
    k, T = 2.25, 20.0
    w = math.sqrt(k)
    outputs = settled(X, after) | {"path": sf.Trajectory()}
    if route == "exact":  # which counts no crossings of one mass in closed form, and takes no integrals
        outputs = {n: o for n, o in settled(X, 0.0).items() if n in ("max", "min", "half")}
    run = sf.simulate(oscillator(-K * X, {K: k}, horizon=T).wanting(outputs), 1e-13, route=route).checked()
    assert run["max"] == pytest.approx(1.0, abs=1e-12)
    assert run["half"] == pytest.approx(1.0, abs=1e-12)
    if route == "exact":
        return
    sine, cosine = math.sin(w * T) - math.sin(w * after), math.sin(2 * w * T) - math.sin(2 * w * after)
    assert run["mean"] == pytest.approx(sine / w / (T - after), abs=1e-12)
    assert run["rms"] ** 2 == pytest.approx(0.5 + cosine / (4 * w) / (T - after), abs=1e-12)
    assert run["period"] == pytest.approx(2 * math.pi / w, abs=1e-12)


def test_a_decaying_motion_counts_from_its_time_on():
    d, w, after = 0.2, 1.0, 9.0
    scene = oscillator(-X - D * U, {D: d}, horizon=30.0).wanting({"late": sf.Max(X, after=after), "all": sf.Max(X)})
    run = sf.simulate(scene, 1e-13)
    rate, damped = d / 2, math.sqrt(w - d * d / 4)
    peak = math.exp(-rate * 4 * math.pi / damped)  # the second return, at t = 4 pi / damped > 9
    assert run["late"] == pytest.approx(peak, abs=1e-12)
    assert run["all"] == 1.0
    falling = sf.simulate(scene.wanting({"edge": sf.Max(X, after=13.5), "path": sf.Trajectory()}), 1e-13)
    assert falling["edge"] == pytest.approx(falling(13.5)[0], abs=1e-12)  # an extreme at the begin itself


@pytest.mark.one_in(6)
@pytest.mark.parametrize("seed", range(6))
def test_random_scenes_agree_with_their_dense_output(seed):
    rng = np.random.default_rng(seed)
    scene = BELT.where({"v_b": rng.uniform(0.05, 0.45)}).until(60.0) if seed % 2 else two_masses(rng)
    after = rng.uniform(10.0, 30.0)
    expressions = {"x": X - 0.2, "u": U, "mixed": X * U + sp.cos(3 * X), "size": sp.Abs(U)}
    wanted = {f"{n} {kind}": o for n, e in expressions.items() for kind, o in settled(e, after).items()}
    run = sf.simulate(scene.wanting({"path": sf.Trajectory(), **wanted}), 1e-11).checked()
    nodes, weights, fine = dense(run, after)
    for name, e in expressions.items():
        of = sp.lambdify((X, U), e)
        f, g = of(*run(nodes)[[0, len(scene.system.q)]]), of(*run(fine)[[0, len(scene.system.q)]])
        high, low, span = run[f"{name} max"], run[f"{name} min"], run.t_final - after
        assert high >= g.max() - 1e-12
        assert high == pytest.approx(g.max(), abs=3e-3 * (high - low))
        assert low == pytest.approx(g.min(), abs=3e-3 * (high - low))
        assert run[f"{name} half"] == pytest.approx((high - low) / 2, abs=1e-15)
        smooth = 1e-10 if name != "size" else 1e-4  # quadrature over the kinks of |u|
        assert run[f"{name} mean"] == pytest.approx(weights @ f / span, abs=smooth)
        assert run[f"{name} rms"] == pytest.approx(math.sqrt(weights @ f**2 / span), abs=1e-9)
        sign = np.sign(np.where(np.abs(g) <= 1e-11, 0.0, g))
        kept = sign != 0
        rising = np.flatnonzero(np.diff(sign[kept]) > 0)
        t = fine[kept][rising]
        if t.size > 1 and name != "size":
            assert run[f"{name} period"] == pytest.approx((t[-1] - t[0]) / (t.size - 1), abs=0.1 / (t.size - 1))


def test_period_and_amplitude_of_stick_slip_are_those_of_the_limit_cycle():
    u = BELT.system.u[0]
    orbit = sf.limit_cycle(BELT, tolerance=1e-11)
    run = sf.simulate(BELT.until(300.0).wanting({"T": sf.Period(u, 150), "a": sf.HalfRange(X, 150)}), 1e-12)
    assert run["T"] == pytest.approx(orbit.period, abs=1e-9)
    assert run["a"] == pytest.approx(orbit.half_range[0], abs=1e-9)


def test_a_period_counts_jumps_and_does_not_count_touches():
    force = sf.friction_force("belt")  # jumps with the slip, which changes sign where the belt is slow
    slow = sf.scenes.mass_on_belt(sf.laws.coulomb(0.03), v_b=0.05, beta=0.0).starting({"x": 1.0}).until(40.0)
    run = sf.simulate(slow.wanting({"T": sf.Period(force), "touch": sf.Period(sf.slip("belt"))}), 1e-11)
    assert run["T"] == pytest.approx(2 * math.pi, abs=0.5)
    touching = sf.simulate(BELT.wanting({"T": sf.Period(sf.slip("belt"))}), 1e-11)  # reaches zero, and stays below
    assert math.isnan(touching["T"])
    still = sf.simulate(oscillator(sp.Integer(0) * X, x=0.0).wanting({"T": sf.Period(X)}))
    assert math.isnan(still["T"])


def slopes_by_differences(scene, names, step=1e-5):
    program, found = sf.prepare(scene, 1e-13), {}
    for name in names:
        at = float(scene.numbers()[scene.parameter(name)])
        ends = [program.run({name: at + s * step}).outputs for s in (-1, 1)]
        found[name] = {o: (ends[1][o] - ends[0][o]) / (2 * step) for o in ends[0]}
    return found


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "scene",
    [BELT.until(50.0), oscillator(-K * X - D * U + F * sp.cos(W * sf.TIME), {K: 1.3, D: 0.1, F: 0.4, W: 0.8})],
    ids=["stick-slip", "forced"],
)
def test_derivatives_agree_with_differences(scene):
    names = ["v_b", "beta"] if scene.contacts else ["k", "d", "w"]
    after = 17.3 if scene.contacts else 5.1
    wanted = settled(X - 0.1, after) | {"speed": sf.Period(U, after)}
    if scene.contacts:
        wanted |= {"pull": sf.Mean(sf.friction_force("belt"), after), "work": sf.RMS(sf.friction_force("belt"), after)}
    scene = scene.wanting(wanted)
    run = sf.prepare(scene, 1e-12, sensitivities=names).run().checked()
    for name, slopes in slopes_by_differences(scene, names).items():
        for output, slope in slopes.items():
            assert run.output_sensitivities[output][name] == pytest.approx(slope, rel=2e-5, abs=2e-6), output


def test_second_derivatives_of_a_root_mean_square():
    k, d, T, after = 1.3, 0.2, 6.0, 2.0
    scene = oscillator(-K * X - D * U, {K: k, D: d}, horizon=T).wanting({"r": sf.RMS(X, after), "m": sf.Mean(X, after)})
    run = sf.prepare(scene, 1e-13, sensitivities=["k", "d"], order=2).run()
    first = sf.prepare(scene, 1e-13, sensitivities=["k", "d"])
    for a, b in [("k", "k"), ("k", "d"), ("d", "d")]:
        at, ends = {"k": k, "d": d}[b], []
        for s in (-1e-4, 1e-4):
            ends.append(first.run({b: at + s}).output_sensitivities)
        for name in "rm":
            difference = (ends[1][name][a] - ends[0][name][a]) / 2e-4
            assert run.second_output_sensitivities[name][a, b] == pytest.approx(difference, abs=1e-7)


def test_many_cases_are_their_runs():
    u = BELT.system.u[0]
    wanted = settled(X - 0.2, 20.0) | {"T": sf.Period(u, 20.0)}
    program, v_b = sf.prepare(BELT.until(60.0).wanting(wanted)), np.array([0.1, 0.2, 0.3, 0.9])
    batch = program.map({"v_b": v_b}, threads=2)
    for k, v in enumerate(v_b):
        assert {n: row[k] for n, row in batch.outputs.items()} == pytest.approx(
            program.run({"v_b": v}).outputs, nan_ok=True
        )
    varied = sf.prepare(BELT.until(60.0).wanting(wanted), sensitivities=["v_b"])
    slopes = varied.map({"v_b": v_b[:3]}).output_sensitivities
    one = varied.run({"v_b": 0.2}).output_sensitivities
    assert {n: row["v_b"][1] for n, row in slopes.items()} == pytest.approx(one["v_b"])


def test_a_failed_run_has_no_settled_outputs():
    scene = BELT.wanting({"a": sf.HalfRange(X, 50.0), "T": sf.Period(U, 50.0)})
    few = sf.prepare(scene, route=Taylor(max_steps=20)).run()
    assert few.status == Status.STEP_BUDGET
    assert math.isnan(few["a"])
    assert math.isnan(few["T"])


@pytest.mark.long(beside="test_the_linear_form_agrees")
@pytest.mark.parametrize("plugin", ["cvodes", "rosenbrock"])
def test_the_integrators_agree(plugin):
    wanted = {n: o for n, o in settled(X, 13.7).items() if n != "period"}
    scene = BELT.until(40.0).regularised(1e-2, shape="tanh").wanting(wanted)
    own = sf.simulate(scene, 1e-9, route="taylor")
    other = sf.simulate(scene, 1e-7, route=Integrators(plugin=plugin))
    assert other.outputs == pytest.approx(own.outputs, abs=2e-5)
    with pytest.raises(sf.NoRoute, match="'T' is a period, for the route 'taylor'"):
        sf.prepare(scene.wanting({"T": sf.Period(U)}), route="integrators")


def test_the_linear_form_agrees():
    outputs = {n: o for n, o in settled(X, 12.5).items() if n != "rms"}  # which is not linear
    scene = two_masses(np.random.default_rng(7)).wanting(outputs)
    runs = [sf.simulate(scene, 1e-11, route=route).checked() for route in ("taylor", "exact")]
    assert runs[0].outputs == pytest.approx(runs[1].outputs, abs=1e-8)


def test_closed_forms_decline_a_part_of_the_run():
    alone = sf.scenes.coulomb_oscillator(0.05)
    assert sf.explain(alone.wanting({"x": sf.Max(X)})).route == "exact"
    for output in (sf.Max(X, after=1.0), sf.Mean(X), sf.Period(X)):
        assert sf.simulate(alone.wanting({"x": output})).route == "taylor"


@pytest.mark.parametrize("kind", [sf.Max, sf.Min, sf.HalfRange, sf.Mean, sf.RMS, sf.Period])
def test_wrong_times_are_refused(kind):
    with pytest.raises(sf.SceneError, match=f"after of {kind.__name__} is -1; it must not be negative"):
        kind(X, after=-1.0)
    with pytest.raises(sf.SceneError, match=f"after of {kind.__name__}"):
        kind(X, after=math.nan)
    for late in (100.0, 150.0):
        with pytest.raises(sf.SceneError, match=f"output 'x' counts after t = {late:g}, and the run ends at"):
            BELT.wanting({"x": kind(X, after=late)})


def test_scene_files_have_them(tmp_path):
    text = '[scene]\nmodel = "mass_on_belt"\nhorizon = 60.0\n[values]\nv_b = 0.2\n[outputs]\na = "{}"\n'
    file = tmp_path / "belt.toml"
    for words, output in {
        "half_range(x, after=20)": sf.HalfRange(X, 20.0),
        "rms(max(x, u), after = 2e1)": sf.RMS(sp.Max(X, U), 20.0),
        "mean(x)": sf.Mean(X),
        "period(u, after=20)": sf.Period(U, 20.0),
    }.items():
        file.write_text(text.format(words))
        assert sf.read(file).outputs["a"] == output
    for words, said in {
        "max(x, 20)": "max takes one expression, and after=NUMBER behind a comma, not '20'",
        "period(u, after=soon)": "period takes one expression, and after=NUMBER",
        "mean(x, after=-2)": "after of Mean is -2",
        "mean(x, after=60)": "counts after t = 60",
    }.items():
        file.write_text(text.format(words))
        with pytest.raises(sf.SceneError, match=said):
            sf.read(file)


def test_a_period_has_the_unit_of_time():
    scene = sf.Scene(
        sf.System([X], [U], [[1]], [-K * X]), [], {K: 1.0}, {X: 1.0, U: 0.0}, 20.0,
        outputs={"T": sf.Period(U), "r": sf.RMS(U), "list": sf.Events()}, units={"x": "mm", "u": "mm/s", "t": "s"},
    )  # fmt: skip
    page = sf.simulate(scene)._repr_html_()
    assert "T [s]" in page
    assert "r [mm/s]" in page


def test_a_function_of_settled_outputs_has_their_derivatives():
    scene = BELT.until(60.0).wanting({"T": sf.Period(BELT.system.u[0], 20.0), "r": sf.RMS(X, 20.0)})
    function = sf.as_function(scene, inputs=["v_b"], outputs=["T", "r"])
    run = sf.simulate(scene.where({"v_b": 0.25}), sensitivities=["v_b"])
    assert [float(e) for e in function(0.25)] == pytest.approx([run["T"], run["r"]], rel=1e-12)
    slopes = function.jacobian()(0.25, *function(0.25))
    assert [float(e) for e in slopes] == pytest.approx([run.output_sensitivities[n]["v_b"] for n in "Tr"], rel=1e-9)
