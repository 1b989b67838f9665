"""Lagrange's equations from energies with kinks: right, without signs and Eq, and refused where the force jumps."""

import numpy as np
import pytest
import sympy as sp
from sympy.physics.mechanics import dynamicsymbols

import symfric as sf

X, U, Y, W = sp.symbols("x u y w", real=True)
K, G, C = sp.symbols("k g c", positive=True)
NUMBERS = {K: 1.7, G: 0.4, C: 0.6}
HALF = sp.Rational(1, 2)
POTENTIALS = {
    "cubic": K * sp.Abs(X) ** 3 / 3,
    "power": K * sp.Abs(X) ** (5 * HALF),
    "low power": K * sp.Abs(X) ** (3 * HALF),
    "odd": K * X * sp.Abs(X),
    "exponential": K * (1 + sp.Abs(X)) * sp.exp(-sp.Abs(X)),
    "exponential, expanded": K * sp.exp(-sp.Abs(X)) + K * sp.Abs(X) * sp.exp(-sp.Abs(X)),
    "stop": K * sp.Max(0, X - G) ** 2 / 2,
    "two stops": K * sp.Max(0, X - G) ** 2 / 2 + K * sp.Min(0, X + G) ** 2 / 2,
    "two stops at once": K * sp.Max(0, sp.Abs(X) - G) ** 2 / 2,
    "three": K * sp.Max(0, X - G, -2 * X - 3 * G) ** 2 / 2 + C * sp.Max(0, X - 2 * G) ** 3,
    "two springs": sp.Piecewise((K * X**2 / 2, X < 0), (C * X**2 / 2, True)),
    "stop as a Piecewise": K * sp.Piecewise((0, X < G), (X - G, True)) ** 2 / 2 + C * X**2,
    "of an angle": K * sp.Abs(sp.sin(X)) ** 3 - C * sp.cos(X),
    "hertz": K * sp.Max(0, X) ** (5 * HALF),
    "of a parameter": sp.Abs(K - 2) * X**2 / 2 + sp.Max(K, C) * X,
}


def oscillator(**energies):
    return sf.mechanics.lagrange(**{"kinetic": U**2 / 2, "q": [X], "u": [U], **energies})


def clean(system):
    assert not any(e.has(sp.sign, sp.Heaviside, sp.Derivative, sp.Eq, sp.re, sp.im) for e in system.expressions)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", POTENTIALS)
def test_force_is_minus_the_slope_of_the_potential(name):
    system = oscillator(potential=POTENTIALS[name])
    clean(system)
    energy = sp.lambdify(X, POTENTIALS[name].subs(NUMBERS), "numpy")
    force = sp.lambdify(X, system.force[0].subs(NUMBERS), "numpy")
    with np.errstate(invalid="ignore"):  # of the branch that is not taken
        for x in np.linspace(-1.83, 1.9, 30):
            slope = (energy(x + 1e-6) - energy(x - 1e-6)) / 2e-6
            assert float(force(x)) == pytest.approx(-slope, abs=1e-7)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", [n for n in POTENTIALS if n not in ("odd", "of a parameter")])
def test_energies_with_kinks_keep_their_sum(name):
    values = {s: n for s, n in NUMBERS.items() if s in POTENTIALS[name].free_symbols}
    scene = sf.Scene(
        system=oscillator(potential=POTENTIALS[name] + X**2 / 2), values=values, initial={X: 1.0, U: 0.3}, horizon=9.0
    )
    run = sf.simulate(scene, 1e-10).checked()
    x, u = sp.lambdify(X, (POTENTIALS[name] + X**2 / 2).subs(NUMBERS), "numpy"), run.final[1]
    assert u**2 / 2 + x(run.final[0]) == pytest.approx(0.045 + x(1.0), abs=1e-7)


def test_forces_read_like_the_energies():
    assert oscillator(potential=K * sp.Abs(X) ** 3 / 3).force == (-K * X * sp.Abs(X),)
    assert oscillator(potential=K * sp.Max(0, X - G) ** 2 / 2).force == (-K * sp.Max(0, X - G),)
    assert oscillator(dissipation=C * sp.Abs(U) ** 3 / 3).force == (-C * U * sp.Abs(U),)
    assert oscillator(dissipation=C * sp.Max(0, U) ** 2 / 2).force == (-C * sp.Max(0, U),)


def test_drag_slows_down_as_it_should():
    scene = sf.Scene(
        system=oscillator(dissipation=C * sp.Abs(U) ** 3 / 3), values={C: 0.6}, initial={X: 0.0, U: 2.0}, horizon=5.0
    )
    assert sf.simulate(scene, 1e-12).final == pytest.approx([np.log(7) / 0.6, 2 / 7], abs=1e-10)  # u = u0/(1 + c u0 t)


def test_kinks_between_coordinates():
    system = sf.mechanics.lagrange(
        kinetic=U**2 / 2 + W**2 / 2,
        potential=K * sp.Abs(X - Y) ** 3,
        dissipation=C * sp.Abs(U - W) ** 3,
        q=[X, Y],
        u=[U, W],
    )
    clean(system)
    pull = 3 * K * (X - Y) * sp.Abs(X - Y) + 3 * C * (U - W) * sp.Abs(U - W)
    assert [sp.expand(a + b) for a, b in zip(system.force, (pull, -pull), strict=True)] == [0, 0]


