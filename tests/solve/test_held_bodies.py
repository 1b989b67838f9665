"""Bodies that several contacts hold together rest for any length of time, also after a stop and on a belt."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, Y, U, V = sp.symbols("x y u v", real=True)
SPRINGS = [0.7 - 0.11 * X + 0.3 * Y, 0.3 + 0.3 * X - 0.9 * Y]
FULL = [[2.0, 0.3], [0.3, 1.0]]


def pair(slips, mass, horizon, speeds=(0.0, 0.0)):
    """Return two bodies under springs, held by contacts that bear far more."""
    contacts = [sf.Contact(f"c{k}", slip, 10.0, sf.laws.coulomb(1.0, 0.7)) for k, slip in enumerate(slips)]
    start = dict(zip([X, Y, U, V], [0.3, 0.7, *speeds], strict=True))
    return sf.Scene(sf.System([X, Y], [U, V], mass, SPRINGS), contacts, {}, start, horizon)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("route", ["exact", "taylor"])
@pytest.mark.parametrize("slips", [(U - V, U), (U + 0.3 * V, U - 0.7 * V)])
def test_bodies_at_rest_keep_their_places(slips, route):
    run = sf.simulate(pair(slips, FULL, 1e8), 1e-9, route).checked()
    assert run.final.tolist() == [0.3, 0.7, 0.0, 0.0]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("route", ["exact", "taylor"])
@pytest.mark.parametrize("slips", [(U - V, U), (U + 0.3 * V, U - 0.7 * V)])
def test_bodies_keep_the_places_where_they_stopped(slips, route):
    soon, late = (sf.simulate(pair(slips, FULL, t, (0.5, 0.77)), 1e-9, route).checked() for t in (1e2, 1e7))
    assert late.stats["events"] == soon.stats["events"] >= 2
    assert np.max(np.abs(late.final - soon.final)) <= 4e-16


@pytest.mark.one_in(2)
@pytest.mark.parametrize("route", ["exact", "taylor"])
def test_bodies_on_a_belt_move_with_it(route):
    scene = pair((U - V, U - 0.25), FULL, 8.0, (0.25, 0.25))
    run = sf.simulate(scene, 1e-9, route).checked()
    assert run.final == pytest.approx([2.3, 2.7, 0.25, 0.25], rel=1e-15)
