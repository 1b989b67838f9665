"""Square waves and trains of pulses: their instants are known, so results are right to rounding at every tolerance."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.model.alternations import alternations_of

X, U = sp.symbols("x u", real=True)
T, D, A, W = sp.symbols("T D A W", positive=True)
RATE, HORIZON = 0.1, 20.0


def scene(force, values=None, horizon=HORIZON, contacts=()):
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[force - sp.Float(RATE) * U])
    start = {X: 0.0, U: 0.0}
    return sf.Scene(system, contacts, values=values or {}, initial=start, horizon=horizon, outputs={"end": sf.End()})


def velocity(intervals, force=1.0, until=HORIZON):
    """The velocity at the end under a force that acts in intervals."""
    return sum(force * (np.exp(-RATE * (until - b)) - np.exp(-RATE * (until - a))) / RATE for a, b in intervals)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-9, 1e-12])
@pytest.mark.parametrize("width", [0.9999, 0.5, 1e-2, 1e-4, 1e-6])
def test_pulses_of_any_width(width, tolerance):
    """With a series of the sine instead of its known zeros, pulses of 1e-6 at tolerance 1e-4 gave 108 instead of 17."""
    pulses = sp.Piecewise((1 / D, sp.Mod(sf.TIME - A, T) < D), (0, True))
    run = sf.simulate(scene(pulses, {D: width, T: 1.0, A: 0.3}), tolerance=tolerance)
    first = [(0.0, width - 0.7)] if width > 0.7 else []
    whole = [(k + 0.3, min(k + 0.3 + width, HORIZON)) for k in range(20)]
    right = velocity([*first, *whole], 1 / width)
    assert run.final[1] == pytest.approx(right, rel=1e-13 + 4e-15 / width)  # times are known to some 1e-15


WAVES = {
    "sine": (sp.sin(W * sf.TIME), lambda t, w: np.sin(w * t)),
    "falling sine": (sp.sin(0.4 - W * sf.TIME), lambda t, w: np.sin(0.4 - w * t)),
    "cosine": (-3 * sp.cos(W * sf.TIME + A), lambda t, w: -np.cos(w * t + 0.3)),
    "product": (sp.sin(W * sf.TIME) * sp.cos(2 * W * sf.TIME), lambda t, w: np.sin(w * t) * np.cos(2 * w * t)),
    "level": (sp.cos(W * sf.TIME) - sp.Float(0.9), lambda t, w: np.cos(w * t) - 0.9),
    "low level": (2 * sp.sin(W * sf.TIME) + sp.Float(1.99), lambda t, w: 2 * np.sin(w * t) + 1.99),
    "level never reached": (sp.sin(W * sf.TIME) - 2, lambda t, w: np.sin(w * t) - 2),
    "level never left": (sp.sin(W * sf.TIME) + 2, lambda t, w: np.sin(w * t) + 2),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-12])
@pytest.mark.parametrize("name", WAVES)
def test_square_waves(name, tolerance):
    wave, number = WAVES[name]
    values = {W: 2.7, A: 0.3} if wave.has(A) else {W: 2.7}
    force = sp.Piecewise((1, wave > 0), (0, True))
    run = sf.simulate(scene(force, values), tolerance=tolerance)
    t = np.linspace(0.0, HORIZON, 200_001)
    on = number(t, 2.7) > 0
    changes = [_root(lambda s: number(s, 2.7), t[k], t[k + 1]) for k in np.flatnonzero(on[1:] != on[:-1])]
    edges = [0.0] * int(on[0]) + changes + [HORIZON] * int(on[-1])
    right = velocity(list(zip(edges[::2], edges[1::2], strict=True)))
    assert run.final[1] == pytest.approx(right, rel=2e-13, abs=1e-14)


def _root(f, a, b):
    from scipy.optimize import brentq

    return brentq(f, a, b, xtol=1e-15, rtol=8.9e-16)


@pytest.mark.parametrize("duty", [0.0, 1.0, 1.5, -0.2])
def test_pulses_that_never_come_or_never_end(duty):
    pulses = sp.Piecewise((1, sp.Mod(sf.TIME, T) < D), (0, True))
    d = sp.Symbol("D", real=True)
    run = sf.simulate(scene(pulses.subs(D, d), {d: duty, T: 1.0}), tolerance=1e-6)
    assert run.final[1] == pytest.approx(velocity([(0.0, HORIZON)]) if duty >= 1 else 0.0, abs=1e-13)


def test_a_run_that_starts_just_before_a_change():
    for before in (1e-3, 1e-9, 1e-11, 0.0):
        pulses = sp.Piecewise((1, sp.Mod(sf.TIME - before, 1) < 0.25), (0, True))
        run = sf.simulate(scene(pulses, horizon=1.0), tolerance=1e-10)
        right = velocity([(before, before + 0.25)], until=1.0)
        assert run.final[1] == pytest.approx(right, rel=1e-12)


def test_derivatives_by_period_width_and_delay():
    """Beside a contact that sticks and slips, against differences of fine runs."""
    pulses = sp.Piecewise((3, sp.Mod(sf.TIME - A, T) < D), (0, True))
    contact = sf.Contact("floor", slip=U, normal=1, law=sf.laws.coulomb(0.9, 0.7))
    values = {"D": 0.21, "T": 0.9, "A": 0.15}
    base = scene(pulses, {sp.Symbol(n, positive=True): v for n, v in values.items()}, 4.0, [contact])
    run = sf.simulate(base, tolerance=1e-12, sensitivities=tuple(values))
    for name, value in values.items():
        high, low = (sf.simulate(base.where({name: value + d}), tolerance=1e-13).final for d in (1e-5, -1e-5))
        np.testing.assert_allclose(run.sensitivities[name], (high - low) / 2e-5, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("periods", [3, 1000])
def test_many_periods_before_the_first_event_of_a_contact(periods):
    """Over many periods each instant is rounded once: errors do not add up."""
    pulses = sp.Piecewise((1, sp.sin(2 * sp.pi * sf.TIME / T) > 0), (-1, True))
    force = sf.System(q=[X], u=[U], mass=[[1]], force=[pulses])
    end = (periods + 0.25) * 0.3
    s = sf.Scene(force, values={T: 0.3}, initial={X: 0.0, U: 0.0}, horizon=end, outputs={"end": sf.End()})
    run = sf.simulate(s, tolerance=1e-5)
    assert run.final[1] == pytest.approx(0.075, abs=1e-12)
    assert run.final[0] == pytest.approx(periods * 0.15**2 + 0.075**2 / 2, rel=1e-11)  # 2000 instants, rounded


def test_the_other_routes_see_the_same_instants():
    pulses = sp.Piecewise((2, sp.Mod(sf.TIME - sp.Float(0.2), 1) < sp.Float(0.3)), (0, True))
    contact = sf.Contact("floor", slip=U, normal=1, law=sf.laws.coulomb(0.5, 0.4))
    base = scene(pulses, horizon=5.0, contacts=[contact])
    first, second = sf.simulate(base, tolerance=1e-11), sf.simulate(base, tolerance=1e-8, route="integrators")
    np.testing.assert_allclose(second.final, first.final, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize(
    "expr",
    [sf.TIME**2 - 1, sp.sin(sf.TIME**2), sp.exp(-sf.TIME) - sp.Rational(1, 2), sp.sin(sf.TIME) + sp.sin(3 * sf.TIME)],
)
def test_other_functions_of_time_are_no_alternations(expr):
    assert alternations_of(expr) is None
    run = sf.simulate(scene(sp.Piecewise((1, expr > 0), (0, True)), horizon=3.0), tolerance=1e-11)
    t = np.linspace(0.0, 3.0, 30_001)
    f = sp.lambdify(sf.TIME, expr)
    on = f(t[1:-1]) > 0
    inner = t[1:-1]
    changes = [_root(f, inner[k], inner[k + 1]) for k in np.flatnonzero(on[1:] != on[:-1])]
    edges = [0.0] * int(on[0]) + changes + [3.0] * int(on[-1])
    assert run.final[1] == pytest.approx(velocity(list(zip(edges[::2], edges[1::2], strict=True)), until=3.0), rel=1e-9)
