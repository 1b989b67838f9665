"""Slips that begin under a law with an infinite slope at rest, wherever their contact lies.

The same motion in other coordinates, in which the slip is that of several velocities, and with contacts of the same
velocity beside it, has to be the same motion.
"""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, y, u, w = sp.symbols("x y u w", real=True)
v = sp.Symbol("v", real=True)
LAW = sf.laws.square_root(0.25, -0.125, 0.3, 0.125)


def scene(turned, mu_s=0.3, offset=0.0):
    """Return two masses of which one rubs, in coordinates turned by a matrix."""
    T = sp.Matrix(turned)
    q, du = T * sp.Matrix([x, y]), T * sp.Matrix([u, w])
    push = sp.Matrix([0.6 * sp.sin(1.3 * sf.TIME) - q[0] - (q[0] - q[1]), -(q[1] - q[0]) - 0.1 * du[1]])
    start = T.inv() * sp.Matrix([-0.9, 0.2])
    speed = T.inv() * sp.Matrix([offset, 0.3])
    law = sf.laws.square_root(0.25, -0.125, mu_s, 0.125)
    return sf.Scene(
        system=sf.System([x, y], [u, w], T.T * sp.diag(1, 2) * T, list(T.T * push)),
        contacts=[sf.Contact("pad", slip=sp.expand(du[0]), normal=sp.Float(1), law=law)],
        initial=dict(zip([x, y, u, w], map(float, (*start, *speed)), strict=True)),
        horizon=8.0,
    )


@pytest.mark.one_in(6)
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("mu_s", [0.25, 0.4])
def test_turned_coordinates_show_the_same_motion(mu_s, seed):
    turned = np.round(np.random.default_rng(seed).uniform(-1, 1, (2, 2)), 2) + 1.5 * np.eye(2)
    plain = sf.simulate(scene(np.eye(2), mu_s), tolerance=1e-11).checked()
    for tolerance in (1e-6, 1e-9, 1e-11):
        run = sf.simulate(scene(turned, mu_s), tolerance=tolerance).checked()
        found = np.kron(np.eye(2), turned) @ run.final
        assert np.max(np.abs(found - plain.final)) < 300 * tolerance
        assert [(e.before, e.after) for e in run.events] == [(e.before, e.after) for e in plain.events]


@pytest.mark.one_in(8)
@pytest.mark.parametrize("slip", [u - v, u, 2 * u - v, u + v])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_contacts_of_one_velocity_stop_together(tolerance, slip):
    """The velocity was made zero once for each of them, from one measurement."""
    pad = sf.Contact("pad", slip=slip, normal=sp.Float(1), law=sf.laws.square_root(0.25, -0.125, 0.25, 0.125))
    rail = sf.Contact("rail", slip=u, normal=sp.Float(1), law=sf.laws.coulomb(0.25))
    force = 0.25 * sp.sin(sf.TIME) - sp.tanh(2 * x) - x
    finals = []
    for contacts in ([pad, rail], [rail, pad]):
        made = sf.Scene(
            system=sf.System([x], [u], [[1]], [force]),
            contacts=contacts,
            values={v: 0.0} if slip.has(v) else {},
            initial={x: -1.0, u: 0.0},
            horizon=4.0,
        )
        finals.append(sf.simulate(made, tolerance=tolerance, route="taylor").checked().final)
    assert np.max(np.abs(finals[0] - finals[1])) < 10 * tolerance
    if slip.coeff(u) == 1:  # found by steps of the differential equation with a smoothed law
        assert finals[0] == pytest.approx([-0.283374, -0.381710], abs=2e-6)


def test_a_stop_beside_the_start_of_a_slip_is_not_stepped_over():
    """A slip of 1e-9 ends sooner than the short step with which the slip of another contact begins."""
    pad = sf.Contact("pad", slip=u / 2 + w - v, normal=sp.Float(0.6), law=sf.laws.square_root(0.5, -0.03, 0.6))
    rail = sf.Contact("rail", slip=u, normal=sp.Float(1.6), law=sf.laws.coulomb(0.4))
    ends = []
    for small in (0.0, 1e-9, -1e-9):
        made = sf.Scene(
            system=sf.System([x, y], [u, w], sp.diag(0.5, 0.8), [2.0 - x, -1.0 - y]),
            contacts=[pad, rail],
            values={v: 0.04},
            initial={x: 0.8, y: -0.3, u: small, w: 0.04 - small / 2},
            horizon=3.0,
        )
        ends.append(sf.simulate(made, tolerance=1e-9).checked().final)
    assert np.max(np.abs(np.array(ends) - ends[0])) < 1e-7


