"""Contacts behind springs beside contacts that open: the friction of one bears on the load of the other."""

import pytest
import sympy as sp

import symfric as sf

x, y, z, u, v, w = sp.symbols("x y z u v w", real=True)
OPENING = {
    "without friction": (None, None),
    "along a line": (w, sf.laws.coulomb(0.3)),
    "where friction drops": (w, sf.laws.coulomb(0.3, 0.2)),
    "in the plane": ((v, w), sf.laws.coulomb(0.3)),
}


def moved(kind, slip, floor, tolerance, law=None):
    """Return the run of a body that a spring pulls onto a floor, with a contact behind a spring along the gap."""
    along, friction = OPENING[kind]
    rubs = {} if friction is None else {"law": friction}
    law, spring = (law, {}) if law else (sf.laws.coulomb(0.3), {"stiffness": 20.0})
    contacts = [
        sf.Contact("spring", slip, 1, law, **spring),
        sf.Contact("floor", along, sf.Unilateral(x + floor, 0.5), **rubs),
    ]
    system = sf.System([x, y, z], [u, v, w], sp.eye(3), [-x - sp.Rational(1, 2), -y, -z])
    start = {x: 0.1, y: 0.5, z: 0, u: 0, v: 0, w: 0.3}
    return sf.simulate(sf.Scene(system, contacts, {}, start, 4.0), tolerance).checked()


@pytest.mark.one_in(4)
@pytest.mark.parametrize("slip", [u, u - w])
@pytest.mark.parametrize("kind", OPENING)
def test_a_spring_along_the_gap(kind, slip):
    run, finer = (moved(kind, slip, 0.02, tolerance) for tolerance in (1e-9, 1e-12))
    assert {e.contact for e in run.events} == {"spring", "floor"}
    assert run.final == pytest.approx(finer.final, abs=1e-7)
    assert finer.energy_residual() < 1e-10


def test_a_floor_out_of_reach_changes_nothing():
    far = [moved(kind, u, 1e3, 1e-12) for kind in ("without friction", "along a line")]
    assert far[0].final == pytest.approx(far[1].final, abs=1e-12)


def test_several_sliders_along_the_gap():
    law = sf.laws.maxwell_slip([10.0, 5.0], [0.2, 0.1])
    run, finer = (moved("along a line", u - w, 0.02, tolerance, law) for tolerance in (1e-9, 1e-12))
    assert run.final == pytest.approx(finer.final, abs=1e-7)
