"""Vibration that quenches a block on a belt, across and along: the motion itself against the theory of averaging."""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import curve_fit

import symfric as sf

LAW, DAMPING, FAST = sf.laws.cubic(0.4, 0.25, 0.5), 0.1, 200.0
x, y, u, w = sp.symbols("x y u w", real=True)
q = sp.Symbol("q", positive=True)
PERIODS, OFFSET = (
    8,
    0.005,
)  # most periods of slow vibration, and its first displacement, small beside its range of speeds


def shaken(v, across, periods):
    """Return a block on a spring and a belt that shakes across or along; sideways it hardly moves."""
    shake = q * sp.cos(FAST * sf.TIME)
    slip = (u - v, w - shake) if across else (u - v - shake, w)
    system = sf.System([x, y], [u, w], sp.diag(1, 1e9), [-x - DAMPING * u, 0])
    times = np.linspace(0, 2 * math.pi * periods, 64 * periods, endpoint=False)
    power = sf.friction_force("belt", int(across)) * shake
    outputs = {"x": sf.Samples(x, times), "power": sf.Mean(power)}
    start = {x: 0.3, y: 0, u: 0, w: 0}
    contact = sf.Contact("belt", slip, 1, LAW)
    scene = sf.Scene(system, [contact], {q: 0.1}, start, 2 * math.pi * periods, outputs)
    return times, sf.prepare(scene, tolerance=1e-8)


def measured(intensity, v, across, expected):
    """Return the growth rate of small vibration about steady sliding, and the power of the fast vibration.

    Vibration that has grown by a factor of three, or decayed to a third, says it; larger one is not small for long.
    """
    drag = sf.theory.plane.lateral_vibration_drag if across else sf.theory.plane.longitudinal_vibration_drag
    periods = int(np.clip(1 / (2 * math.pi * abs(expected)), 1, PERIODS))
    times, program = shaken(v, across, periods)
    run = program.run({q: intensity}, {x: drag(v, intensity, LAW) + OFFSET}).checked()

    def vibration(t, growth, rate, a, b, middle):
        return middle + np.exp(growth * t) * (a * np.cos(rate * t) + b * np.sin(rate * t))

    middle = np.mean(run["x"])
    guess = (expected, 1.0, run["x"][0] - middle, 0.0, middle)
    (growth, *_), _ = curve_fit(vibration, times, run["x"], guess)
    return growth, run["power"]


def told(intensity, v, across):
    """Return the same by averaging."""
    mean = sf.theory.plane.lateral_vibration_drag if across else sf.theory.plane.longitudinal_vibration_drag
    power = sf.theory.plane.lateral_vibration_power if across else sf.theory.plane.longitudinal_vibration_power
    slope = (mean(v + 1e-4, intensity, LAW) - mean(v - 1e-4, intensity, LAW)) / 2e-4
    return -(DAMPING + slope) / 2, power(v, intensity, LAW)


def test_the_border_is_where_the_mean_friction_neither_grows_nor_decays():
    found = sf.theory.plane.compare_quenching(LAW, 0.4, DAMPING)
    assert told(found.across, 0.4, True)[0] == pytest.approx(0.0, abs=1e-6)
    assert told(found.along, 0.4, False)[0] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.long(beside="test_the_border_is_where_the_mean_friction_neither_grows_nor_decays")
@pytest.mark.parametrize("across", [True, False])
@pytest.mark.parametrize("v", [0.2, 0.3, 0.4])
def test_growth_and_power_in_runs_are_those_of_the_mean_friction(v, across):
    found = sf.theory.plane.compare_quenching(LAW, v, DAMPING)
    border = found.across if across else found.along
    for share in (0.8, 1.2):
        if not across and share * border > v > 0.99 * border:
            continue  # the slope jumps to infinity there, and small vibration is none
        right, supplied = told(share * border, v, across)
        growth, power = measured(share * border, v, across, right)
        assert growth == pytest.approx(right, abs=1.5e-3)
        assert (growth > 0) == (share < 1)
        assert power == pytest.approx(supplied, rel=0.03, abs=2e-4)
