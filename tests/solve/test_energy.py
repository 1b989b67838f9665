"""The balance of energy: in pieces, beside rates that overflow, and with a force that is not finite."""

import math

import pytest
import sympy as sp

import symfric as sf
from symfric.solve import energy

X, U = sp.symbols("x u", real=True)


@pytest.mark.parametrize("law", [sf.laws.coulomb(0.3, 0.2), sf.laws.square_root(0.2, 0.05)])
@pytest.mark.parametrize("rest", [sp.Rational(1, 2), 0])
def test_a_jerk_of_the_belt_whose_rate_overflows_far_from_it(law, rest):
    jerk = 1 / sp.cosh((sf.TIME - 3) * 250)  # cosh overflows before t = .16
    system = sf.System([X], [U], [[1]], [-X])
    scene = sf.Scene(system, [sf.Contact("b", U - rest - jerk / 2, 1, law)], {}, {X: 0.1, U: 0.1}, 6.0)
    assert sf.simulate(scene).checked().energy_residual() < 1e-8  # 16 nodes a step, where the law has a root


@pytest.mark.parametrize("made", [sf.scenes.mass_on_belt(v_b=0.2), sf.scenes.coulomb_oscillator(0.03)])
def test_pieces_add_up_to_the_whole(made, monkeypatch):
    run = sf.simulate(made)
    whole = run.energy_residual()
    monkeypatch.setattr(energy, "_AT_ONCE", 16 * 2 * 7)
    assert sf.simulate(made).energy_residual() == whole


def test_a_power_that_is_not_finite_shows():
    run = sf.simulate(sf.scenes.mass_on_belt(v_b=0.2))
    power, kinetic = energy.energy_functions(run.scene)
    broken = lambda *given: [math.nan * e for e in power(*given)]  # noqa: E731
    assert math.isnan(energy.imbalance(run, broken, kinetic, run.scene.numbers()))