def two_pads(turned):
    """Return two masses, of which one rubs on the ground and both on each other, in coordinates turned by a matrix."""
    T = sp.Matrix(turned)
    q, du = T * sp.Matrix([x, y]), T * sp.Matrix([u, w])
    push = sp.Matrix([0.4 * sp.sin(3 * sf.TIME) - 3 * q[0] + q[1], 0.3 * sp.sin(2 * sf.TIME) - 3 * q[1] + q[0]])
    return sf.Scene(
        system=sf.System([x, y], [u, w], T.T * sp.diag(1.5, 1) * T, list(T.T * push)),
        contacts=[
            sf.Contact("ground", slip=sp.expand(du[1]), normal=sp.Float(1.9), law=sf.laws.coulomb(0.4)),
            sf.Contact("pad", sp.expand(du[0] - du[1]), sp.Float(1.8), sf.laws.square_root(0.3, -0.09, 0.3, 0.09)),
        ],
        initial={x: 0, y: 0, u: 0, w: 0},
        horizon=4.0,
    )


@pytest.mark.long(beside="test_turned_coordinates_show_the_same_motion")
def test_a_slip_between_two_bodies_turns_while_one_of_them_sticks():
    """The velocity that is left, and the terms of the slip, are as small as its rounding was before it fell to zero.

    In coordinates of which one is the distance of the bodies the same slip is one velocity, and exactly zero.
    """
    apart = sp.Matrix([[1, 1], [0, 1]])
    plain, other = (sf.prepare(two_pads(turned), 1e-8, "taylor") for turned in (sp.eye(2), apart))
    draw, turns = np.random.default_rng(0), 0
    for _ in range(40):
        start = draw.uniform(-1.2, 1.2, 4) * [1, 1, 1, 0.5]
        run = plain.run({}, dict(zip("xyuw", start, strict=True))).checked()
        moved = np.kron(np.eye(2), np.array(apart.inv(), float)) @ start
        right = other.run({}, dict(zip("xyuw", moved, strict=True))).checked()
        assert run.final == pytest.approx(np.kron(np.eye(2), np.array(apart, float)) @ right.final, abs=1e-5)
        turns += sum(e.kind == "reverse" and e.contact == "pad" for e in run.events)
    assert turns > 10


SPEED = sf.SPEED
SMOOTH = {
    "tanh": sp.tanh(4 * SPEED) / 5,
    "arctangent": sp.Rational(2, 5) / sp.pi * sp.atan(9 * SPEED),
    "exponential": (1 - sp.exp(-5 * SPEED)) / 5,
    "line and stop": sp.Min(SPEED, sp.Rational(1, 5)),
}


@pytest.mark.one_in(16)
@pytest.mark.parametrize("slip", [u, 2 * u, u - w, u + w / 2])
@pytest.mark.parametrize("kind", SMOOTH)
def test_a_slip_without_stick_that_others_hold_at_zero_does_not_begin(kind, slip):
    """It was within its rounding at every step: these were as short as at a singular start, and the run gave up."""
    pads = [sf.Contact("pad", u, 0.8, sf.laws.coulomb(0.5, 0.4)), sf.Contact("rail", w, 0.4, sf.laws.coulomb(0.5))]
    oil = sf.Contact("oil", slip, 1, sf.laws.Law(kinetic=SMOOTH[kind], stick=sp.Integer(0)))
    force = [0.7 * sp.sin(1.3 * sf.TIME) - x - (x - y) / 2, sp.cos(2.1 * sf.TIME) / 2 - (y - x) / 2 - y]
    start = {x: 0.9, y: -0.4, u: 0.3, w: -0.2}
    made = sf.Scene(sf.System([x, y], [u, w], sp.eye(2), force), [*pads, oil], {}, start, 12.0)
    series, other = (sf.simulate(made, 1e-10, route).checked() for route in ("taylor", "integrators"))
    assert any(e.after == 0 for e in series.events)
    assert series.final == pytest.approx(other.final, abs=1e-8)
