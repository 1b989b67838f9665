"""Laws that are flat almost everywhere: no estimate from the beginning of a step sees what it leaps over."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

V = sf.SPEED
WIDTH, CENTRE = sp.symbols("width centre", positive=True)
SHAPES = {
    "bump": sp.exp(-(((V - CENTRE) / WIDTH) ** 2)),
    "step": sp.tanh((V - CENTRE) / WIDTH),
    "arctangent": sp.atan((V - CENTRE) / WIDTH),
    "peak": 1 / (1 + ((V - CENTRE) / WIDTH) ** 2),
    "logistic": 1 / (1 + sp.exp((V - CENTRE) / WIDTH)),
}


def excited(law, **values):
    settings = {"v_b": 1.3, "beta": 0.02, "a": 0.3, "Omega": 2.0, "horizon": 6.0, **values}
    return sf.scenes.mass_on_belt(law, **settings)


def distance(scene, tolerance, order=6, finest=1e-11):
    truth = sf.simulate(scene, finest, route=sf.Taylor(order=order))
    run = sf.simulate(scene, tolerance)
    assert run.stats["events"] == truth.stats["events"]
    return np.max(np.abs(run.checked().final - truth.checked().final))


@pytest.mark.one_in(18)
@pytest.mark.parametrize("width", [0.1, 0.01, 0.003])
@pytest.mark.parametrize("shape", SHAPES)
def test_features_away_from_rest_are_not_leapt_over(shape, width):
    law = sf.laws.custom(sp.Rational(3, 10) + SHAPES[shape] / 10, 0.6)
    scene = excited(law).where({"width": width, "centre": 1.0})
    for tolerance in (1e-6, 1e-9):
        assert distance(scene, tolerance) < 20 * tolerance


def test_a_slip_that_turns_after_it_rose_shows_a_law_narrow_about_rest():
    law = sf.laws.gauss(0.43206, 0.07997, mu_s=0.48278, b=0.05)
    scene = excited(law, v_b=0.54793, beta=0.0, a=0.1083, Omega=11.367, horizon=14.51)
    assert distance(scene, 1e-10, order=12, finest=1e-13) < 1e-9


def test_a_feature_moves_with_the_parameters_of_a_law():
    law = sf.laws.custom(0.3 + SHAPES["bump"] / 10, 0.6)
    scene = excited(law).where({"width": 0.01, "centre": 0.9})
    moved = sf.prepare(scene, 1e-9).run({"centre": 1.1}).final
    assert moved == pytest.approx(sf.simulate(scene.where({"centre": 1.1}), 1e-9).final, abs=1e-8)


@pytest.mark.one_in(6)
@pytest.mark.parametrize(("width", "size"), [(0.02, 1.0), (0.005, 1.0), (0.02, 1e4)])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_pulses_are_sought_from_the_tolerance_on(tolerance, width, size):
    """Below the tolerance of a rate of change a pulse may hide between the nodes of `integrators`; above it is found.

    An oscillator with a pulse ``a exp(-((t - 3)/w)^2)`` gets ``a w sqrt(pi) e^(-w^2/4) (sin(T - 3), cos(T - 3))``.
    """
    x, u, a = sp.symbols("x u a", real=True)
    pulse = a * sp.exp(-(((sf.TIME - 3) / width) ** 2))
    scene = sf.Scene(sf.System([x], [u], [[1]], [pulse - x]), [], {a: 0}, {x: size, u: 0}, 6.0)
    program = sf.prepare(scene, tolerance, "integrators")
    none, small, larger, large = (program.run({"a": size * e}) for e in (0.0, 0.1 * tolerance, 10 * tolerance, 1.0))
    assert small.stats["pieces"] == none.stats["pieces"]
    assert larger.stats["pieces"] > none.stats["pieces"]
    gained = width * np.sqrt(np.pi) * np.exp(-(width**2) / 4) * np.array([np.sin(3), np.cos(3)])
    assert large.final - none.final == pytest.approx(size * gained, abs=size * tolerance)
