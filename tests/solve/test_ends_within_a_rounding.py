"""Runs whose pieces end within a rounding of time of the horizon, of a change of an input, or of an output time."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U, A = sp.symbols("x u a", real=True)
PLUGINS = ("erk", "rosenbrock", "cvodes", "idas", "collocation")


def scene_of(law, horizon, inputs=None, **outputs):
    force = -2 * X + sp.sin(3 * sf.TIME) + (A if inputs else 0)
    contact = sf.Contact("b", U - sp.cos(sf.TIME) / 4, 1 + sp.sin(X) / 3, law)
    system = sf.System([X], [U], [[1]], [force])
    return sf.Scene(system, [contact], {}, {X: 0.5, U: -0.3}, horizon, outputs or {"end": sf.End()}, inputs or {})


SMOOTH, DRY = sf.laws.coulomb(0.3).regularised(0.05, "tanh"), sf.laws.coulomb(0.3)


@pytest.mark.one_in(9)
@pytest.mark.parametrize("plugin", PLUGINS)
@pytest.mark.parametrize("roundings", [1, 3, 40])
def test_an_input_changes_within_roundings_of_the_horizon(plugin, roundings):
    """The last segment of the input is so short that its nodes cannot be told apart."""
    horizon = 1.0 + roundings * np.spacing(1.0)
    signal = sf.Signal(np.array([0.0, 0.2, 0.1, 0.0]), 0.5)
    outputs = {"x": sf.Samples(X, [0.25, 1.0, horizon]), "work": sf.Integral(X**2)}
    scene = scene_of(SMOOTH, horizon, {A: signal}, **outputs)
    run = sf.simulate(scene, 1e-6, sf.Integrators(plugin))
    series = sf.simulate(scene, 1e-11, "taylor")
    assert (run.status, run.t_final) == (sf.Status.OK, horizon)
    assert run["x"] == pytest.approx(series["x"], abs=1e-4)
    assert run["work"] == pytest.approx(series["work"], abs=1e-4)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("plugin", ["erk", "rosenbrock"])
@pytest.mark.parametrize("law", [SMOOTH, DRY], ids=["smooth", "dry"])
def test_runs_over_many_horizons_are_complete(plugin, law):
    """Of a few hundred pieces some end a rounding before the horizon, whatever their lengths."""
    program = sf.prepare(scene_of(law, 2.0), 1e-5, sf.Integrators(plugin))
    rng = np.random.default_rng(3)
    for _ in range(6):
        run = program.run(initial={X: rng.uniform(-1, 1), U: rng.uniform(-1, 1)})
        assert (run.status, run.t_final) == (sf.Status.OK, 2.0)


def test_the_horizon_is_a_rounding_after_an_event():
    """A body that stops at t = 1, where its belt stands still, and a run that ends then or next to it."""
    scene = sf.Scene(
        sf.System([X], [U], [[1]], [0]), [sf.Contact("b", U, 1, DRY)], {}, {X: 0, U: 0.3}, 1.0, {"end": sf.End()}
    )
    for horizon in (1.0, np.nextafter(1.0, 0), np.nextafter(1.0, 2), 1 + 1e-15, 1 - 1e-15, 1 + 1e-14):
        run = sf.simulate(scene.until(horizon), 1e-9, sf.Integrators("erk"))
        assert (run.status, run.t_final) == (sf.Status.OK, horizon)
        assert run.final == pytest.approx([0.15, 0.0], abs=1e-9)
