"""Resets that put a body into another one end a run; those that put it onto or above it do not."""

from functools import cache

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


@pytest.mark.one_in(3)
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


@cache
def on_curved_floor(tolerance):
    """Return the program of a body on or above a floor that falls away from it, kicked and moved by resets."""
    y, v, kick = sp.symbols("y v kick", real=True)
    contacts = [sf.Contact("floor", None, sf.Unilateral(y - sp.sin(x), 0.5))]
    resets = [sf.Reset(at=[0.31], set={u: u + kick}), sf.Reset(at=[0.62], set={y: y + place})]
    system = sf.System([x, y], [u, v], sp.eye(2), [sp.Float(1) - x, -4 * G])
    start = {x: 0.0, y: 0.0, u: 1.0, v: 1.0}
    outputs = {"gap": sf.Samples(y - sp.sin(x), [0.61])}
    return sf.prepare(
        sf.Scene(system, contacts, {place: 0.0, kick: 0.0}, start, 1.0, outputs=outputs, resets=resets), tolerance
    )


@pytest.mark.long(beside="test_depths_of_all_sizes_end_the_run")
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-12])
@pytest.mark.parametrize("start", [{}, {"y": 0.1}], ids=["closed", "flying"])
def test_how_deep_a_body_is_put_decides_at_every_tolerance(tolerance, start):
    """A kick leaves its gap alone, and what it has drifted by is no reset's; beyond that, nothing is undone silently."""
    program = on_curved_floor(tolerance)
    for kick in (-0.3, 0.3):
        plain = program.run({"kick": kick}, start).checked()
    gap = plain["gap"][0]
    drift = abs(gap) if not start else 0.0
    for depth in 10.0 ** np.arange(-8, 0):
        if depth > 2 * drift:
            below = {"place": -depth - max(gap, 0.0)}
            assert program.run(below, start).status == sf.Status.OVERLAP, (depth, gap)
    assert program.run({"place": 1e-6}, start).status == sf.Status.OK


@pytest.mark.one_in(3)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize(("at", "start"), [(0.1, 1.0), (2.9, 0.001), (0.5, 0.0)], ids=["flying", "at rest", "closed"])
def test_depths_of_all_sizes_end_the_run(at, start, tolerance):
    program = dropped(at, start, tolerance)
    for depth in 10.0 ** np.arange(-8, 1):
        assert program.run({"place": -depth}).status == sf.Status.OVERLAP, depth
    for depth in (1e-11, 0.0) if start == 1.0 else (0.0,):  # a gap that was never larger has no digits to lose
        assert program.run({"place": -depth}).status == sf.Status.OK, depth


def test_a_body_put_above_the_floor_falls_as_from_there():
    run = dropped(0.1, 1.0, 1e-12, 0.0, {"events": sf.Events()}).run({"place": 0.2})
    landing = next(e.t for e in run.events if e.kind in ("impact", "close"))
    assert landing == pytest.approx(0.1 + np.sqrt(0.4 / G), abs=1e-12)
