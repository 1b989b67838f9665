"""Means over fast vibration without closed form: short series against mpmath, derivatives too, and what they cost."""

import casadi as ca
import mpmath as mp
import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.lower.automaton import lower
from symfric.lower.averaged_series import without_integrals
from symfric.lower.chebyshev import ChebyshevSeries, chebyshev
from symfric.lower.printer import Printer, Switches
from tests.longer import longer

L, V, Q = sf.laws, sf.SPEED, sp.Symbol("q", positive=True)
LAWS = {
    "stribeck": (L.stribeck(0.4, 0.25, 0.2, b=0.02), lambda s: 0.25 + 0.15 * mp.exp(-s / 0.2) + 0.02 * s),
    "narrow stribeck": (L.stribeck(0.4, 0.25, 0.01), lambda s: 0.25 + 0.15 * mp.exp(-s / 0.01)),
    "exponential": (L.exponential(0.3, 1.5), lambda s: 0.3 * mp.exp(-s / 1.5)),
    "gauss": (L.gauss(0.3, 0.5, b=0.02), lambda s: 0.3 * mp.exp(-((s / 0.5) ** 2)) + 0.02 * s),
    "lorentz": (L.lorentz(0.3, 0.5, b=0.02), lambda s: 0.3 / (1 + (s / 0.5) ** 2) + 0.02 * s),
    "square root": (L.square_root(0.3, -0.1, b=0.02), lambda s: 0.3 - 0.1 * mp.sqrt(s) + 0.02 * s),
    "custom": (L.custom(0.3 / (1 + V), 0.35), lambda s: 0.3 / (1 + s)),
    "piecewise": (
        L.piecewise_linear(0.4, [0, 0.2, 0.5], [0.35, 0.25, 0.3]),
        lambda s: 0.35 - 0.5 * s if s < 0.2 else 0.25 + (s - 0.2) / 6,
    ),
    "regularised": (
        L.stribeck(0.4, 0.25, 0.2).regularised(0.02),
        lambda s: 20 * s if s < 0.02 else 0.25 + 0.15 * mp.exp(-(s - 0.02) / 0.2),
    ),
    "tanh": (
        L.stribeck(0.4, 0.25, 0.2).regularised(0.02, "tanh"),
        lambda s: (0.25 + 0.15 * mp.exp(-s / 0.2)) * mp.tanh(s / 0.02),
    ),
}


def mean(formula, breaks, v, q):
    """<sgn(w) mu(|w|)> with w = v - q cos(theta), to 20 digits, split where w passes zero or a break."""
    levels = [0, *breaks, *(-b for b in breaks)]
    splits = sorted(mp.acos((v - w) / q) for w in levels if abs(v - w) < q)
    return mp.quad(lambda a: mp.sign(v - q * mp.cos(a)) * formula(abs(v - q * mp.cos(a))), [0, *splits, mp.pi]) / mp.pi


def evaluated(law, q):
    """Return the lowered mean and its slope as a function of numbers."""
    v = ca.SX.sym("v")
    short = without_integrals(law.averaged(q).kinetic)
    assert not short.has(sp.Integral)
    value = Printer({V: v}, set(), Switches())(short)
    return ca.Function("mean", [v], [value, ca.jacobian(value, v)])


@pytest.mark.one_in(12)
@pytest.mark.parametrize("name", LAWS)
def test_values_and_slopes_are_those_of_the_mean(name):
    law, formula = LAWS[name]
    q, breaks = 0.3, [mp.mpf(float(b)) for b in law.breaks]
    short = evaluated(law, q)
    with mp.workdps(20):
        for share in (1e-6, 0.03, 0.5, 0.97, 1 - 1e-5, 1 + 1e-5, 1.2, 4.0):
            v = mp.mpf(float(q * share))
            value, slope = (float(e) for e in short(float(v)))
            h = mp.mpf("1e-3") * abs(v - q if share < 1 else q - v)
            below, at, above = (mean(formula, breaks, v + k * h, mp.mpf(q)) for k in (-1, 0, 1))
            assert value == pytest.approx(float(at), abs=2e-12)
            assert slope == pytest.approx(float((above - below) / (2 * h)), rel=3e-6, abs=3e-6)  # of the difference


def test_closed_forms_of_the_mean():
    from scipy.special import dawsn, i0

    slope = 2 / (np.pi * 0.3) - 4 * dawsn(0.3 / 0.5) / (np.pi * 0.5)
    assert float(evaluated(L.gauss(0.3, 0.5), 0.3)(1e-9)[1]) == pytest.approx(0.3 * slope, rel=1e-11)
    exponential, above = evaluated(L.exponential(0.4, 0.8), 0.3), 0.4 * np.exp(-0.5 / 0.8) * i0(0.3 / 0.8)
    assert float(exponential(0.5)[0]) == pytest.approx(above, rel=1e-13)
    assert float(exponential(0.5)[1]) == pytest.approx(-above / 0.8, rel=1e-12)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", ["stribeck", "gauss", "lorentz", "exponential"])
