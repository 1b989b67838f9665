"""Derivatives of motions with stiff laws with memory, by an implicit integrator: against the explicit route, differences."""

import pickle

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U, X0 = sp.symbols("x u x_0", real=True)
V, S, C, D = sp.symbols("v_b sigma mu_c D_c", positive=True)
TIMES = np.linspace(0.0, 5.0, 21)
LAWS = {
    "LuGre": sf.laws.lugre(0.4, C, 0.1, S, sp.sqrt(S)),
    "elasto-plastic": sf.laws.elasto_plastic(0.4, C, 0.1, S, sp.sqrt(S), z_ba=0.5 * C / S),
    "Dahl": sf.laws.dahl(C, S),
    "Dahl, sharper": sf.laws.dahl(C, S, 2),
    "Bouc-Wen": sf.laws.bouc_wen(0.1, 0.5, 0.5, 2),
}
NAMES = ("v_b", "mu_c", "sigma", "x_0", "u", "belt.z")


def belt(law, sigma, inputs=None, **outputs):
    system = sf.System([X], [U], [[1]], [-X - U / 10 + sum(inputs or {})])
    contact = sf.Contact("belt", U - V, 1, LAWS[law])
    values = {V: 0.2, S: sigma, C: 0.25, X0: 0.1}
    known = {X0}.union(*(e.free_symbols for e in (*system.expressions, contact)))
    kept = {s: v for s, v in values.items() if s in known}
    return sf.Scene(system, [contact], kept, {X: X0, U: 0.01}, 5.0, outputs or {"end": sf.End()}, inputs or {})


def names_of(scene):
    return [n for n in NAMES if n in {s.name for s in (*scene.values, *scene.system.states)}]


@pytest.mark.one_in(6)
@pytest.mark.parametrize("law", LAWS)
def test_derivatives_are_those_of_the_explicit_route(law):
    outputs = {"x": sf.Samples(X, TIMES), "heat": sf.Integral(sf.dissipated_power("belt")), "end": sf.End()}
    scene = belt(law, 3e3, **outputs)
    names = names_of(scene)
    exact = sf.simulate(scene, 1e-11, route="taylor", sensitivities=names)
    run = sf.simulate(scene, 1e-10, route=sf.Integrators("cvodes"), sensitivities=names)
    assert (run.status, run.route) == (0, "integrators")
    assert run["x"] == pytest.approx(exact["x"], abs=1e-8)
    for name in names:
        reference = exact.output_sensitivities["x"][name]
        assert run.output_sensitivities["x"][name] == pytest.approx(reference, abs=1e-7 * np.max(np.abs(reference)))
        reference = exact.sensitivities[name]
        assert run.sensitivities[name] == pytest.approx(reference, abs=1e-7 * np.max(np.abs(reference)))
        heat = exact.output_sensitivities["heat"]
        assert run.output_sensitivities["heat"][name] == pytest.approx(heat[name], rel=1e-6, abs=1e-9)


def test_a_parameter_that_is_zero_has_a_derivative():
    x, u, c = sp.symbols("x u c", real=True)
    law = sf.laws.lugre(0.4, 0.3, 0.1, 200.0, 5.0, 0.1)
    scene = sf.Scene(
        system=sf.System([x], [u], [[1]], [-x - c * u]),
        contacts=[sf.Contact("belt", u - sp.Rational(1, 5), 1, law)],
        values={c: 0.0},
        initial={x: 1.0, u: 0.0},
        horizon=3.0,
    )
    found, right = (
        sf.simulate(scene, 1e-9, route=route, sensitivities=["c"]).sensitivities["c"]
        for route in (sf.Integrators("cvodes"), "taylor")
    )
    assert np.max(np.abs(right)) > 0.1
    assert found == pytest.approx(right, abs=1e-6)


def test_an_input_changes_its_slope_between_the_samples():
    pull = sp.Symbol("pull", real=True)
    signal = sf.Signal(np.array([0.0, 0.3, -0.2, 0.1, 0.0]), 1.0)
    scene = belt("LuGre", 3e3, {pull: signal}, x=sf.Samples(X, TIMES))
    exact = sf.simulate(scene, 1e-11, route="taylor", sensitivities=["mu_c"]).output_sensitivities["x"]["mu_c"]
    run = sf.simulate(scene, route=sf.Integrators("cvodes"), sensitivities=["mu_c"])
    assert run.output_sensitivities["x"]["mu_c"] == pytest.approx(exact, abs=1e-7 * np.max(np.abs(exact)))


@pytest.mark.long(beside="test_derivatives_are_those_of_the_explicit_route")
def test_extremes_have_the_derivatives_of_the_time_at_which_they_are_taken():
    outputs = {"top": sf.Max(X), "both": sf.HalfRange(X), "size": sf.Max(sp.Abs(X - 1)), "path": sf.Trajectory()}
    scene = belt("LuGre", 3e3, **outputs)
    exact = sf.simulate(scene, 1e-11, route="taylor", sensitivities=["mu_c"])
    run = sf.simulate(scene, 1e-11, route=sf.Integrators("cvodes"), sensitivities=["mu_c"])
    assert run.path.t.size > 10
    for name in ("top", "both", "size"):
        assert run[name] == pytest.approx(exact[name], rel=1e-8)
        assert run.output_sensitivities[name]["mu_c"] == pytest.approx(
            exact.output_sensitivities[name]["mu_c"], rel=1e-5
        )


