"""The balance of energy: in pieces, beside rates that overflow, and with a force that is not finite."""

import copy
import dataclasses
import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve import energy

X, U = sp.symbols("x u", real=True)


@pytest.mark.one_in(4)
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


def drawn(k):
    """Return a scene with kicks, a held command, a stepped force and a stepped belt, of drawn numbers."""
    rng = np.random.default_rng(k)
    cmd = sf.Held("cmd", 1 - X - U / 2, every=float(rng.uniform(0.1, 0.4)), delay=float(rng.uniform(0, 0.6)))
    force = -X + cmd.symbol + sp.Piecewise((0, sf.TIME < float(rng.uniform(1, 9))), (float(rng.uniform(-1, 1)), True))
    belt = U - sp.Piecewise((0.1, sf.TIME < 4), (float(rng.uniform(-0.3, 0.3)), True))
    times = np.sort(rng.uniform(0, 12, 5)).tolist()
    heights = [U + float(h) for h in rng.normal(size=5)]
    resets = [
        sf.Reset(at=times, set={U: heights}),
        sf.Reset(every=float(rng.uniform(0.5, 2)), offset=times[0], set={U: U / 2 + cmd.symbol / 5, X: X + 0.1}),
    ]
    system = sf.System([X], [U], [[1 + sp.cos(X) / 3]], [force])
    contact = sf.Contact("rail", belt, 1, sf.laws.stribeck(0.4, 0.2, 0.3))
    return sf.Scene(system, [contact], {}, {X: 0.1, U: 0.0}, 12.0, held=[cmd], resets=resets)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("k", range(12))
def test_kicks_and_held_forces_are_balanced(k):
    run = sf.simulate(drawn(k), 1e-10).checked()
    assert run.energy_residual() < 1e-10
    assert abs(run.path.ends(np.arange(run.path.t.size - 1)) - run.path.coefficients[1:, :, 0].T).max() > 0.1


def test_kicks_that_a_run_missed_show():
    kick = sf.Reset(at=[2.0], set={U: U + 1})
    plain = sf.Scene(sf.System([X], [U], [[1]], [-X]), [], {}, {X: 0.1, U: 0.1}, 6.0)
    kicked = dataclasses.replace(plain, resets=[kick])
    for taken, told in ((plain, kicked), (kicked, plain)):
        run = copy.copy(sf.simulate(taken))
        vars(run)["base"] = told
        assert run.energy_residual() > 0.1


def test_kicks_at_one_instant_follow_each_other_and_those_at_the_ends_count_as_before_and_after():
    cmd = sf.Held("cmd", X, every=0.5)
    resets = [
        sf.Reset(at=[0, 2, 6], set={U: [U + 1, U + 2, U + 3]}),
        sf.Reset(every=2, set={U: 2 * U + cmd.symbol}),
    ]
    scene = sf.Scene(sf.System([X], [U], [[2]], [-X]), [], {}, {X: 0.1, U: 0.1}, 6.0, held=[cmd], resets=resets)
    assert sf.simulate(scene, 1e-11).checked().energy_residual() < 1e-11


GUARDED = {
    "a ball": (-2 * sp.Rational(981, 100), [sf.Reset(guard=X, set={U: -sp.Rational(4, 5) * U})], 3),
    "an escapement": (-X - U / 50, [sf.Reset(guard=X, set={U: U - 0.1})], 2),
    "a kick across a guard": (
        -X,
        [sf.Reset(guard=U + 2, set={U: 0.5}), sf.Reset(every=3, offset=1, set={U: U - 1.5})],
        7,
    ),
}


@pytest.mark.parametrize("name", GUARDED)
def test_resets_at_guards_are_balanced(name):
    force, resets, least = GUARDED[name]
    scene = sf.Scene(sf.System([X], [U], [[2]], [force]), [], {}, {X: 1.0, U: 0.0}, 20.0, resets=resets)
    run = sf.simulate(scene.until(2.0) if name == "a ball" else scene, 1e-11).checked()
    assert run.jumps.size >= least
    assert run.energy_residual() < 1e-11
    without = copy.copy(run)
    vars(without)["base"] = dataclasses.replace(run.base, resets=resets[1:])
    assert without.energy_residual() > 0.01
