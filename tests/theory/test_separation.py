"""Slow scenes against the full motion and against means written out here."""

import numpy as np
import pytest
import sympy as sp
from scipy import integrate

import symfric as sf
from symfric.theory.equilibrium import equilibrium
from symfric.theory.separation import separate
from symfric.theory.stability import stability

t = sf.TIME
LAW = sf.laws.cubic(0.4, 0.25, 0.5)


def test_belt_becomes_the_slow_belt():
    scene = sf.scenes.mass_on_belt(v_b=0.2, a=0.01, Omega=50.0)
    slow = separate(scene)
    x, u = scene.system.states
    assert t not in slow.system.force[0].free_symbols
    numbers = slow.numbers()
    assert (numbers[x], numbers[u]) == pytest.approx((0.0, 0.5))
    law = slow.contacts[0].law.where(slow.values)
    for v in (0.1, 0.49, 0.51, 0.9):
        mean = (
            integrate.quad(lambda s, v=v: LAW(v - 0.5 * np.cos(s)), 0, np.pi, points=[np.arccos(min(v / 0.5, 1))])[0]
            / np.pi
        )
        assert law(v) == pytest.approx(mean, abs=1e-9)
    assert equilibrium(slow).x[0] == pytest.approx(0.06459190434756, rel=1e-12)
    assert stability(slow).stable
    # parameters stay: other excitations need no second separation
    assert equilibrium(slow.where({"a": 0.012})).x[0] == equilibrium(separate(scene.where({"a": 0.012}))).x[0]


def test_slow_motion_follows_the_full_one():
    """The distance halves when the frequency doubles at the same intensity."""
    distances = []
    for Omega in (50.0, 100.0):
        a = 0.5 / Omega
        slow = separate(sf.scenes.mass_on_belt(v_b=0.2, a=a, Omega=Omega))
        law = slow.contacts[0].law.where(slow.values)
        start = slow.numbers()
        z0 = [start[s] for s in slow.system.states]

        grid = np.linspace(-1.5, 1.5, 6001)
        friction = law(grid)

        def slow_rate(_s, z, grid=grid, friction=friction):
            return z[1], -z[0] - 0.1 * z[1] - np.interp(z[1] - 0.2, grid, friction)

        def full_rate(s, y, a=a, Omega=Omega):
            w = y[1] - 0.2
            mu = np.sign(w) * 0.4 - 0.45 * w + 0.6 * w**3
            return y[1], -y[0] - 0.1 * y[1] - mu + a * Omega**2 * np.sin(Omega * s)

        times = np.linspace(0, 6, 241)
        slow_run = integrate.solve_ivp(slow_rate, (0, 6), z0, t_eval=times, rtol=1e-8, atol=1e-10)
        full_run = integrate.solve_ivp(
            full_rate, (0, 6), [0.0, 0.0], t_eval=times, rtol=1e-7, atol=1e-9, max_step=0.3 / Omega
        )
        distances.append(np.max(np.abs(slow_run.y[0] - a * np.sin(Omega * times) - full_run.y[0])))
    assert distances[0] < 0.01
    assert distances[1] < 0.65 * distances[0]


def test_forces_in_several_coordinates_with_phases():
    q, u = sp.symbols("q0:2", real=True), sp.symbols("u0:2", real=True)
    F, Omega, phi = sp.symbols("F Omega phi", real=True)
    mass = sp.Matrix([[2, 1], [1, 3]])
    force = [-q[0] + F * sp.sin(Omega * t + phi), -q[1] - 2 * F * sp.cos(Omega * t) + F * sp.cos(phi - Omega * t)]
    contacts = [
        sf.Contact("a", slip=u[0] - u[1] - 1, normal=1, law=LAW),
        sf.Contact("b", slip=u[1] - 1, normal=1, law=sf.laws.stribeck(0.4, 0.2, 0.3)),
    ]
    values = {F: 7.0, Omega: 30.0, phi: 0.4}
    start = dict(zip((*q, *u), (0.1, 0.2, 0.3, 0.4), strict=True))
    scene = sf.Scene(
        system=sf.System(q=q, u=u, mass=mass, force=force), contacts=contacts, values=values, initial=start, horizon=1.0
    )
    slow = separate(scene)
    s = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    loads = np.array([7 * np.sin(s + 0.4), -14 * np.cos(s) + 7 * np.cos(0.4 - s)])
    accelerations = np.linalg.solve(np.array(mass, dtype=float), loads)
    phases = np.fft.rfft(accelerations, axis=1)[:, 1] / 2000
    velocities = np.real(phases[:, None] / (30j) * np.exp(1j * s))
    positions = np.real(phases[:, None] / (30j) ** 2 * np.exp(1j * s))
    numbers = slow.numbers()
    assert [numbers[v] for v in (*q, *u)] == pytest.approx(
        np.array([0.1, 0.2, 0.3, 0.4]) - np.concatenate([positions[:, 0], velocities[:, 0]]), rel=1e-10
    )
    swings = np.max(velocities[0] - velocities[1]), np.max(velocities[1])
    for contact, swing in zip(slow.contacts, swings, strict=True):
        edge = contact.law.breaks[0].subs(slow.values)
        assert float(edge) == pytest.approx(swing, rel=1e-6)
    assert slow.contacts[0].law.free_symbols  # polynomial: symbols stay
    assert not slow.contacts[1].law.free_symbols


