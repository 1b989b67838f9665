"""The automaton's forces against linear algebra in NumPy, mode by mode, for random systems."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.lower.automaton import lower
from symfric.lower.energy import energy_functions
from tests.longer import longer

LAW = sf.laws.stribeck(0.4, 0.2, 0.5)


def random_scene(n, n_c, seed, varying_mass=False):
    """n coupled masses with n_c contacts of random directions, loads that vary, and a fast moving ground."""
    rng = np.random.default_rng(seed)
    q, u = sp.symbols(f"q:{n}", real=True), sp.symbols(f"u:{n}", real=True)
    root = rng.normal(size=(n, n)).round(3)
    mass = sp.Matrix(root @ root.T) + sp.eye(n) * (2 + (sp.cos(q[0]) if varying_mass else 0))
    force = [-3 * q[i] + sp.sin(q[(i + 1) % n]) * u[i] + sp.cos(sf.TIME) for i in range(n)]
    contacts = []
    for i in range(n_c):
        along = sum(float(c) * e for c, e in zip(rng.normal(size=n).round(3), u, strict=True))
        slip = along * (1 + q[0] ** 2 / 4 if i % 2 else 1) - sp.sin((i + 1) * sf.TIME) / 3
        contacts.append(sf.Contact(f"c{i}", slip, 9 + q[0], LAW, profile=1 + sp.sin(q[0]) ** 2 / 2))
    system = sf.System(q=q, u=u, mass=mass, force=force)
    return sf.Scene(system=system, contacts=contacts, initial=dict.fromkeys([*q, *u], 0.1), horizon=1.0)


def by_hand(scene, y, t, s, d):
    """Return u', the forces and the guards by dense linear algebra on numbers from SymPy."""
    system = scene.system
    n, point = len(system.q), dict(zip(system.states, y, strict=True)) | {sf.TIME: t}
    numbers = lambda e: np.array(sp.Matrix(e).subs(point), dtype=float)  # noqa: E731
    M, f = numbers(system.mass), numbers(list(system.force)).ravel()
    slips = sp.Matrix([c.slip for c in scene.contacts])
    J = numbers(slips.jacobian(sp.Matrix(system.u)))
    drift = numbers(slips.jacobian(sp.Matrix(system.q))) @ y[n : 2 * n] + numbers(slips.diff(sf.TIME)).ravel()
    w = numbers(slips).ravel()
    load = np.array([float((c.normal * c.profile).subs(point)) for c in scene.contacts])
    mu = 0.2 + 0.2 * np.exp(-d * w / 0.5)
    lam = np.where(s, 0.0, -d * load * mu)
    held = np.flatnonzero(s)
    a = np.linalg.solve(M, f + J.T @ lam)
    if held.size:
        Jh = J[held]
        A = Jh @ np.linalg.solve(M, Jh.T)
        lam[held] = np.linalg.lstsq(A, -(Jh @ a + drift[held]), rcond=None)[0]
        a = np.linalg.solve(M, f + J.T @ lam)
    return a, lam, w, load, M @ a - f - J.T @ lam, J @ a + drift


MODES = [(n, c, varying) for n, c in ((1, 1), (2, 1), (2, 2), (3, 2), (4, 3)) for varying in (False, True)]


