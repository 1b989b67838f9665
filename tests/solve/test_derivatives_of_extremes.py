"""Derivatives of extremes that fall on an event, where a step ends: those of differences, for many values in a row."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
c, A, W, v_b = sp.symbols("c A Omega v_b", positive=True)
STEP = 1e-6
DRIVE = A * sp.cos(W * sf.TIME)


def forced(drag=1, contacts=(), **more):
    system = sf.System([x], [u], [[1]], [-x - c * u * drag + DRIVE])
    extremes = {"m": sf.Min(x), "M": sf.Max(x, after=5), "mm": sf.HalfRange(x, after=10)}
    return sf.Scene(system, contacts, {c: 0.2, A: 0.3, W: 1.3}, {x: 1.0, u: 0.0}, 20.0, outputs={**more, **extremes})


SCENES = {
    "friction": lambda: forced(contacts=[sf.Contact("guide", u, 1, sf.laws.coulomb(0.05))]),
    "static friction": lambda: forced(contacts=[sf.Contact("guide", u, 1, sf.laws.coulomb(0.08, 0.05))]),
    "square of the speed": lambda: forced(sp.Abs(u)),
    "a kink in another output": lambda: forced(z=sf.Mean(sp.Abs(u))),
}


def differences(program, name, values):
    """Return central differences of all outputs, NaN where those of half the step are others."""
    found = []
    for h in (STEP, 0.5 * STEP):
        right, left = (program.map({name: values + s * h}) for s in (1, -1))
        found.append({k: (right[k] - left[k]) / (2 * h) for k in right.outputs})
    coarse, fine = found
    return {k: np.where(np.abs(coarse[k] - fine[k]) < 1e-4 * (1 + np.abs(fine[k])), fine[k], np.nan) for k in fine}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("tolerance", [1e-9, 1e-12])
@pytest.mark.parametrize("name", SCENES)
def test_extremes_where_a_step_ends(name, tolerance):
    values = np.linspace(0.15, 0.25, 800)
    found = sf.prepare(SCENES[name](), tolerance, sensitivities=["c", "A", "Omega"]).map({"c": values})
    expected = differences(sf.prepare(SCENES[name](), 1e-13), "c", values)
    assert np.all(found.status == sf.Status.OK)
    for output in ("m", "M", "mm"):
        derivative, by_differences = found.output_sensitivities[output]["c"], expected[output]
        known = np.isfinite(by_differences)
        assert np.mean(known) > 0.9
        assert derivative[known] == pytest.approx(by_differences[known], abs=2e-4)


def joint(law):
    """A shaken mass on a belt under a load that depends on the place; the friction is largest as sliders begin to slip."""
    belt = sf.Contact("belt", u - v_b, 1 + x**2 / 10, law)
    system = sf.System([x], [u], [[1]], [-x - 0.02 * u + 0.1 * sp.cos(1.3 * sf.TIME)])
    force = sf.friction_force("belt")
    outputs = {"M": sf.Max(force), "E": sf.Max(sf.stored_energy("belt")), "m": sf.Min(force, after=7.3)}
    return sf.Scene(system, [belt], {v_b: 0.2}, {x: 0.1, u: 0.0}, 20.0, outputs=outputs)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "law",
    [
        sf.laws.iwan(2.0, -0.3, 0.4, elements=6),
        sf.laws.iwan(2.0, -0.3, 0.4, elements=2),
        sf.laws.maxwell_slip([1.0, 2.0, 3.0], [0.1, 0.2, 0.3]),
    ],
    ids=["six", "two", "at once"],
)
def test_extremes_at_an_instant_of_several_events(law):
    values = np.array([0.18, 0.2, 0.21])
    found = sf.prepare(joint(law), 1e-11, sensitivities=["v_b"]).map({"v_b": values})
    expected = differences(sf.prepare(joint(law), 1e-13), "v_b", values)
    for output in expected:
        known = np.isfinite(expected[output])
        assert known.any()
        derivative = found.output_sensitivities[output]["v_b"]
        assert derivative[known] == pytest.approx(expected[output][known], abs=1e-4)


@pytest.mark.parametrize("tolerance", [1e-9, 1e-12])
def test_no_derivative_where_a_direction_turns_within_the_error_of_a_stop(tolerance):
    y, w = sp.symbols("y w", real=True)
    belt = sf.Contact("belt", (u - v_b, w), 1 + x**2 / 10, sf.laws.stribeck(0.4, 0.2, 0.3))
    force = [-x - 0.02 * u + 0.3 * sp.cos(1.3 * sf.TIME), -1.7 * y - 0.02 * w]
    outputs = {"m": sf.Min(sf.friction_force("belt", 0)), "top": sf.Max(x)}
    system, start = sf.System([x, y], [u, w], sp.eye(2), force), {x: 0.1, u: 0, y: 0.3, w: 0.1}
    scene = sf.Scene(system, [belt], {v_b: 0.2}, start, 20.0, outputs=outputs)
    run = sf.simulate(scene, tolerance, sensitivities=["v_b"])
    assert np.isnan(run.output_sensitivities["m"]["v_b"])
    expected = differences(sf.prepare(scene, 1e-13), "v_b", np.array([0.2]))["top"][0]
    assert run.output_sensitivities["top"]["v_b"] == pytest.approx(expected, abs=1e-4)
