"""Stiff bristles: an implicit integrator is chosen by what explicit steps would cost, and is right on the way, too."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve.integrators.dense_output.refined_grid import cubics, extremes_of, refined
from symfric.solve.integrators.stiffness import explicit_steps
from symfric.solve.lowered import LoweredScene
from tests.longer import longer

X, U = sp.symbols("x u", real=True)
V = sp.Symbol("v_b", positive=True)
TIMES = np.linspace(0.25, 10.0, 40)


def belt(sigma0, horizon=10.0, law=None, **outputs):
    law = law or sf.laws.lugre(0.4, 0.25, 0.1, sigma0, sigma0**0.5)
    system = sf.System([X], [U], [[1]], [-X - U / 10])
    contact = sf.Contact("belt", U - V, 1, law)
    return sf.Scene(system, [contact], {V: 0.2}, {X: 0.0, U: 0.0}, horizon, outputs or {"end": sf.End()})


@pytest.mark.one_in(2)
@pytest.mark.parametrize("sigma0", [1e3, 1e5])
def test_the_number_of_explicit_steps_is_foreseen(sigma0):
    taken = sf.simulate(belt(sigma0), route="taylor").stats["steps"]
    assert explicit_steps(LoweredScene(belt(sigma0))) == pytest.approx(taken, rel=0.3)


def test_scenes_without_memory_are_not_looked_at():
    assert explicit_steps(LoweredScene(sf.scenes.mass_on_belt(v_b=0.2))) == 0.0


def test_only_stiff_bristles_take_the_implicit_integrator_and_explain_says_so():
    soft, stiff = sf.explain(belt(1e4)), sf.explain(belt(1e7))
    assert (soft.route, stiff.route) == ("taylor", "integrators")
    assert "stiff" in stiff.answers["integrators"]
    assert "stiff" in stiff.answers["taylor"]
    run = sf.simulate(belt(1e7))
    assert (run.route, run.settings.plugin) == ("integrators", "cvodes")


@pytest.mark.parametrize("sigma0", longer([3e4, 3e5], [3e5]))
def test_ends_extremes_integrals_and_values_agree_with_the_explicit_route(sigma0):
    outputs = {
        "x": sf.Samples(X, TIMES),
        "top": sf.Max(X),
        "low": sf.Min(sf.friction_force("belt")),
        "heat": sf.Integral(sf.dissipated_power("belt")),
        "path": sf.Trajectory(),
    }
    scene = belt(sigma0, **outputs)
    exact, run = sf.simulate(scene, 1e-11, route="taylor"), sf.simulate(scene, route=sf.Integrators("cvodes"))
    assert run.final == pytest.approx(exact.final, abs=1e-6)
    for name, most in (("x", 1e-6), ("top", 1e-7), ("low", 1e-5), ("heat", 1e-6)):
        assert run[name] == pytest.approx(exact[name], abs=most)
    assert run(TIMES)[0] == pytest.approx(exact["x"], abs=1e-6)
    assert set(np.unique(run.mode)) == {-1, 1}
    assert abs(run.energy_residual()) < 1e-4


def test_cost_grows_slowly_with_the_stiffness():
    steps = [sf.simulate(belt(s)).stats["steps"] for s in (1e6, 1e7, 1e8)]
    assert steps[2] < 2 * steps[0]


def test_stiff_motions_tend_to_the_set_valued_law():
    law = sf.laws.custom(0.25 + 0.15 * sp.exp(-((sf.SPEED / 0.1) ** 2)), 0.4)
    exact = sf.simulate(belt(1, law=law)).final[:2]
    errors = [float(np.max(np.abs(sf.simulate(belt(s)).final[:2] - exact))) for s in (1e6, 1e8)]
    assert errors[1] < 0.25 * errors[0] < 2e-3


def test_cubics_are_exact_for_cubics_and_find_their_extremes():
    t = np.array([0.0, 0.1, 0.5, 0.6, 1.3, 2.0])
    value = np.array([t**3 - 2 * t, (t - 0.7) ** 2])
    c = cubics(t, value)
    s = np.diff(t) / 3
    middle = ((c[..., 3] * s[:, None] + c[..., 2]) * s[:, None] + c[..., 1]) * s[:, None] + c[..., 0]
    at = t[:-1] + s
    assert middle.T == pytest.approx(np.array([at**3 - 2 * at, (at - 0.7) ** 2]), abs=1e-13)
    low, high, at = extremes_of(t, value)
    assert low == pytest.approx([-((2 / 3) ** 1.5) * 2, 0.0], abs=1e-12)
    assert high == pytest.approx([4.0, 1.69], abs=1e-12)
    assert at == pytest.approx(np.array([[np.sqrt(2 / 3), 0.7], [2.0, 2.0]]), abs=1e-12)


def test_nodes_gather_in_layers_and_at_kinks():
    def exact(t):
        return np.array([np.exp(-1e6 * t) + np.abs(t - 1 / 3)])

    t, _ = refined(lambda grid: exact(grid), lambda grid, found: (exact(grid), np.array([1e-7])))
    assert t.size < 2000
    fine = np.concatenate([np.linspace(0, 1e-5, 5000), np.linspace(0, 1, 5001), 1 / 3 + np.linspace(-1e-3, 1e-3, 999)])
    c, k = cubics(t, exact(t)), np.clip(np.searchsorted(t, fine, side="right") - 1, 0, t.size - 2)
    found = sum(c[k, 0, j] * (fine - t[k]) ** j for j in range(4))
    assert np.max(np.abs(found - exact(fine)[0])) < 1e-6


def test_details_without_end_are_an_error():
    rng = np.random.default_rng(1)
    with pytest.raises(RuntimeError, match="details"):
        refined(lambda grid: grid, lambda grid, found: (rng.standard_normal((1, grid.size)), np.array([1e-9])))