def test_velocity_polynomials_are_averaged():
    x, u = sp.symbols("x u", real=True)
    F, Omega = sp.symbols("F Omega", positive=True)
    system = sf.System(q=[x], u=[u], mass=[[2]], force=[-x - u**3 + F * sp.cos(Omega * t)])
    scene = sf.Scene(system=system, values={F: 40.0, Omega: 20.0}, initial={x: 0.0, u: 0.0}, horizon=1.0)
    slow = separate(scene)
    amplitude = F / (2 * Omega)
    expected = -x - u**3 - sp.Rational(3, 2) * amplitude**2 * u
    assert sp.simplify(slow.system.force[0] - expected) == 0
    assert slow.numbers()[x] == pytest.approx(40 / (2 * 400))


def test_unshaken_contacts_keep_their_laws():
    q, u = sp.symbols("q0:2", real=True), sp.symbols("u0:2", real=True)
    force = [-q[0] + 100 * sp.sin(50 * t), -q[1] - (q[1] - q[0])]
    contacts = [sf.Contact(n, slip=u[i] - 1, normal=1, law=LAW) for i, n in enumerate("ab")]
    start = dict.fromkeys((*q, *u), 0.0)
    system = sf.System(q=q, u=u, mass=sp.eye(2), force=force)
    slow = separate(sf.Scene(system=system, contacts=contacts, initial=start, horizon=1.0))
    assert slow.contacts[1].law == LAW
    assert slow.contacts[0].law.breaks[0] == 2


def scene_with(force, mass=1, slip=None, normal=1):
    x, u = sp.symbols("x u", real=True)
    system = sf.System(q=[x], u=[u], mass=[[mass]], force=[force(x, u)])
    contact = sf.Contact("belt", slip=(slip or (lambda x, u: u - 1))(x, u), normal=normal, law=LAW)
    return sf.Scene(system=system, contacts=[contact], initial={x: 0.0, u: 0.0}, horizon=1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sf.scenes.mass_on_belt(v_b=0.2), "amplitude zero"),
        (lambda: sf.scenes.coulomb_oscillator(0.1), "no harmonic excitation"),
        (lambda: scene_with(lambda x, u: -x + sp.sin(50 * t) + sp.sin(60 * t)), "frequencies 50, 60"),
        (lambda: scene_with(lambda x, u: -x + x * sp.sin(50 * t)), "multiplied by a function of x"),
        (lambda: scene_with(lambda x, u: -x + sp.sin(50 * t) ** 2), "linear combination"),
        (lambda: scene_with(lambda x, u: -x + sp.sin(50 * t**2)), "not linear in time"),
        (lambda: scene_with(lambda x, u: -x + t * sp.sin(50 * t)), "linear combination"),
        (lambda: scene_with(lambda x, u: -x + t), "time only in sin and cos"),
        (lambda: scene_with(lambda x, u: -x - u * sp.Abs(u) + 9 * sp.sin(50 * t)), "no polynomial of u"),
        (lambda: scene_with(lambda x, u: -x + sp.sin(50 * t), mass=1 + sp.Symbol("x", real=True) ** 2), "mass matrix"),
        (lambda: scene_with(lambda x, u: -x + sp.sin(50 * t), slip=lambda x, u: u - sp.cos(t)), "slip of contact"),
        (lambda: scene_with(lambda x, u: -x + sp.sin(50 * t), slip=lambda x, u: u * (2 + x) - 1), "depends on the pos"),
        (lambda: scene_with(lambda x, u: -x + sp.sin(50 * t), normal=2 + sp.Symbol("u", real=True) ** 2), "normal of"),
    ],
)
def test_refusals(make, message):
    with pytest.raises(sf.SceneError, match=message):
        separate(make())