def test_kinks_in_the_inertia():
    system = oscillator(kinetic=(1 + sp.Abs(X) ** 3) * U**2 / 2 + sp.Max(0, X) ** 2 * U**2)
    clean(system)
    for x in (-1.2, 1.7):
        mass, force = (float(e.subs({X: x, U: 1})) for e in (system.mass[0], system.force[0]))
        assert mass == pytest.approx(1 + abs(x) ** 3 + 2 * max(0, x) ** 2)
        assert force == pytest.approx(-3 * x * abs(x) / 2 - 2 * max(0, x))


def test_kinks_of_symbols_that_are_not_declared_real():
    x, u = sp.Symbol("x"), sp.Symbol("u")
    system = sf.mechanics.lagrange(
        kinetic=u**2 / 2, potential=sp.Abs(x) ** 3 / 3, dissipation=C * sp.Abs(u) ** 3 / 3, q=[x], u=[u]
    )
    clean(system)
    assert system.states == (x, u)
    assert system.force == (-C * u * sp.Abs(u) - x * sp.Abs(x),)


def test_kinks_of_functions_of_time():
    x = dynamicsymbols("x")
    system = sf.mechanics.lagrange(
        kinetic=x.diff() ** 2 / 2, potential=sp.Abs(x) ** 3 / 3, loads={x: -C * x.diff() * sp.Abs(x.diff())}, q=[x]
    )
    u = sp.Symbol("x_dot", real=True)
    assert system.force == (-C * u * sp.Abs(u) - X * sp.Abs(X),)


@pytest.mark.parametrize(
    ("energies", "message"),
    [
        ({"dissipation": C * sp.Abs(U)}, "d dissipation/d u jumps where u = 0; dry friction enters as a Contact"),
        ({"dissipation": C * sp.Max(0, U)}, "jumps where u = 0; dry friction enters as a Contact"),
        ({"dissipation": C * sp.Max(U, -2 * U)}, "jumps where u = 0; dry friction enters as a Contact"),
        ({"potential": K * sp.Abs(X)}, "d potential/d x jumps where x = 0; smooth the kink"),
        ({"potential": K * sp.sqrt(sp.Abs(X))}, "jumps where x = 0"),
        ({"potential": sp.exp(-sp.Abs(X))}, "jumps where x = 0"),
        ({"potential": sp.Abs(sp.sin(X))}, r"jumps where sin\(x\) = 0"),
        ({"potential": sp.Max(1, X) ** 2}, "jumps where x - 1 = 0"),
        ({"potential": sp.Max(0, X - G, 2 * X - 3 * G) ** 2}, "d potential/d x jumps by"),
        ({"potential": sp.Piecewise((X, X < 0), (3 * X, True))}, "d potential/d x jumps by .* at x = 0"),
        ({"potential": sp.Piecewise((0, X < 0), (1, True))}, "potential jumps by 1 at x = 0"),
        ({"kinetic": (1 + sp.Abs(X)) * U**2}, "the force from the kinetic energy jumps where x = 0; smooth the kink"),
        ({"potential": sp.floor(X)}, r"potential contains floor\(x\), which jumps"),
        ({"dissipation": U * sp.sign(U)}, "dissipation contains sign"),
        ({"loads": {X: -sp.sign(U)}}, r"the load on x contains sign\(u\), which jumps; dry friction enters as"),
        ({"loads": {X: -sp.Heaviside(X)}}, r"the load on x contains Heaviside\(x\), which jumps"),
        ({"loads": {X: -C * U / sp.Abs(U)}}, "u/Abs.u., which jumps"),
        ({"loads": {X: -C * sp.Abs(U) / U}}, "Abs.u./u, which jumps"),
        ({"loads": {X: "x"}}, "the load on x is the string 'x'"),
    ],
)
def test_jumps_are_refused(energies, message):
    with pytest.raises(sf.SceneError, match=message):
        oscillator(**energies)


def test_accelerations_and_doubles_are_refused():
    x = dynamicsymbols("x")
    with pytest.raises(sf.SceneError, match="potential contains Derivative"):
        sf.mechanics.lagrange(kinetic=x.diff() ** 2, potential=x * x.diff(sf.TIME, 2), q=[x])
    with pytest.raises(sf.SceneError, match="potential uses x as two different symbols"):
        sf.mechanics.lagrange(kinetic=U**2, potential=X * sp.Symbol("x"), q=[sp.Symbol("x")], u=[U])


@pytest.mark.parametrize(
    "sign", [U / sp.Abs(U), sp.Symbol("z") / sp.sqrt(sp.Symbol("z") ** 2), (X - Y) / sp.Abs(X - Y)]
)
def test_a_sign_written_as_a_quotient_is_no_force(sign):
    with pytest.raises(sf.SceneError, match="which jumps; dry friction enters as a Contact"):
        sf.System(q=[X, Y], u=[U, W], z=[sp.Symbol("z")], z_rate=[0], mass=sp.eye(2), force=[-K * sign, 0])
    sf.System(
        q=[X, Y], u=[U, W], mass=sp.eye(2), force=[-X / sp.Abs(X - Y) ** 3, U * sp.Abs(U) - U / sp.sqrt(U**2 + 1)]
    )
