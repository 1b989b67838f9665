"""Bodies that sticking contacts hold have the acceleration of the constraints, without the rounding of the forces."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.lower.automaton import lower

X, Y, Z, U, V, W = sp.symbols("x y z u v w", real=True)
PULLS = [0.7 - 1.1 * X + 0.3 * Y, 0.3 + 0.3 * X - 0.9 * Y, 0.2 - 0.1 * Z]
PAIRS = {
    "joint": [U - V, U],
    "skew": [U + V, U - 2 * V],
    "oblique": [U + 0.3 * V, U - 0.7 * V],
    "nearly parallel, 1e-6": [U + V, U + (1 + 1e-6) * V],
    "nearly parallel, 1e-9": [U + 0.3 * V, U + (0.3 + 1e-9) * V],
    "small units": [1e-9 * U + 0.4 * V, 1e-9 * U - 0.7 * V],
}
THREE = {
    "chain": [V - W, U, U - V],
    "skew": [U + V + W, U - V, V - 3 * W],
    "nearly parallel": [U - V, U - (1 + 1e-8) * V, V - W],
}


def rates(slips, mass, forces=PULLS, mode=None, seed=0):
    """Return the accelerations of held bodies at a place drawn by chance, and the field with its arguments."""
    n = mass.shape[0]
    q, u = (X, Y, Z)[:n], (U, V, W)[:n]
    law = sf.laws.coulomb(1.0, 0.7)
    contacts = [sf.Contact(f"c{k}", slip, 10.0, law) for k, slip in enumerate(slips)]
    system = sf.System(list(q), list(u), mass.tolist(), [sp.sympify(f) for f in forces[:n]])
    field = lower(sf.Scene(system, contacts, {}, dict.fromkeys([*q, *u], 0.0), 1.0)).field
    y = np.concatenate([np.random.default_rng(seed).normal(size=n), np.zeros(n)])
    m = np.ones(field.nnz_in(3))
    m[: len(slips)] = 1.0 if mode is None else mode
    return np.array(field(y, 0.3, np.zeros(field.nnz_in(2)), m)[0]).ravel()[n:]


def masses(n):
    """Return constant masses, diagonal and full, and one that moves."""
    diagonal = np.array(sp.diag(2, 3, 1.7)[:n, :n].tolist(), dtype=float)
    moving = np.array(sp.Matrix(n, n, lambda i, k: (2 + sp.cos(X)) if i == k else 0.3 * sp.sin(Y)).tolist())
    return {"diagonal": diagonal, "full": diagonal + 0.3, "moving": moving}


@pytest.mark.one_in(6)
@pytest.mark.parametrize("mass", ["diagonal", "full", "moving"])
@pytest.mark.parametrize("name", PAIRS)
def test_two_bodies_that_contacts_hold_do_not_accelerate(name, mass):
    for seed in range(3):
        assert np.all(rates(PAIRS[name], masses(2)[mass], seed=seed) == 0.0)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("mass", ["diagonal", "full", "moving"])
@pytest.mark.parametrize("name", THREE)
def test_three_bodies_that_contacts_hold_do_not_accelerate(name, mass):
    for seed in range(3):
        assert np.all(rates(THREE[name], masses(3)[mass], seed=seed) == 0.0)


def test_a_loop_holds_with_its_independent_contacts():
    assert np.all(rates([U - V, V - W, W - U, U], masses(3)["full"], mode=[1, 1, 2, 1]) == 0.0)


@pytest.mark.parametrize("mass", ["diagonal", "full"])
def test_what_contacts_do_not_hold_still_moves(mass):
    """Two of three constraints leave one motion; where they hold two of the bodies, only the third moves."""
    free = rates([U - V, V - W], masses(3)[mass])
    assert np.ptp(free) <= 1e-15
    assert abs(free[0]) > 1e-3
    u, v, w = rates([U + V, U - 2 * V, V - W], masses(3)[mass], mode=[1, 1, 0])
    assert (u, v) == (0.0, 0.0)
    assert abs(w) > 1e-3
    u, v, w = rates([U, V + W], masses(3)[mass])
    assert u == 0.0
    assert v == pytest.approx(-w, rel=1e-12)
    assert abs(v) > 1e-3


@pytest.mark.parametrize("weak", [1e-6, 1e-9, 1e-12])
def test_a_slip_that_hardly_depends_on_a_second_velocity_does_not_hold_the_first(weak):
    u, v = rates([U + weak * V], masses(2)["diagonal"])
    assert u == pytest.approx(-weak * v, rel=1e-3)
    assert abs(v) > 1e-3


def test_held_bodies_follow_accelerating_ground():
    drive = sp.sin(sf.TIME)
    u, v = rates([U + V - drive, U - 2 * V], masses(2)["full"])
    assert [u, v] == pytest.approx([2 / 3 * np.cos(0.3), np.cos(0.3) / 3], rel=1e-14)


def test_slopes_that_move_hold_when_there_are_as_many_as_velocities():
    u, v = rates([sp.exp(X) * U - V, U + V * sp.exp(Y)], masses(2)["full"])
    assert (u, v) == (0.0, 0.0)
    u, v = rates([sp.exp(X) * U - V, U + V * sp.exp(Y)], masses(2)["full"], mode=[1, 0])
    assert abs(u) > 1e-3
