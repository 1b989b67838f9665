"""Pulses that begin within the first step of a start of a contact in the plane, of which its coefficients tell nothing.

The motion is along a line: impulses have a closed form, and the contact along a line is the second method.
"""

import math

import pytest
import sympy as sp

import symfric as sf

x, y, u, w = sp.symbols("x y u w", real=True)
t, V = sf.TIME, sf.SPEED
MU, HORIZON = 0.5, 20.0
C, S = sp.Rational(3, 5), sp.Rational(4, 5)


def bell(a):
    return sp.exp(-(a**2))


def block(plane, force, load=1, law=None, start=0.0):
    """Return a block on a table with a force along one direction, and a speed at the start."""
    along, speed = (C * x + S * y, C * u + S * w) if plane else (x, u)
    pull = force(along, speed)
    q, v = ([x, y], [u, w]) if plane else ([x], [u])
    forces = [C * pull, S * pull] if plane else [pull]
    contact = sf.Contact("table", tuple(v) if plane else u, load, law or sf.laws.coulomb(MU))
    begin = dict.fromkeys((*q, *v), 0.0)
    begin |= {u: float(C) * start, w: float(S) * start} if plane else {u: start}
    return sf.Scene(sf.System(q, v, sp.eye(len(q)), forces), [contact], {}, begin, HORIZON, {"events": sf.Events()})


def ends(scene, tolerance):
    run = sf.simulate(scene, tolerance=tolerance).checked()
    half = len(run.final) // 2
    return math.hypot(*run.final[:half]), math.hypot(*run.final[half:]), [e.kind for e in run.events]


# how it comes to start at a time: at once, by a force that grows, and by that after a stop; force, start, time
STARTS = {
    "from rest": (lambda: MU + 0.1, 0.0, 0.0),
    "after a release": (lambda: t / 10, 0.0, 5.0),
    "after a stop": (lambda: t / 10, 0.1, 5.0),
}


@pytest.mark.one_in(18)
@pytest.mark.parametrize("width", [0.1, 0.004])
@pytest.mark.parametrize("later", [0.05, 1.5, 9.0])
@pytest.mark.parametrize("kind", STARTS)
def test_the_impulse_of_a_pulse_in_time_arrives(kind, later, width):
    pulled, speed, begin = STARTS[kind]
    at = begin + later
    pulse = bell((t - at) / width) / width
    runs = [ends(block(plane, lambda along, v: pulled() + pulse, start=speed), 1e-10) for plane in (True, False)]
    span = HORIZON - begin
    gain = 0.1 * span if kind == "from rest" else span**2 / 20
    if later > 6 * width:
        assert runs[0][1] == pytest.approx(gain + math.sqrt(math.pi), abs=1e-8)
    assert runs[0][:2] == pytest.approx(runs[1][:2], rel=1e-9)
    assert runs[0][2] == runs[1][2]


OTHERS = {
    "load": lambda plane, width: block(plane, lambda along, v: t / 10, load=1 + bell((t - 5.7) / width) / (10 * width)),
    "law": lambda plane, width: block(
        plane,
        lambda along, v: t / 10,
        law=sf.laws.custom(MU + bell((V - sp.Rational(4, 5)) / width) / 10, MU),
    ),
    "place": lambda plane, width: block(plane, lambda along, v: t / 10 + bell((along - 1) / width) / (10 * width)),
    "speed": lambda plane, width: block(plane, lambda along, v: t / 10 + bell((v - 0.5) / width) / (20 * width)),
}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("width", [0.1, 0.004])
@pytest.mark.parametrize("kind", OTHERS)
def test_other_pulses_act_as_on_a_contact_along_a_line(kind, width):
    runs = [ends(OTHERS[kind](plane, width), 1e-10) for plane in (True, False)]
    expected = ["slip", "stick", "slip"] if kind == "load" else ["slip"]  # a load that rises stops the slow block
    assert runs[0][2] == runs[1][2] == expected
    assert runs[0][:2] == pytest.approx(runs[1][:2], rel=1e-8)
    still = ends(block(False, lambda along, v: t / 10), 1e-10)
    assert abs(still[1] - runs[1][1]) > 1e-3
