"""Starts at a state in the middle of a run: bristles at their limit beside a contact that sticks."""

import pytest
import sympy as sp

import symfric as sf

x, y, u, w = sp.symbols("x y u w", real=True)
BRISTLES = {"dahl": sf.laws.dahl(0.3, 100.0), "lugre": sf.laws.lugre(0.3, 0.25, 0.1, 100.0)}
LAWS = {"stribeck": sf.laws.stribeck(0.3, 0.2, 0.07), "lorentz": sf.laws.lorentz(0.2, 0.1, 0.3)}


@pytest.mark.one_in(2)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
@pytest.mark.parametrize("bristle", BRISTLES)
@pytest.mark.parametrize("law", LAWS)
def test_a_run_in_two_parts_is_the_whole(law, bristle, tolerance):
    """While the other contact sticks nothing is unseen, and rounding is not looked at."""
    contacts = [sf.Contact("dry", u, 1.5, LAWS[law]), sf.Contact("bristle", w, 0.35, BRISTLES[bristle])]
    system = sf.System([x, y], [u, w], [[1, 0], [0, 1]], [-3 * x + y, x - 1.6 * y])
    whole = sf.Scene(system, contacts, {}, {x: 0.15, y: 0.5, u: 0.0, w: -0.8}, 3.0)
    half = sf.simulate(whole.until(0.5), tolerance).checked()
    rest = whole.starting(dict(zip(half.names, half.final, strict=True))).until(2.5)
    expected = sf.simulate(whole, tolerance).checked()
    assert sf.simulate(rest, tolerance).checked().final == pytest.approx(expected.final, abs=1e3 * tolerance)