@pytest.mark.one_in(2)
@pytest.mark.parametrize("sigma", [1e7, 1e8])
def test_stiff_bristles_take_the_implicit_integrator_at_a_cost_like_the_runs(sigma):
    """Differences of fourth order of the run; the cost in steps, of which one with derivatives is not much dearer."""
    scene = belt("LuGre", sigma, x=sf.Samples(X, TIMES[1:]))
    names = ["v_b", "mu_c"]
    program = sf.prepare(scene, 1e-9, sensitivities=names)
    run = program.run()
    plain = sf.prepare(scene, 1e-11)
    assert run.route == plain.run().route == "integrators"
    assert run.stats["steps"] < 4 * plain.run().stats["steps"]
    for name in names:
        value = {s.name: v for s, v in scene.values.items()}[name]
        first, second = (
            (plain.run({name: value + h})["x"] - plain.run({name: value - h})["x"]) / (2 * h) for h in (1e-4, 2e-4)
        )
        differences = (4 * first - second) / 3
        slopes = run.output_sensitivities["x"][name]
        assert slopes == pytest.approx(differences, abs=1e-6 * np.max(np.abs(differences)))


def test_cost_of_derivatives_grows_slowly_with_the_stiffness():
    steps = [sf.simulate(belt("LuGre", s), sensitivities=["mu_c"]).stats["steps"] for s in (1e6, 1e8)]
    assert steps[1] < 2 * steps[0]


@pytest.mark.parametrize("law", ["aging", "slip"])
def test_rate_and_state_by_the_logarithm_of_the_speed(law):
    """A velocity step of a heavy body: mu = mu0 + a ln(V/V0) + b z, whose derivatives are closed."""
    a, b, d, v0, jump = 0.01, 0.015, 1e-5, 1e-6, 10.0
    A, B = sp.symbols("a b", positive=True)
    times = np.linspace(0.5, 20.0, 8) / jump
    contact = sf.Contact("fault", U, 1, sf.laws.rate_and_state(0.6, A, B, D, v0, law))
    mu = {"mu": sf.Samples(-sf.friction_force("fault"), times)}
    start = {X: 0.0, U: jump * v0}
    scene = sf.Scene(sf.System([X], [U], [[1e20]], [0]), [contact], {A: a, B: b, D: d}, start, times[-1], mu)
    run = sf.simulate(scene, sensitivities=["a", "b", "D_c", "fault.z"])
    slipped = jump * v0 * times / d
    decay = np.exp(-slipped)
    if law == "aging":
        age = (1 + (jump - 1) * decay) / jump
        z, by_d, by_z = np.log(age), (jump - 1) * decay * slipped / d / (1 + (jump - 1) * decay), decay / age
    else:
        z, by_d, by_z = np.log(jump) * decay - np.log(jump), np.log(jump) * decay * slipped / d, decay
    found = run.output_sensitivities["mu"]
    assert found["a"] == pytest.approx(np.full(8, np.log(jump)), rel=1e-7)
    assert found["b"] == pytest.approx(z, rel=1e-6)
    assert found["D_c"] == pytest.approx(b * by_d, rel=1e-6, abs=1e-6 * b / d)
    assert found["fault.z"] == pytest.approx(b * by_z, rel=1e-6, abs=1e-9)


def test_a_program_is_pickled_and_mapped_and_takes_other_values():
    scene = belt("LuGre", 1e7, x=sf.Samples(X, TIMES[1:]))
    program = pickle.loads(pickle.dumps(sf.prepare(scene, sensitivities=["mu_c"])))
    batch = program.map({"mu_c": [0.25, 0.2]}, threads=2)
    one = program.run({"mu_c": 0.2})
    assert batch["x"][:, 1] == pytest.approx(one["x"], abs=0)
    assert batch.output_sensitivities["x"]["mu_c"][:, 1] == pytest.approx(one.output_sensitivities["x"]["mu_c"], abs=0)
    wider = program.run({"v_b": 0.21})
    assert wider["x"] == pytest.approx(sf.simulate(scene.where({"v_b": 0.21}))["x"], abs=1e-7)


def test_scenes_that_can_stick_are_refused_with_the_way_out():
    belt_that_sticks = sf.scenes.mass_on_belt(v_b=0.2).wanting({"end": sf.End()})
    with pytest.raises(sf.NoRoute, match="declines: .*use scene.regularised.v_s.; leave route=None"):
        sf.prepare(belt_that_sticks, route=sf.Integrators("cvodes"), sensitivities=["v_b"])


@pytest.mark.long(beside="test_derivatives_are_those_of_the_explicit_route")
def test_limit_cycles_of_stiff_bristles_tend_to_the_softer_ones():
    """The period at 1e7 from the explicit route at 1e3 and 1e4 would differ by their distance to it over ten."""
    law = lambda s: sf.laws.lugre(0.4, 0.25, 0.1, s, s**0.5)  # noqa: E731
    system = sf.System([X], [U], [[1]], [-X - U / 10])

    def scene(s):
        contact = sf.Contact("belt", U - V, 1, law(s))
        return sf.Scene(system, [contact], {V: 0.1}, {X: 0.0, U: 0.0}, 30.0, {"end": sf.End()})

    soft, stiff = sf.limit_cycle(scene(1e4)), sf.limit_cycle(scene(1e7))
    assert stiff.stable
    assert stiff.multipliers[0] == pytest.approx(1.0, abs=1e-7)
    assert abs(stiff.period - soft.period) < 0.03
    assert stiff.half_range[0] == pytest.approx(soft.half_range[0], abs=2e-3)
    run = sf.simulate(stiff.scene.wanting({"end": sf.End()}), 1e-10)
    assert run.final[:2] == pytest.approx(stiff.start[:2], abs=1e-7)
