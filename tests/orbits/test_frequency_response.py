"""How a response goes on behind the ends of a branch that does not reach those of the span."""

from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.errors import NotFound
from symfric.orbits import frequency_response
from symfric.orbits.continuation.branch import Branch

X, U = sp.symbols("x u", real=True)
W = sp.Symbol("W", positive=True)
SCENE = sf.Scene(sf.System([X], [U], [[1]], [-X + sp.cos(W * sf.TIME)]), [], {W: 1.0}, {X: 0.0, U: 0.0}, horizon=60.0)


@pytest.mark.parametrize(("reach", "pieces"), [(0.05, 7), (0.15, 3), (0.3, 1)])
@pytest.mark.parametrize("gap", [None, 0.87, 1.13])
def test_pieces_cover_the_span_once_up_to_where_there_is_no_orbit(monkeypatch, reach, pieces, gap):
    """Branches that end after a while, as at jumps; none begins next to the gap."""
    asked = []

    def short(scene, name, span, start, most, tolerance):
        begin = scene.values[W]
        assert span[0] <= begin <= span[1]
        if gap is not None and abs(begin - gap) < 0.05:
            raise NotFound("there is no limit cycle")
        asked.append(begin)
        low, high = max(span[0], begin - reach), min(span[1], begin + reach)
        values = np.linspace(low, high, 5)
        orbits = tuple(SimpleNamespace(half_range=[1 / v]) for v in values)
        return Branch(name, values, orbits, (), tuple("span" if e in (0.8, 1.2) else "jump" for e in (low, high)))

    monkeypatch.setattr(frequency_response, "continue_cycle", short)
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
