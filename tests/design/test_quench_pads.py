"""Several pads on one disc: their characteristics add up, for the quench and in the full model."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.design import quench
from symfric.design.quench.belt_scene import read_belt

X, U = sp.symbols("x u", real=True)
A, OMEGA, V_B, N = sp.symbols("a Omega v_b N", positive=True)
CUBIC = sf.laws.cubic(0.4, 0.25, 0.5)
BOUNDS = {"Omega": (20.0, 60.0), "a": (0.0, 0.05)}


def disc(*contacts, **values):
    """A mass under the given contacts."""
    force = -X - 0.1 * U + A * OMEGA**2 * sp.sin(OMEGA * sf.TIME)
    known = {V_B: 0.2, A: 0.0, OMEGA: 30.0, **{sp.Symbol(k, positive=True): v for k, v in values.items()}}
    return sf.Scene(sf.System([X], [U], [[1]], [force]), list(contacts), known, {X: 0.0, U: 0.0}, 50.0)


def test_two_halves_are_a_whole():
    """Loads 1/4 and 3/4 of one law, the second pad's slip the other way round: the ready scene, Thomsen (56)."""
    pads = disc(sf.Contact("left", U - V_B, N / 4, CUBIC), sf.Contact("right", V_B - U, 0.75 * N, CUBIC), N=1.0)
    ready = sf.scenes.mass_on_belt(CUBIC, v_b=0.2)
    found, whole = (quench(s, (0.38, 0.38), **BOUNDS) for s in (pads, ready))
    assert found.objective == pytest.approx(sf.theory.belt.quench_intensity_at(ready, 0.38), abs=1e-8)
    assert found.values == pytest.approx(whole.values, rel=1e-12)
    assert found.corrected == pytest.approx(whole.corrected, rel=1e-9)
    assert found.check.agrees
    above, same = found.check.above[0], whole.check.above[0]
    assert above.decay_rate == pytest.approx(same.decay_rate, rel=1e-6)


@pytest.mark.long(beside="test_two_halves_are_a_whole")
def test_two_laws_are_the_law_of_their_sum():
    """The sum written by hand, with the breaks of both, gives the same design, curve and full model."""
    falling, rising = sf.SPEED, sf.SPEED - 0.3
    one = sf.laws.custom(sp.Piecewise((0.5 - falling, falling < 0.2), (0.3, True)), 0.5, breaks=[0.2])
    two = sf.laws.custom(sp.Piecewise((0.2, falling < 0.3), (0.2 + rising, True)), 0.2, breaks=[0.3])
    branches = [(0.48 - 0.6 * falling, falling < 0.2), (0.36, falling < 0.3), (0.36 + 0.9 * rising, True)]
    total = sf.laws.custom(sp.Piecewise(*branches), 0.48, breaks=[0.2, 0.3])
    pads = disc(sf.Contact("one", U - V_B, 0.6, one), sf.Contact("two", U - V_B, 0.9, two))
    found, same = (quench(s, (0.05, 0.15), **BOUNDS) for s in (pads, disc(sf.Contact("sum", U - V_B, 1, total))))
    assert found.values == pytest.approx(same.values, rel=1e-9)
    assert found.active == same.active
    assert np.array(found.curve.y) == pytest.approx(same.curve.y, abs=1e-9, nan_ok=True)
    assert found.check.agrees
    assert found.check.below[0].decay_rate == pytest.approx(same.check.below[0].decay_rate, rel=1e-6)


@pytest.mark.parametrize(
    ("contact", "message"),
    [
        (sf.Contact("two", U - 2 * V_B, 1, CUBIC), r"slip of contact 'two' is u - 2\*v_b; quench takes u - v_b"),
        (sf.Contact("two", U, 1, CUBIC), "slip of contact 'two' is u; quench"),
        (sf.Contact("two", U - V_B, 1 + X**2, CUBIC), "the normal load of contact 'two', with its profile, depends"),
    ],
)
def test_other_contacts_are_refused(contact, message):
    with pytest.raises(sf.SceneError, match=message):
        quench(disc(sf.Contact("one", U - V_B, 1, CUBIC), contact), (0.1, 0.4), **BOUNDS)


def test_pads_without_load_do_not_count():
    off = sf.Contact("off", U - V_B, 0, sf.laws.piecewise_linear(0.5, [0, 0.2], [0.5, 0.3]))
    with pytest.raises(sf.SceneError, match="loads of all contacts are 0"):
        quench(disc(off, sf.Contact("on", U - V_B, 0, CUBIC)), (0.1, 0.4), **BOUNDS)
    belt = read_belt(disc(off, sf.Contact("on", U - V_B, 1, CUBIC)))
    assert (belt.normal, belt.law.breaks) == (1.0, ())
    assert belt.law(0.3) == pytest.approx(CUBIC(0.3), rel=1e-15)
