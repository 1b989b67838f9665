"""Resets that put a body into another one end a run; those that put it onto or above it do not."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
place = sp.Symbol("place", real=True)
G = 9.81


def dropped(at, start, tolerance, restitution=0.5, outputs=None):
    """Return the program of a ball above a floor that is put somewhere at a time."""
    contacts = [sf.Contact("floor", None, sf.Unilateral(x, restitution))]
    resets = [sf.Reset(at=[at], set={x: place, u: 0})]
    system = sf.System([x], [u], [[1]], [-G])
    scene = sf.Scene(
        system, contacts, {place: 1.0}, {x: start, u: 0.0}, 3.0, outputs=outputs or {"end": sf.End()}, resets=resets
    )
    return sf.prepare(scene, tolerance)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
@pytest.mark.parametrize(("at", "start"), [(0.1, 1.0), (2.9, 0.001), (0.5, 0.0)], ids=["flying", "at rest", "closed"])
def test_a_body_put_into_the_floor_ends_the_run(at, start, tolerance):
    program = dropped(at, start, tolerance)
    assert program.run({"place": -0.1}).status == sf.Status.OVERLAP
    assert program.run({"place": -0.1}).t_final == pytest.approx(at)
    with pytest.raises(sf.RunFailed, match="a reset puts bodies into each other"):
        program.run({"place": -1e-3}).checked()
    for where in (0.0, 1e-12, 0.2):
        assert program.run({"place": where}).status == sf.Status.OK
    places = np.array([-0.1, 0.2, -0.5, 0.0])
    assert program.map(values={"place": places}).status.tolist() == [sf.Status.OVERLAP, 0, sf.Status.OVERLAP, 0]


def test_a_body_put_above_the_floor_falls_as_from_there():
    run = dropped(0.1, 1.0, 1e-12, 0.0, {"events": sf.Events()}).run({"place": 0.2})
    landing = next(e.t for e in run.events if e.kind in ("impact", "close"))
    assert landing == pytest.approx(0.1 + np.sqrt(0.4 / G), abs=1e-12)
