"""How a response goes on behind the ends of a branch that does not reach those of the span."""

from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.errors import NotFound
from symfric.orbits import frequency_response
from symfric.orbits.continuation.arclength import Behind, bend_ahead
from symfric.orbits.continuation.branch import Branch
from symfric.orbits.shooting import Point, ShootingSystem
from symfric.search import zero

X, U = sp.symbols("x u", real=True)
W = sp.Symbol("W", positive=True)
SCENE = sf.Scene(sf.System([X], [U], [[1]], [-X + sp.cos(W * sf.TIME)]), [], {W: 1.0}, {X: 0.0, U: 0.0}, horizon=60.0)


@pytest.mark.parametrize(("reach", "pieces"), [(0.05, 7), (0.15, 3), (0.3, 1)])
@pytest.mark.parametrize("gap", [None, 0.87, 1.13])
def test_pieces_cover_the_span_once_up_to_where_there_is_no_orbit(monkeypatch, reach, pieces, gap):
    """Branches that end after a while, as at jumps; none begins next to the gap."""
    asked = []

    def short(scene, name, span, start, most, tolerance, steps):
        begin = scene.values[W]
        assert span[0] <= begin <= span[1]
        if gap is not None and abs(begin - gap) < 0.05:
            raise NotFound("there is no limit cycle")
        asked.append(begin)
        low, high = max(span[0], begin - reach), min(span[1], begin + reach)
        values = np.linspace(low, high, 5)
        orbits = tuple(SimpleNamespace(half_range=[1 / v]) for v in values)
        return Branch(name, values, orbits, (), tuple("span" if e in (0.8, 1.2) else "jump" for e in (low, high)))

    monkeypatch.setattr(frequency_response, "followed", short)
    found = frequency_response.frequency_response(SCENE, "W", (0.8, 1.2))
    assert np.all(np.diff(found.values) > 0)
    assert found.peak.value == found.values[0]  # where the responses are largest
    if gap is None:
        assert len(asked) == pieces
        assert found.values[[0, -1]].tolist() == [0.8, 1.2]
        assert found.ends == ("span", "span")
    elif reach == 0.05:
        assert (found.ends[0] == "jump") == (gap < 1.0)
        assert (found.ends[1] == "jump") == (gap > 1.0)


def test_a_forced_branch_takes_few_runs_for_each_orbit(monkeypatch):
    """Without friction Newton's method needs one step; a joint that slips and sticks makes orbits curves."""
    follow, count = ShootingSystem.follow, [0]

    def counted(*args):
        count[0] += 1
        return follow(*args)

    monkeypatch.setattr(ShootingSystem, "follow", counted)
    joint = sf.Contact("joint", slip=U, normal=1, law=sf.laws.coulomb(0.4))
    system = sf.System([X], [U], [[1]], [-X - U / 10 + sp.cos(W * sf.TIME)])
    scene = sf.Scene(system, [joint], {W: 0.95}, {X: 0.0, U: 0.0}, horizon=60.0)
    found = sf.frequency_response(scene, "W", (0.9, 1.05))
    assert found.ends == ("span", "span")
    assert count[0] < 3 * len(found.orbits)


def test_a_curve_is_extrapolated_in_the_order_of_what_is_known():
    def curve(s):
        return np.array([np.cos(s), 2 * np.sin(s), s]), np.array([-np.sin(s), 2 * np.cos(s), 1.0])

    size = np.array([1.0, 2.0, 1.0])

    def distance(guess):
        s = zero(lambda s: float((curve(s)[0] - guess) / size @ (curve(s)[1] / size)), 0.5, 1.0)
        return float(np.linalg.norm((curve(s)[0] - guess) / size))

    here, way = curve(0.7)
    way = way / np.linalg.norm(way / size)
    point = Point(here, None, np.zeros(0), np.zeros(0), np.zeros(0))
    for known, order in ((0, 2), (1, 4), (2, 5)):
        errors = []
        for h in (0.08, 0.04):
            behind = [Behind(*curve(0.7 - h * k)) for k in range(1, known + 1)]
            errors.append(distance(here + h * way + bend_ahead(point, way, behind, h, size)))
        assert np.log2(errors[0] / errors[1]) > order - 0.2
    assert not np.any(bend_ahead(point, way, [Behind(*curve(0.69))], 0.05, size))  # too far
