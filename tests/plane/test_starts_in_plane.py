"""Starts and rests of contacts in the plane: how many steps they take, and that their error follows the tolerance.

What a step need not prove costs no steps, and neither does a start whose force leaves its bound slowly.
"""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer
from tests.plane.plane_scenes import drawn

x, y, u, w = sp.symbols("x y u w", real=True)
t = sf.TIME


def counts(scene, tolerance=1e-12):
    """Return the numbers of steps and events of a drawn scene."""
    run = sf.prepare(scene.scene(), tolerance=tolerance, route=sf.Taylor(max_steps=20_000)).run().checked()
    return run.stats["steps"], run.stats["events"]


@pytest.mark.long(beside="test_slow_starts_take_few_steps")
@pytest.mark.parametrize("seed", [223, pytest.param(1017, marks=pytest.mark.long)])
def test_a_mass_that_depends_on_the_place_needs_no_more_steps(seed):
    """Masses come to rest: expressions of high degree hold terms that are zero while they stick."""
    scene = drawn(seed)
    assert scene.swing > 0.0
    taken, events = counts(scene)
    constant, others = counts(replace(scene, swing=0.0))
    assert taken < 1.5 * constant + 40 * abs(events - others)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("tolerance", [1e-9, 1e-12])
@pytest.mark.parametrize("seed", [254, 313, pytest.param(378, marks=pytest.mark.long)])
def test_slow_starts_take_few_steps(seed, tolerance):
    """Friction does not drop where they begin: across the slip it damps by B/|w|, which limits steps after the start."""
    taken, events = counts(drawn(seed), tolerance)
    assert events >= 2
    assert taken < 60 + 50 * events


def touched(turn):
    """Return a block whose force touches its bound tangentially at the start, with axes turned by an angle."""
    along, across = 0.3 * sp.cos(t), 0.5 * sp.sin(1.3 * t)
    force = [along * np.cos(turn) - across * np.sin(turn), along * np.sin(turn) + across * np.cos(turn)]
    contact = sf.Contact("table", (u, w), 1, sf.laws.coulomb(0.3))
    start = dict.fromkeys((x, y, u, w), 0.0)
    return sf.Scene(sf.System([x, y], [u, w], sp.eye(2), force), [contact], {}, start, 5.0, {"end": sf.End()})


@pytest.mark.long(beside="test_slow_starts_take_few_steps")
def test_a_start_where_the_force_touches_its_bound_takes_few_steps():
    """The part of the slip across begins with a higher power of time than that along; in turned axes neither does."""
    turned = np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    exact = sf.simulate(touched(0.0), tolerance=1e-12).checked()
    assert exact.stats["steps"] < 10_000
    for tolerance, most in ((1e-6, 200), (1e-8, 600), (1e-10, 2500)):
        for turn, axes in ((0.0, np.eye(2)), (0.7, turned)):
            run = sf.simulate(touched(turn), tolerance=tolerance).checked()
            assert run.stats["steps"] < most
            got = np.concatenate([axes @ run.final[:2], axes @ run.final[2:]])
            assert got == pytest.approx(exact.final, abs=max(0.1 * tolerance, 1e-11))


# -- a body on a base that turns, in its frame and in the frame at rest

a, b, c, k, mu = sp.symbols("a b c k mu", positive=True)
TURNS = a + b * sp.cos(c * t)
NUMBERS = (
    ((1.0571011610945795, 0.16124918817329642, 0.5890202041207946, 0.850017429029503, 0.23839781357735337), 0.98107),
    ((0.5648912660672593, 0.43876445293589805, 2.212730643667438, 1.183731935557719, 0.519678551886446), 0.97630),
    ((0.31039344214685144, 0.38333034119011716, 1.7825158355072717, 0.44011238535042524, 0.3826314014792549), 0.99047),
)


def on_a_base(turning):
    """Return a body that a spring holds, with static friction as large as kinetic."""
    rate = sp.diff(TURNS, t)
    forces = [-k * x, -k * y]
    slip = (u + TURNS * y, w - TURNS * x)
    if turning:
        forces = [
            TURNS**2 * x + 2 * TURNS * w + rate * y - k * x,
            TURNS**2 * y - 2 * TURNS * u - rate * x - k * y,
        ]
        slip = (u, w)
    contact = sf.Contact("base", slip, 1, sf.laws.coulomb(mu))
    values = dict(zip((a, b, c, k, mu), NUMBERS[0][0], strict=True))
    start = dict.fromkeys((x, y, u, w), 0.0)
    return sf.Scene(
        sf.System([x, y], [u, w], sp.eye(2), forces), [contact], values, start, 15.0, {"events": sf.Events()}
    )


@pytest.mark.long(beside="test_slow_starts_take_few_steps")
def test_errors_after_starts_follow_the_tolerance():
    """Each body is let go at rest on the base, and starts, stops and starts again."""
    frames = (True, False)
    tolerances = (1e-7, 1e-9, 1e-12)
    programs = {f: [sf.prepare(on_a_base(f), tolerance=e) for e in tolerances] for f in frames}
    for numbers, radius in NUMBERS:
        values = dict(zip((a, b, c, k, mu), numbers, strict=True))
        runs = {}
        for f in frames:
            start = {x: radius, w: 0.0 if f else radius * (numbers[0] + numbers[1])}
            runs[f] = [p.run(values, start).checked() for p in programs[f]]
            assert len(runs[f][-1].events) > 2
            for tolerance, run in zip(tolerances[:-1], runs[f], strict=False):
                assert run.final == pytest.approx(runs[f][-1].final, abs=10 * tolerance)
                assert [e.kind for e in run.events] == [e.kind for e in runs[f][-1].events]
        assert [e.t for e in runs[True][-1].events] == pytest.approx([e.t for e in runs[False][-1].events], abs=1e-10)
        radii = [np.hypot(*runs[f][-1].final[:2]) for f in frames]
        assert radii[0] == pytest.approx(radii[1], abs=1e-10)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("number", longer([4, 12], [12]))
@pytest.mark.parametrize("share", [0.4, 0.8, 1.2, 1.5])
def test_a_slip_that_turns_round_on_a_line_goes_on(share, number):
    """Hundreds of times it falls to zero, without a stop or for a short one, or soon after its start.

    One that is stepped over by the rounding of time is passed.
    """
    x, y, u, w = sp.symbols("x y u w", real=True)
    v, fast, law = sp.Symbol("v_b", positive=True), 200, sf.laws.cubic(0.4, 0.25, 0.5)
    belt = v + share * v * sp.cos(fast * sf.TIME)
    values, ends = {v: 0.3}, {"end": sf.End()}
    flat = sf.Scene(
        sf.System([x, y], [u, w], sp.eye(2), [-x - 0.1 * u, 0]),
        [sf.Contact("belt", (u - belt, w), 1, law)],
        values,
        {x: 0.3, y: 0, u: 0, w: 0},
        6.0,
        ends,
    )
    line = sf.Scene(
        sf.System([x], [u], [[1]], [-x - 0.1 * u]),
        [sf.Contact("belt", u - belt, 1, law)],
        values,
        {x: 0.3, u: 0},
        6.0,
        ends,
    )
    flat, line = (sf.prepare(scene, tolerance=1e-9) for scene in (flat, line))
    for speed in np.linspace(0.05, 0.4, number):
        one, two = (program.run({"v_b": speed}).checked().final for program in (flat, line))
        assert one[[0, 2]] == pytest.approx(two, abs=1e-7)
        assert one[[1, 3]] == pytest.approx([0, 0], abs=1e-12)
