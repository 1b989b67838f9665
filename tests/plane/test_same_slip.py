"""Contacts in the plane with one slip, those of a slab that does not turn: their discs add up to one disc."""

from functools import cache

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve.facts import warn_of_redundance
from tests.longer import longer

x, y, u, w = sp.symbols("x y u w", real=True)
t, scale = sf.TIME, sp.Symbol("scale", positive=True)


def slab(contacts, horizon=20.0):
    forces = [0.9 * sp.cos(0.9 * t) - x - 0.3 * y, 0.7 * sp.sin(1.4 * t) - 0.3 * x - 2.5 * y - 0.05 * w]
    system = sf.System([x, y], [u, w], [[1, 0], [0, 1.7]], forces)
    start = {x: 0.0, y: 0.3, u: 0.1, w: -0.2}
    return sf.Scene(system, contacts, {scale: 1.0}, start, horizon, {"path": sf.Trajectory(), "events": sf.Events()})


def contact(name, load, slip=(u, w), factor=1.0, drop=1.0):
    law = sf.laws.coulomb(0.6 * factor * scale, 0.6 * factor * drop * scale)
    return sf.Contact(name, slip, load, law)


FAMILY = {
    "feet": [contact("a", 0.3), contact("b", 0.2), contact("c", 0.5)],
    "other laws": [contact("a", 0.3), contact("b", 0.35, factor=2)],
    "turned and mirrored": [contact("a", 0.3), contact("b", 0.2, (-w, u)), contact("c", 0.5, (u, -w))],
    "a gear": [contact("a", 0.4), contact("b", 0.3, (2 * u, 2 * w))],
    "without load": [contact("a", 1), contact("b", 0)],
    "all together": [
        contact("a", 0.4),
        contact("b", 0.15, (-2 * w, 2 * u)),
        contact("c", 0.15, factor=2),
        contact("d", 0),
    ],
}


@cache
def one_contact():
    return sf.simulate(slab([contact("slab", 1)]), tolerance=1e-13).checked()


@pytest.mark.parametrize("order", longer([1, -1], [-1]))
@pytest.mark.parametrize("family", longer(FAMILY, [name for name in FAMILY if name != "a gear"]))
def test_they_are_one_contact(family, order):
    one = one_contact()
    run = sf.simulate(slab(FAMILY[family][::order]), tolerance=1e-13).checked()
    assert run.final == pytest.approx(one.final, abs=1e-13)
    for name in (c.name for c in FAMILY[family]):
        mine = [e for e in run.events if e.contact == name]
        assert [e.kind for e in mine] == [e.kind for e in one.events] == ["stick", "slip"]
        assert [e.t for e in mine] == pytest.approx([e.t for e in one.events], abs=1e-13)
    assert run.energy_residual() < 1e-12


@pytest.mark.long(beside="test_they_are_one_contact")
def test_with_a_drop_of_friction_and_derivatives():
    """The drop starts the slip with an acceleration; the load of one foot comes from its place."""
    split = [contact("a", 0.4 + 0.1 * x, drop=0.9), contact("b", 0.6 - 0.1 * x, (-w, u), drop=0.9)]
    names = ["scale", "x", "w"]
    runs = [
        sf.simulate(slab(contacts), tolerance=1e-11, sensitivities=names).checked()
        for contacts in (split, [contact("slab", 1, drop=0.9)])
    ]
    assert len(runs[0].events) == 2 * len(runs[1].events) > 2
    assert runs[0].final == pytest.approx(runs[1].final, abs=1e-11)
    for name in names:
        assert runs[0].sensitivities[name] == pytest.approx(runs[1].sensitivities[name], abs=1e-5)


@pytest.mark.long(beside="test_advice_is_one_that_can_be_followed")
def test_they_rest_to_the_last_bit():
    scene = slab(FAMILY["turned and mirrored"])
    still = sf.Scene(
        sf.System([x, y], [u, w], [[1, 0], [0, 1.7]], [-0.1 * x, -0.1 * y]),
        scene.contacts,
        scene.values,
        scene.initial,
        1e5,
        scene.outputs,
    )
    run = sf.simulate(still, tolerance=1e-13).checked()
    assert np.all(run.final[2:] == 0.0)
    assert run.final[:2] == pytest.approx(sf.simulate(still.until(10.0), tolerance=1e-13).final[:2], abs=1e-15)


@pytest.mark.long(beside="test_advice_is_one_that_can_be_followed")
def test_turned_frames_hold_what_one_contact_holds():
    """A disc turned is the same disc, though no component of its slip is one of the other's."""
    one = one_contact()
    turned = contact("b", 0.6, (0.6 * u + 0.8 * w, 0.6 * w - 0.8 * u))
    run = sf.simulate(slab([contact("a", 0.4), turned]), tolerance=1e-13).checked()
    assert run.final == pytest.approx(one.final, abs=1e-9)
    for name in "ab":
        mine = [e for e in run.events if e.contact == name]
        assert [e.kind for e in mine] == [e.kind for e in one.events] == ["stick", "slip"]
        assert [e.t for e in mine] == pytest.approx([e.t for e in one.events], abs=1e-9)
    assert run.energy_residual() < 1e-11


@pytest.mark.long(beside="test_advice_is_one_that_can_be_followed")
def test_a_warning_names_each_contact_once(caplog):
    names = tuple(f"foot {k}" for k in range(3))
    warn_of_redundance.cache_clear()  # each set of names is told once
    sf.prepare(slab([contact(name, 1) for name in names]))
    told = [m for m in caplog.messages if "redundant" in m]
    assert len(told) == 1
    assert "slip of foot 1, foot 2 follows" in told[0]


def test_advice_is_one_that_can_be_followed():
    with pytest.raises(sf.SceneError, match="needs a scene without excitation"):
        sf.stability(slab([contact("a", 1)]))