def test_the_mean_vanishes_exactly_at_rest(name):
    assert float(evaluated(LAWS[name][0], 0.3)(0)[0]) == 0


SHORT = [("square root", 0.01), ("lorentz", 5.0), ("tanh", 5.0), ("piecewise", 1.0)]


@pytest.mark.long(beside="test_means_of_means_are_short_too")
@pytest.mark.parametrize("case", longer(SHORT, SHORT[1:3]))
def test_no_integral_is_left_and_the_graph_is_short(case):
    name, q = case
    assert evaluated(LAWS[name][0], q).n_instructions() < 4000


def test_means_of_means_are_short_too():
    twice = L.coulomb(0.4).averaged(0.3).averaged(0.1)
    speeds = np.array([0.05, 0.15, 0.25, 0.35, 0.45, 1.0])
    short = evaluated(L.coulomb(0.4).averaged(0.3), 0.1)
    assert np.array(short(speeds[None])[0]).ravel() == pytest.approx(twice(speeds), abs=1e-11)


def test_a_parameter_inside_the_integral_keeps_it():
    kinetic = L.stribeck(0.4, 0.25, 0.2).averaged(Q).kinetic
    assert without_integrals(kinetic) == kinetic
    outside = kinetic.subs(Q, sp.Float(0.3)) + sp.Symbol("b") * V
    assert not without_integrals(outside).has(sp.Integral)
    assert sp.Symbol("b") in without_integrals(outside).free_symbols


def test_a_function_that_is_not_smooth_has_no_series():
    assert chebyshev(lambda above, _: np.abs(np.sin(40 * above)), V, 0.0, 3.0) is None
    assert chebyshev(lambda above, _: np.where(above > 1, np.nan, above), V, 0.0, 3.0) is None


def test_pieces_share_one_series():
    found = chebyshev(lambda above, _: 1 / (1 + 8 * (above - 0.4) ** 2), V, 0.5, 3.0)
    (series,) = found.atoms(ChebyshevSeries)
    assert series.args[1].has(sp.Piecewise)
    v = ca.SX.sym("v")
    f = ca.Function("f", [v], [Printer({V: v}, set(), Switches())(found)])
    speeds = np.linspace(0.5, 3.0, 101)
    assert np.array(f(speeds[None])).ravel() == pytest.approx(1 / (1 + 8 * (speeds - 0.9) ** 2), abs=2e-12)


def belt(q, **given):
    scene = sf.scenes.mass_on_belt(L.stribeck(0.4, 0.25, 0.2).averaged(Q), v_b=0.2, horizon=8.0)
    return scene.where({"q": q, **given}).wanting({"end": sf.End()})


FEW = sf.Taylor(order=4)


@pytest.mark.long(beside="test_explain_says_what_is_built_in")
@pytest.mark.parametrize("route", longer([FEW, sf.Integrators("cvodes")], [FEW]))
def test_a_program_stays_right_for_another_intensity(route):
    program = sf.prepare(belt(0.05), 1e-6, route)
    for q, v_b in ((0.3, 0.2), (0.05, 0.25)):
        changed = program.run({"q": q, "v_b": v_b})
        fresh = sf.simulate(belt(q, v_b=v_b), 1e-11)
        assert changed.checked().final == pytest.approx(fresh.checked().final, abs=2e-6)
    with pytest.raises(sf.SceneError, match="the value of q is nan"):
        program.run({"q": float("nan")})


def test_explain_says_what_is_built_in():
    explained = sf.explain(belt(0.05))
    assert explained.facts.averaged_over == ("q",)
    assert any("q as variables: the mean of a law over fast vibration" in note for note in explained.skipped)
    assert "q" not in [s.name for s in lower(belt(0.05)).parameters]
    assert "q" in [s.name for s in lower(belt(0.05), (), frozenset({"q"})).parameters]


@pytest.mark.long(beside="test_means_of_means_are_short_too")
@pytest.mark.parametrize("name", longer(["stribeck", "square root", "regularised"], ("square root", "regularised")))
def test_motions_pass_the_fast_speed(name):
    """The slip goes through q, where the law has no Taylor series, both ways and many times."""
    scene = sf.scenes.mass_on_belt(LAWS[name][0].averaged(0.05), v_b=0.2, horizon=30.0)
    run = sf.simulate(scene, 1e-9).checked()
    assert run.stats["kinks"] > 8
    assert run.energy_residual() < 1e-8
    end = scene.wanting({"end": sf.End()})
    other = sf.simulate(end, 1e-10, sf.Integrators("cvodes")).checked()
    assert run.final == pytest.approx(other.final, abs=1e-6)