@pytest.mark.one_in(10)
@pytest.mark.parametrize("mode", longer(MODES, [(4, 3, False)]))
def test_forces_and_accelerations_in_every_mode(mode):
    n, n_c, varying = mode
    scene = random_scene(n, n_c, seed=10 * n + n_c, varying_mass=varying)
    names = [c.name for c in scene.contacts]
    automaton = lower(scene, [sf.friction_force(name) for name in names] + [sf.slip(name) for name in names])
    rng = np.random.default_rng(1)
    for code in range(3**n_c):
        y, t = rng.normal(size=2 * n), rng.uniform(0, 3)
        kinds = [code // 3**i % 3 for i in range(n_c)]
        s, d = np.array([k == 2 for k in kinds]), np.array([-1.0 if k == 1 else 1.0 for k in kinds])
        rate, guards, rows = (np.array(e).ravel() for e in automaton.field(y, t, [], [*s.astype(float), *d]))
        a, lam, w, load, residual, slip_rate = by_hand(scene, y, t, s, d)
        size = max(1.0, np.max(np.abs(lam)), np.max(np.abs(a)))  # up to 4e4, where the law is taken far beyond rest
        assert np.max(np.abs(residual)) < 1e-13 * size
        assert rate[:n] == pytest.approx(y[n:], abs=0)
        assert rate[n:] == pytest.approx(a, rel=0, abs=1e-12 * size)
        assert rows[:n_c] == pytest.approx(lam, rel=0, abs=1e-12 * size)
        assert rows[n_c:] == pytest.approx(w, abs=1e-12)
        assert np.abs(slip_rate[s]) == pytest.approx(np.zeros(s.sum()), abs=1e-12 * size)  # a stick stays
        for i in range(n_c):
            pair = guards[2 * i : 2 * i + 2]
            expected = [0.4 * load[i] - lam[i], 0.4 * load[i] + lam[i]] if s[i] else [d[i] * w[i], 1.0]
            assert pair == pytest.approx(expected, rel=0, abs=1e-12 * size)
        assert guards[2 * n_c :] == pytest.approx(load, abs=1e-12)


def test_names_and_layout():
    scene = random_scene(3, 2, seed=5)
    automaton = lower(scene)
    assert automaton.states == ("q0", "q1", "q2", "u0", "u1", "u2")
    assert automaton.contacts == ("c0", "c1")
    assert automaton.layout.loads == ("c0", "c1")
    assert automaton.sticks == (True, True)
    assert automaton.layout.n_mode == 4
    assert automaton.layout.n_guards == 6
    assert not automaton.autonomous


def test_redundant_contacts_share_the_force_and_change_nothing():
    x, u = sp.symbols("x u", real=True)

    def scene(k):
        contacts = [sf.Contact(f"c{i}", (1 + i) * u - (1 + i) * 0.2, 1, LAW) for i in range(k)]
        system = sf.System(q=[x], u=[u], mass=[[2]], force=[-3 * x + sp.cos(sf.TIME)])
        return sf.Scene(system=system, contacts=contacts, initial={x: 0, u: 0}, horizon=1)

    y, t = [0.3, 0.2], 0.4
    alone = np.array(lower(scene(1)).field(y, t, [], [1, 1])[0]).ravel()
    assert alone[1] == 0
    three = lower(scene(3), [sf.friction_force(f"c{i}") for i in range(3)])
    rate, _, forces = (np.array(e).ravel() for e in three.field(y, t, [], [1, 3, 3, 1, 1, 1]))  # 3: shares with another
    assert rate == pytest.approx(alone, abs=1e-14)
    assert forces @ [1, 2, 3] == pytest.approx(-(-0.9 + np.cos(t)), abs=1e-13)  # together they hold the force
    assert forces == pytest.approx(np.full(3, forces[0]), abs=1e-13)  # equal loads, equal shares


def test_smooth_laws_never_stick_and_rubbing_bodies_may():
    x, u = sp.symbols("x u", real=True)
    for law, sticks in (
        (LAW, True),
        (LAW.regularised(1e-3), False),
        (sf.laws.coulomb(0), False),
        (sf.laws.coulomb(0.3).averaged(0.1), False),
    ):
        system = sf.System(q=[x], u=[u], mass=[[1]], force=[-x])
        scene = sf.Scene(system=system, contacts=[sf.Contact("c", u, 1, law)], initial={x: 0, u: 0}, horizon=1)
        assert lower(scene).sticks == (sticks,)


def test_parameters_that_are_zero_are_dropped_unless_they_vary():
    scene = sf.scenes.mass_on_belt(v_b=0.2)
    assert [s.name for s in lower(scene).parameters] == ["v_b", "beta", "gamma2"]
    assert lower(scene).autonomous
    varied = lower(scene, varied=frozenset({"a", "Omega"}))
    assert [s.name for s in varied.parameters] == ["v_b", "beta", "gamma2", "a", "Omega"]
    assert not varied.autonomous


def test_a_zero_in_a_denominator_is_kept():
    x, u, k, c = sp.symbols("x u k c", real=True)
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[-x / (k - 1) + u * sp.exp(k) / (1 + c)])
    scene = sf.Scene(system=system, values={k: 0.0, c: 0.0}, initial={x: 1, u: 0}, horizon=1)
    assert lower(scene).parameters == ()
    bad = sf.System(q=[x], u=[u], mass=[[1]], force=[-x * sp.sqrt(k + c) - sp.sin(k * u) * x ** (1 + c)])
    scene = sf.Scene(system=bad, values={k: 0.0, c: 0.0}, initial={x: 1, u: 0}, horizon=1)
    assert lower(scene).parameters == ()


@pytest.mark.parametrize("varying", [False, True])
def test_power_is_the_rate_of_the_kinetic_energy(varying):
    scene = random_scene(3, 2, seed=7, varying_mass=varying)
    power, kinetic = energy_functions(scene)
    automaton = lower(scene)
    rng = np.random.default_rng(2)
    for modes in ((1, -1), (0, 1), (-1, 0), (0, 0)):
        y, t = rng.normal(size=6), 0.7
        m = [*(float(k == 0) for k in modes), *(-1.0 if k < 0 else 1.0 for k in modes)]
        rate = np.array(automaton.field(y, t, [], m)[0]).ravel()
        slopes = []
        for h in (1e-3, 5e-4):
            ahead, behind = float(kinetic(y + h * rate, [])), float(kinetic(y - h * rate, []))
            slopes.append((ahead - behind) / (2 * h))
        applied, contact = (float(e) for e in power(y, t, [], modes))
        error = [abs(s - applied - contact) for s in slopes]
        assert error[1] < 1e-5
        assert error[1] < 0.3 * error[0] + 1e-9  # central differences: second order


@pytest.mark.parametrize("where", ["force", "rate", "output", "load"])
def test_every_kink_has_a_guard_wherever_it_stands(where):
    x, u, z = sp.symbols("x u z", real=True)
    kink = {place: sp.Abs(x + z) if place == where else x for place in ("force", "rate", "output", "load")}
    system = sf.System([x], [u], [[1]], [-2 * x - kink["force"]], z=[z], z_rate=[kink["rate"] - z])
    contact = sf.Contact("floor", u, 3 + kink["load"] / 9, LAW)
    outputs = {"most": sf.Max(kink["output"])}
    scene = sf.Scene(system, [contact], {}, {x: 1.0, u: 0.0, z: 0.0}, 5.0, outputs)
    automaton = lower(scene, [kink["output"]])
    assert automaton.layout.switches == 1
    assert automaton.field.nnz_out(1) == automaton.layout.n_guards
