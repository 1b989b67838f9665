"""Friction shared by parallel sticking contacts: rooms and forces against the sums written out."""

from itertools import product
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.lower.automaton import lower
from symfric.lower.constraint_forces import HOLDS, SHARES
from symfric.lower.load_sharing import rooms_left

LOADS, STICK = np.array([2.0, 3.0, 0.5, 1.5]), np.array([0.5, 0.2, 0.8, 0.4])
MORE = np.array([0.1, 0.2, 0.3, 0.4])  # share by which the load is larger where the contact slips forwards


class Edges:
    """Loads that differ with the direction of the slip, as on the edge of two cells."""

    def __init__(self, jumps):
        self.switches = (0,) if jumps else ()

    def towards(self, i, way, load):
        return load * (1 + way * MORE[i]) if self.switches else load


def shared(factors, modes, forces, jumps, loads=LOADS):
    """Return friction and rooms of three parallel contacts and a fourth of its own."""
    groups = [(0, 1.0), (0, factors[0]), (0, factors[1]), (3, 1.0)]
    model = SimpleNamespace(
        parallels=groups,
        edges=Edges(jumps),
        load=[ca.SX(v) for v in loads],
        static=ca.SX(STICK),
        read=float,
        s=[ca.SX(m) for m in modes],
        y=ca.SX.sym("y"),
        t=ca.SX.sym("t"),
        pressed=ca.SX(0, 1),
    )
    found, rooms = rooms_left(model, ca.SX(forces))
    number = lambda e: float(ca.evalf(ca.SX(e)))  # noqa: E731
    return [number(found[i]) for i in range(4)], [tuple(map(number, pair)) for pair in rooms]


def by_hand(factors, modes, forces, jumps):
    """The same: what sticks carries the force of its group in proportion to the bounds where all are about to slip."""
    f = np.array([1.0, *factors, 1.0])
    s, sticks = np.sign(f), np.isin(modes, (HOLDS, SHARES))
    friction, rooms = [], []
    for i in range(4):
        group = [k for k in ((0, 1, 2) if i < 3 else (3,)) if sticks[k]]
        carried = {}
        for way in (-1, 1):  # of the slip of contact i
            bound = LOADS * (1 + (way * s[i] * s * MORE if jumps else 0)) * STICK
            whole, reach = (sum(v[k] for k in group) for v in (f * forces, np.abs(f) * bound))
            carried[way] = s[i] * bound[i] * whole / reach if i in group and i < 3 else forces[i], bound[i]
        rooms.append((carried[-1][1] - carried[-1][0], carried[1][1] + carried[1][0]))
        friction.append(carried[-1][0] if carried[-1][0] >= 0 else carried[1][0])
    return friction, rooms


@pytest.mark.one_in(4)
@pytest.mark.parametrize("jumps", [False, True])
@pytest.mark.parametrize("factors", [(1.0, 1.0), (-2.0, 0.5), (3.0, -0.25), (-1.0, -4.0)])
def test_rooms_and_forces_are_those_written_out(factors, jumps):
    for modes in product((HOLDS, -1), (SHARES, 1), (SHARES, 1), (HOLDS,)):
        for pull in (-0.7, 0.0, 0.4):
            forces = np.array([pull, 0.0, 0.0, -pull / 2])
            if modes[0] != HOLDS:
                forces[1:3] = 0.3 * pull, -0.2 * pull  # of slip
            found, expected = shared(factors, modes, forces, jumps), by_hand(factors, modes, forces, jumps)
            assert found[0] == pytest.approx(expected[0], abs=1e-14)
            assert np.array(found[1]) == pytest.approx(np.array(expected[1]), abs=1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_slips_that_are_multiples_up_to_rounding_are_parallel(seed):
    """A third contact, whose slip differs from the first by more than rounding, is of its own."""
    draw = np.random.default_rng(seed)
    row, factor = draw.standard_normal(4), draw.uniform(-2.0, -0.5)
    q, u = sp.symbols("q0:4", real=True), sp.symbols("u0:4", real=True)
    near = row + 1e-9 * np.eye(4)[3]
    slips = [sum(float(e) * v for e, v in zip(r, u, strict=True)) for r in (row, factor * row, near)]
    scene = sf.Scene(
        system=sf.System(q=q, u=u, mass=sp.eye(4), force=[-e for e in q]),
        contacts=[sf.Contact(f"floor {i}", slip, 1, sf.laws.coulomb(0.3)) for i, slip in enumerate(slips)],
        initial=dict.fromkeys((*q, *u), 0.0),
        horizon=1.0,
    )
    assert lower(scene, [], frozenset()).parallels == (0, 0, 2)


@pytest.mark.parametrize("change", [0, 1e-3, 1e-7, 1e-12])
def test_multiples_of_slips_that_depend_on_the_place(change):
    """However they are written, whatever parameters they contain; a factor that changes on the way makes none."""
    x, y, u, w = sp.symbols("x y u w", real=True)
    a, b = sp.symbols("a b", positive=True)
    slip = u * sp.cos(x) + a * w * sp.sin(x + y)
    slips = [
        slip,
        sp.expand(-3 * b * slip),
        (1 + sp.Float(change) * sp.sin(x)) * slip,
        slip + change * u,
        sp.cos(x) * slip,
    ]
    scene = sf.Scene(
        system=sf.System([x, y], [u, w], sp.eye(2), [-x, -y]),
        contacts=[sf.Contact(f"floor {i}", s, 1, sf.laws.coulomb(0.3)) for i, s in enumerate(slips)],
        values={a: 0.7, b: 1.3},
        initial=dict.fromkeys((x, y, u, w), 0.1),
        horizon=1.0,
    )
    assert lower(scene, [], frozenset()).parallels == ((0, 0, 0, 0, 4) if change == 0 else (0, 0, 2, 3, 4))


def test_contacts_without_load_share_nothing():
    modes, forces = (HOLDS, SHARES, SHARES, HOLDS), np.array([0.4, 0.0, 0.0, 0.1])
    found, rooms = shared((1.0, -1.0), modes, forces, False, loads=np.array([0.0, 0.0, 0.0, 1.0]))
    assert found == [0.4, 0.0, 0.0, 0.1]
    assert rooms[0] == (-0.4, 0.4)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("factor", [3, -2, sp.Symbol("c", positive=True)])
def test_slips_whose_coefficients_are_parameters_share_in_proportion_to_their_bounds(factor):
    """While they hold; the ratio of the slips is a number, or a parameter of known sign, and those of velocities are not."""
    x, y, u, w = sp.symbols("x y u w", real=True)
    a, b = sp.symbols("a b", positive=True)
    slip = a * u - b * w
    contacts = [
        sf.Contact("one", slip, 1, sf.laws.coulomb(0.4)),
        sf.Contact("two", factor * slip, 2, sf.laws.coulomb(0.3)),
    ]
    pulls = {"first": sf.At(sf.friction_force("one"), 1.0), "second": sf.At(sf.friction_force("two"), 1.0)}
    system = sf.System([x, y], [u, w], sp.eye(2), [0.3 * a, -0.3 * b])  # along the slip: it is held
    values = {a: 0.6, b: 0.8} | ({factor: 2.5} if isinstance(factor, sp.Symbol) else {})
    run = sf.simulate(sf.Scene(system, contacts, values, {x: 0, y: 0, u: 0, w: 0}, 2.0, pulls), 1e-10).checked()
    ratio = float(values.get(factor, factor))
    assert run["first"] + ratio * run["second"] == pytest.approx(-0.3)
    assert run["second"] / run["first"] == pytest.approx(np.sign(ratio) * 0.6 / 0.4)
