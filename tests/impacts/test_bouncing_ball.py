"""A ball that bounces once a period on a shaken table: the exact map of Holmes, its multipliers, fold and flip.

With the height ``y = a sin(w t + phi)`` of the table, the period T and the rate at which ball and table meet,
``R = g T/(1 + e)``, the impact is at the phase ``cos = g T (1 - e)/(2 a w (1 + e))``. From the variations of time and
speed of one impact to those of the next follow

    trace = 1 + e^2 - (1 + e)^2 a w^2 sin/g,   det = e^2,

so that the orbits fold where the sine is zero and flip where ``a w^2 sin = 2 g (1 + e^2)/(1 + e)^2``.
"""

import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf

y, v = sp.symbols("y v", real=True)
a, w, e = sp.symbols("a w e", positive=True)
G = 9.81


def bouncing(amplitude, frequency, restitution, shift=0.0):
    """Return the scene on its orbit, at a phase `shift` of the table, and the closed trace."""
    period = 2 * math.pi / frequency
    phase = math.acos(G * period * (1 - restitution) / (2 * amplitude * frequency * (1 + restitution)))
    flight = ((phase - shift) % (2 * math.pi)) / frequency  # until the first impact
    height, speed = amplitude * math.sin(phase), -G * period / 2
    gap = y - a * sp.sin(w * sf.TIME + shift)
    scene = sf.Scene(
        sf.System([y], [v], [[1]], [-G]),
        [sf.Contact("table", None, sf.Unilateral(gap, restitution=e))],
        {a: amplitude, w: frequency, e: restitution},
        {y: height - speed * flight - G * flight**2 / 2, v: speed + G * flight},
        20 * period,
    )
    lifts = (1 + restitution) ** 2 * amplitude * frequency**2 * math.sin(phase) / G
    return scene, 1 + restitution**2 - lifts, phase


def corners(frequency, restitution):
    """Return the amplitudes of fold and flip."""
    level = math.pi * (1 - restitution) / (1 + restitution)
    return tuple(
        G / frequency**2 * math.hypot(level, s) for s in (0, 2 * (1 + restitution**2) / (1 + restitution) ** 2)
    )


def test_multipliers_of_the_published_setting():
    scene, _, _ = bouncing(0.012, 30.0, 0.6)
    orbit = sf.limit_cycle(scene)
    assert math.cos(30.0 * orbit.events[0].t) == pytest.approx(0.713403331752682, abs=1e-13)
    assert np.sum(orbit.multipliers).real == pytest.approx(-0.614968101739642, abs=1e-12)
    assert np.prod(orbit.multipliers).real == pytest.approx(0.36, abs=1e-12)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.8])
@pytest.mark.parametrize("share", [0.15, 0.5, 0.85])
def test_multipliers_are_those_of_the_exact_map(restitution, share):
    fold, flip = corners(25.0, restitution)
    scene, trace, phase = bouncing(fold + share * (flip - fold), 25.0, restitution, shift=4.0)
    orbit = sf.limit_cycle(scene)
    assert orbit.stable
    assert math.remainder(25.0 * orbit.events[0].t + 4.0 - phase, 2 * math.pi) == pytest.approx(0.0, abs=1e-12)
    assert np.sum(orbit.multipliers).real == pytest.approx(trace, abs=1e-11)
    assert np.prod(orbit.multipliers).real == pytest.approx(restitution**2, abs=1e-11)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("restitution", [0.3, 0.6])
def test_a_branch_folds_and_flips_where_the_exact_map_does(restitution):
    fold, flip = corners(30.0, restitution)
    scene, _, _ = bouncing(0.5 * (fold + flip), 30.0, restitution, shift=4.0)
    branch = sf.continue_cycle(scene, "a", (0.5 * fold, 1.1 * flip))
    assert [s.kind for s in branch.special] == ["fold", "flip"]
    assert [s.value for s in branch.special] == pytest.approx([fold, flip], rel=1e-10)
    assert branch.ends == ("span", "span")


def test_beyond_the_flip_the_ball_bounces_twice_in_two_periods():
    _, flip = corners(30.0, 0.6)
    scene, _, _ = bouncing(0.95 * flip, 30.0, 0.6, shift=4.0)
    branch = sf.continue_cycle(scene, "a", (0.9 * flip, 1.02 * flip))
    (point,) = branch.special
    doubled = sf.continue_cycle(scene, "a", (0.9 * flip, 1.02 * flip), start=point)
    orbit = doubled.orbits[int(np.argmax(doubled.values))]
    assert orbit.stable
    assert orbit.period == pytest.approx(4 * math.pi / 30.0)
    flights = np.diff([*(event.t for event in orbit.events), orbit.events[0].t + orbit.period])
    assert len(flights) == 2
    assert np.ptp(flights) > 1e-3
