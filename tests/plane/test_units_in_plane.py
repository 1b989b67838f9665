"""Other units of force and length give the same motion in the plane."""

import dataclasses

import pytest
import sympy as sp

import symfric as sf
from tests.plane.plane_scenes import drawn, drawn_bodies

x, y, u, w = sp.symbols("x y u w", real=True)
t = sf.TIME
FORCES = (2.0**-40, 2.0**40)  # of one unit over the other
LENGTHS = (2.0**-20, 2.0**20)


def in_other_units(made, force, length):
    """Return a drawn scene in which masses and forces are so many times as large, and lengths as well."""
    whole = force * length  # of forces, whose unit holds a length too
    tables = [
        dataclasses.replace(
            c,
            load=whole * c.load,
            belt=length * c.belt,
            shake=length * c.shake,
            v_s=length * c.v_s if c.v_s else c.v_s,
        )
        for c in made.tables
    ]
    matrices = {name: force * getattr(made, name) for name in ("M", "K", "D", "G")}
    loads = {name: whole * getattr(made, name) for name in ("f", "pull")}
    return dataclasses.replace(made, **matrices, **loads, tables=tuple(tables), start=length * made.start)


def same(made, force, length):
    here = sf.simulate(made.scene(), 1e-10).checked()
    there = sf.simulate(in_other_units(made, force, length).scene(), 1e-10).checked()
    assert [e.kind for e in here.events] == [e.kind for e in there.events]
    assert [e.t for e in there.events] == pytest.approx([e.t for e in here.events], rel=1e-12, abs=1e-12)
    assert there.final / length == pytest.approx(here.final, abs=1e-10)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("seed", [3, 8, 11, 25])
@pytest.mark.parametrize("force", FORCES)
def test_another_unit_of_force(seed, force):
    same(drawn(seed), force, 1.0)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("seed", [3, 8, 11])
@pytest.mark.parametrize("length", LENGTHS)
def test_another_unit_of_length(seed, length):
    made = drawn(seed)
    if made.swing:
        made = dataclasses.replace(made, swing=0.0)  # a mass depends on the sine of a place
    same(made, 1.0, length)


@pytest.mark.long(beside="test_another_unit_of_force")
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("force", FORCES)
def test_another_unit_of_force_on_feet(seed, force):
    same(drawn_bodies(seed), force, 1.0)


@pytest.mark.long(beside="test_another_unit_of_force")
def test_feet_whose_loads_are_thousandths():
    """The square of a force was measured by the size of a speed: feet of some milligrams never came to slip."""
    same(drawn_bodies(6), 2.0**-15, 1.0)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("force", [1e-12, 1e-10, 1e12])
def test_one_that_sticks_beside_one_that_slides(force):
    """The force of 1 N in another unit was taken for a turn of directions that needs none, beyond 1e9 of these."""

    def moved(unit):
        contacts = [
            sf.Contact("ground", (u, w), unit, sf.laws.coulomb(0.3, 0.2)),
            sf.Contact("belt", (u - 0.3, w), unit, sf.laws.coulomb(0.2, 0.12)),
        ]
        system = sf.System([x, y], [u, w], [[unit, 0], [0, 0.56 * unit]], [unit * t / 5, unit / 10])
        start = dict.fromkeys((x, y, u, w), 0.0)
        return sf.simulate(sf.Scene(system, contacts, {}, start, 3.0), 1e-10).checked()

    here, there = moved(1.0), moved(force)
    assert [e.kind for e in there.events] == [e.kind for e in here.events] == ["slip"]
    assert there.final == pytest.approx(here.final, abs=1e-10)
