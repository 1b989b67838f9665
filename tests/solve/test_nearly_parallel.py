"""Contacts whose slips nearly agree: on one body or several, up to five of them, against references of their own."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer
from tests.solve.enumerated_modes import Friction, failures, stepped


def nearly_parallel(seed, apart, drop=None, horizon=5.0):
    """Two or three masses with two to four contacts whose rows differ by `apart`; the scene, and what it is made of."""
    rng = np.random.default_rng([15, seed])
    n, n_c = int(rng.integers(2, 4)), int(rng.integers(2, 5))
    roots = rng.normal(size=(n, n))
    stiffness = 0.3 * roots @ roots.T + 0.5 * np.eye(n)
    groups = 1 if rng.random() < 0.6 else 2
    rows = np.eye(n)[:groups] if rng.random() < 0.4 else np.round(rng.normal(size=(groups, n)), 2)
    J = np.array([rows[i % groups] + apart * rng.normal(size=n) * (i > 0 or rng.random() < 0.5) for i in range(n_c)])
    belts = rng.choice([0.0, 0.2]) + apart * rng.normal(size=n_c) * rng.choice([0.0, 1.0], n_c)
    kinetic = rng.uniform(0.1, 0.6, n_c)
    more = rng.uniform(0, 0.1, n_c) if drop is None else drop * kinetic
    friction = Friction(
        mass=rng.uniform(0.5, 2, n),
        stiffness=stiffness,
        damping=0.03 * stiffness,
        constant=0.2 * rng.normal(size=n) * (rng.random() < 0.5),
        drive=0.6 * rng.normal(size=n) * (rng.random() < 0.6),
        Omega=float(rng.uniform(0.6, 2)),
        J=J,
        belts=belts,
        static=kinetic + more,
        kinetic=kinetic,
    )
    start = np.concatenate([rng.uniform(-1, 1, n), rng.uniform(-1, 1, n) * (rng.random() < 0.7)])
    q, u = sp.symbols(f"q1:{n + 1}", real=True), sp.symbols(f"u1:{n + 1}", real=True)
    position, velocity = sp.Matrix(q), sp.Matrix(u)
    force = sp.Matrix(friction.constant) + sp.Matrix(friction.drive) * sp.sin(friction.Omega * sf.TIME)
    force -= sp.Matrix(stiffness) * position + sp.Matrix(friction.damping) * velocity
    slips = sp.Matrix(J) * velocity - sp.Matrix(belts)
    laws = [sf.laws.coulomb(1.0 + m / k, 1.0) for m, k in zip(more, kinetic, strict=True)]
    contacts = [sf.Contact(f"c{i}", slips[i], kinetic[i], laws[i]) for i in range(n_c)]
    system = sf.System(q, u, sp.diag(*map(float, friction.mass)), list(force))
    initial = dict(zip([*q, *u], start, strict=True))
    return sf.Scene(system, contacts, {}, initial, horizon), friction, start


APART = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9]


@pytest.mark.parametrize("seed", longer(range(12), set(range(12)) - {7}))
@pytest.mark.parametrize("apart", longer(APART, set(APART) - {1e-7}))
def test_nearly_parallel_contacts_obey_equations_and_law(seed, apart):
    scene, friction, _ = nearly_parallel(seed, apart)
    for route in ("taylor", "exact"):
        run = sf.simulate(scene, 1e-10, route).checked()
        assert failures(friction, run, 1e-8 + 1e-14 / apart) == []  # slips are right to 1e-16 or so


@pytest.mark.one_in(6)
@pytest.mark.parametrize("seed", longer(range(100, 108), range(103, 108)))
@pytest.mark.parametrize("apart", [1e-6, 1e-8])
def test_nearly_parallel_contacts_against_steps_that_try_all_modes(seed, apart):
    scene, friction, start = nearly_parallel(seed, apart, drop=0.0, horizon=3.0)
    n = friction.mass.size
    coarse, fine = (stepped(friction, start[:n], start[n:], 3.0, k) for k in (600, 1200))
    run = sf.simulate(scene, 1e-10).checked()
    error = np.max(np.abs(run.final - fine))
    assert error < 2 * np.max(np.abs(coarse - fine)) + 2e-3


@pytest.mark.one_in(2)
@pytest.mark.parametrize("apart", [1e-6, 1e-7, 1e-9, 1e-11])
def test_two_nearly_parallel_contacts_hold_a_body_and_release_it_in_turn(apart):
    """Both hold until the second would carry more across than its bound times the difference of the rows."""
    x, y, u, w = sp.symbols("x y u w", real=True)
    t = sf.TIME
    # along the rows a constant force, across them one that grows: lambda_2 = -F_y / apart, lambda_1 = -F_x - lambda_2
    force = [sp.Rational(1, 5), apart * t / 10]
    contacts = [sf.Contact("a", u, 1, sf.laws.coulomb(0.5)), sf.Contact("b", u + apart * w, 1, sf.laws.coulomb(0.25))]
    scene = sf.Scene(sf.System([x, y], [u, w], sp.eye(2), force), contacts, {}, {x: 0, y: 0, u: 0, w: 0}, 4)
    for route in ("taylor", "exact"):
        run = sf.simulate(scene, 1e-10, route).checked()
        # of the unit masses: lambda_2 (1 + apart^2) - ... = -t / 10, its bound is reached at 2.5
        assert [(e.contact, e.kind) for e in run.events] == [("b", "slip")]
        assert run.events[0].t == pytest.approx(2.5, rel=1e-4)
        assert run.final[:2] == pytest.approx([0, apart * 0.1 * 1.5**3 / 6], abs=1e-12)


def test_rows_that_differ_by_rounding_are_parallel():
    x, y, u, w = sp.symbols("x y u w", real=True)
    law = sf.laws.coulomb(0.5, 0.3)
    system = sf.System([x, y], [u, w], sp.eye(2), [-x, -y])
    start = {x: 1.5, y: 0.4, u: 0.0, w: 0.0}
    for other in (0.3 * u + 0.6 * w, 3 * (0.1 * u + 0.2 * w), 0.1 * u + 0.2 * w * (1 + 1e-15)):
        two = [sf.Contact("a", 0.1 * u + 0.2 * w, 4, law), sf.Contact("b", other, 3, law)]
        factor = float(other.coeff(u)) / 0.1
        one = [sf.Contact("a", 0.1 * u + 0.2 * w, 4 + 3 * factor, law)]
        found, expected = (sf.simulate(sf.Scene(system, c, {}, start, 20), 1e-11).checked() for c in (two, one))
        assert found.final == pytest.approx(expected.final, abs=1e-8)
        assert len(found.events) == 2 * len(expected.events)


@pytest.mark.parametrize("seed", longer(range(6), range(5)))
@pytest.mark.parametrize("apart", longer(APART, APART[1:]))
def test_integrators_are_right_or_say_that_they_cannot_tell_slips_apart(seed, apart):
    scene, *_ = nearly_parallel(seed, apart)
    right = sf.simulate(scene, 1e-12, "taylor").checked()
    run = sf.simulate(scene, 1e-9, "integrators")
    if apart == max(APART) or run.status == sf.Status.OK:
        assert run.checked().final == pytest.approx(right.final, abs=1e-6)
    else:
        assert run.status == sf.Status.INTEGRATOR


def test_integrators_decline_slips_that_differ_by_less_than_their_error():
    u1, u2 = sp.symbols("u1 u2", real=True)
    q1, q2 = sp.symbols("q1 q2", real=True)
    system = sf.System([q1, q2], [u1, u2], sp.eye(2), [-q1 - (q1 - q2), -q2 - (q2 - q1)])
    law = sf.laws.coulomb(sp.Float(0.3))
    contacts = [sf.Contact("a", u1, 0.5, law), sf.Contact("b", u1 + 1e-10 * u2, 0.4, law)]
    scene = sf.Scene(system, contacts, {}, {q1: 1.0, q2: 0.0, u1: 0.0, u2: 0.5}, 6.0)
    assert sf.simulate(scene, 1e-9, "taylor").status == sf.Status.OK
    run = sf.simulate(scene, 1e-9, "integrators")
    assert run.status == sf.Status.INTEGRATOR
    assert "taylor" in run.advice


@pytest.mark.long(beside="test_integrators_are_right_or_say_that_they_cannot_tell_slips_apart")
@pytest.mark.parametrize("tolerance", [1e-8, 1e-10, 1e-12, 1e-13])
@pytest.mark.parametrize("apart", [1e-4, 1e-6, 1e-8, 1e-10])
def test_the_integrators_are_right_or_end_with_a_status(apart, tolerance):
    """Two bodies, the rows of whose contacts nearly agree: what is lost in rounding is not called a result."""
    rng = np.random.default_rng(5)
    x, y, u, v = sp.symbols("x y u v", real=True)
    for _ in range(2):
        k, c, a = rng.uniform(0.5, 3, 3)
        loads = rng.uniform(0.2, 0.6, 3)
        rows = (u - v, (1 + apart) * (u - v), u - v + apart * v)
        contacts = [
            sf.Contact(f"c{i}", w, float(n), sf.laws.coulomb(0.4))
            for i, (w, n) in enumerate(zip(rows, loads, strict=True))
        ]
        forces = [-k * x - c * (x - y) + a * sp.sin(2 * sf.TIME), c * (x - y) - y]
        start = dict(zip((x, y, u, v), rng.uniform(-1, 1, 4), strict=True))
        scene = sf.Scene(sf.System([x, y], [u, v], sp.eye(2), forces), contacts, {}, start, 3.0, {"end": sf.End()})
        run, series = sf.simulate(scene, tolerance, "integrators"), sf.simulate(scene, 1e-13, "taylor").checked()
        assert run.status in (sf.Status.OK, sf.Status.INTEGRATOR)
        if run.status == sf.Status.OK:
            assert run.final == pytest.approx(series.final, abs=1e3 * tolerance)
