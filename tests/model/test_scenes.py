"""Scenes, systems, signals and Lagrange's equations."""

import dataclasses
import pickle

import numpy as np
import pytest
import sympy as sp
from sympy.physics.mechanics import dynamicsymbols

import symfric as sf

X, U = sp.symbols("x u", real=True)


def simplified(system, force, mass):
    """Compare with equations derived by hand."""
    assert (system.mass - sp.Matrix(mass)).applyfunc(sp.simplify) == sp.zeros(*system.mass.shape)
    assert [sp.simplify(a - b) for a, b in zip(system.force, force, strict=True)] == [0] * len(force)


def test_lagrange_pendulum_with_damping_and_torque():
    m, l, g, c, M = sp.symbols("m l g c M", positive=True)
    phi, omega = sp.symbols("phi omega", real=True)
    system = sf.mechanics.lagrange(
        kinetic=m * l**2 * omega**2 / 2,
        potential=-m * g * l * sp.cos(phi),
        dissipation=c * omega**2 / 2,
        loads={phi: M * sp.sin(sf.TIME)},
        q=[phi],
        u=[omega],
    )
    assert system.states == (phi, omega)
    simplified(system, [-m * g * l * sp.sin(phi) - c * omega + M * sp.sin(sf.TIME)], [[m * l**2]])


def test_lagrange_two_masses():
    m1, m2, k, c = sp.symbols("m1 m2 k c", positive=True)
    q, u = sp.symbols("q1 q2", real=True), sp.symbols("u1 u2", real=True)
    stretch, rate = q[1] - q[0], u[1] - u[0]
    system = sf.mechanics.lagrange(
        kinetic=m1 * u[0] ** 2 / 2 + m2 * u[1] ** 2 / 2,
        potential=k * stretch**2 / 2,
        dissipation=c * rate**2 / 2,
        q=q,
        u=u,
    )
    pull = k * stretch + c * rate
    simplified(system, [pull, -pull], [[m1, 0], [0, m2]])


def test_lagrange_double_pendulum():
    m, l, g = sp.symbols("m l g", positive=True)
    a, b, ua, ub = sp.symbols("a b ua ub", real=True)
    kinetic = m * l**2 / 2 * (2 * ua**2 + ub**2 + 2 * ua * ub * sp.cos(a - b))
    system = sf.mechanics.lagrange(
        kinetic=kinetic, potential=-m * g * l * (2 * sp.cos(a) + sp.cos(b)), q=[a, b], u=[ua, ub]
    )
    mass = m * l**2 * sp.Matrix([[2, sp.cos(a - b)], [sp.cos(a - b), 1]])
    force = [
        -m * l**2 * ub**2 * sp.sin(a - b) - 2 * m * g * l * sp.sin(a),
        m * l**2 * ua**2 * sp.sin(a - b) - m * g * l * sp.sin(b),
    ]
    simplified(system, force, mass)


def test_lagrange_takes_functions_of_time():
    x, m, k = dynamicsymbols("x"), *sp.symbols("m k", positive=True)
    system = sf.mechanics.lagrange(kinetic=m * x.diff() ** 2 / 2, potential=k * x**2 / 2, q=[x])
    assert [s.name for s in system.states] == ["x", "x_dot"]
    simplified(system, [-k * sp.Symbol("x", real=True)], [[m]])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"u": None}, "give the velocities u"),
        ({"u": [U, X]}, "1 coordinates in q and 2 velocities"),
        ({"loads": {sp.Symbol("y"): 1}}, "a load acts on y, which is no coordinate"),
        ({"kinetic": "u**2"}, "kinetic is the string"),
    ],
)
def test_lagrange_refuses(changes, message):
    with pytest.raises(sf.SceneError, match=message):
        sf.mechanics.lagrange(**{"kinetic": U**2 / 2, "potential": X**2 / 2, "q": [X], "u": [U], **changes})


def test_lagrange_keeps_kinks_of_real_coordinates():
    system = sf.mechanics.lagrange(
        kinetic=U**2 / 2, potential=sp.Abs(X) ** 3 / 3, loads={X: -U * sp.Abs(U)}, q=[X], u=[U]
    )
    simplified(system, [-X * sp.Abs(X) - U * sp.Abs(U)], [[1]])


def test_signal_is_linear_between_its_samples_and_zero_outside():
    signal = sf.Signal([1, 3, -1], 0.5, t0=2.0, unit="m/s^2")
    assert signal.t_end == 3.0
    assert signal([1.999, 2.0, 2.25, 2.5, 2.75, 3.0, 3.001]).tolist() == [0, 1, 2, 3, 1, -1, 0]
    assert signal(2.25) == 2
    assert signal.samples.dtype == float
    with pytest.raises(ValueError, match="read-only"):
        signal.samples[0] = 7


def test_signal_keeps_its_own_copy():
    samples = np.array([1.0, 2.0])
    signal = sf.Signal(samples, 1)
    samples[0] = 9
    assert signal(0) == 1


def test_changes_return_new_scenes_and_leave_the_old_one():
    old = sf.scenes.mass_on_belt(v_b=0.2)
    before = (dict(old.values), dict(old.initial), old.horizon, dict(old.outputs), old.contacts)
    changed = {
        "where": old.where({"v_b": 0.3}),
        "starting": old.starting({"x": 1}),
        "until": old.until(7),
        "wanting": old.wanting({"end": sf.End()}),
        "regularised": old.regularised(1e-3),
    }
    assert (dict(old.values), dict(old.initial), old.horizon, dict(old.outputs), old.contacts) == before
    assert changed["where"].values[old.parameter("v_b")] == 0.3
    assert changed["starting"].initial == {X: 1.0, U: 0.0}
    assert changed["until"].horizon == 7
    assert changed["wanting"].outputs == {"end": sf.End()}
    assert changed["regularised"].contacts[0].law.smooth
    for name, scene in changed.items():
        assert scene is not old
        same = {
            "where": "values",
            "starting": "initial",
            "until": "horizon",
            "wanting": "outputs",
            "regularised": "contacts",
        }
        for other in set(same.values()) - {same[name]}:
            assert getattr(scene, other) == getattr(old, other)


def test_scenes_are_frozen():
    scene = sf.scenes.mass_on_belt(v_b=0.2)
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.horizon = 3
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.system.force = (X,)


def test_mass_on_belt_is_thomsen_1():
    scene = sf.scenes.mass_on_belt(v_b=0.2, a=0.01, Omega=3.0)
    v_b, beta, gamma2, a, Omega = (scene.parameter(n) for n in ("v_b", "beta", "gamma2", "a", "Omega"))
    (force,), (contact,) = scene.system.force, scene.contacts
    assert sp.simplify(force - (-2 * beta * U - X + a * Omega**2 * sp.sin(Omega * sf.TIME))) == 0
    assert contact.slip == U - v_b
    assert contact.normal == gamma2
    assert scene.system.mass == sp.Matrix([[1]])
    assert {s.name: n for s, n in scene.values.items()} == {
        "v_b": 0.2,
        "beta": 0.05,
        "gamma2": 1,
        "a": 0.01,
        "Omega": 3,
    }
    assert scene.initial == {X: 0.0, U: 0.0}


def test_laws_with_symbols_open_their_values():
    mu_s, mu_m, v_m = sp.symbols("mu_s mu_m v_m", positive=True)
    scene = sf.scenes.mass_on_belt(sf.laws.cubic(mu_s, mu_m, v_m), v_b=0.2)
    assert [s.name for s, n in scene.values.items() if n is None] == ["mu_m", "mu_s", "v_m"]
    full = scene.where({"mu_s": 0.4, "mu_m": 0.25, "v_m": 0.5})
    plain = sf.scenes.mass_on_belt(v_b=0.2)
    assert sf.simulate(full, 1e-11).final == pytest.approx(sf.simulate(plain, 1e-11).final, abs=1e-9)


def test_coulomb_oscillator_is_that_of_the_handbook():
    scene = sf.scenes.coulomb_oscillator(0.03, delta_s=0.05, x0=0.8, omega_n=2.0)
    numbers = {s.name: n for s, n in scene.numbers().items()}
    assert numbers == {"delta": 0.03, "delta_s": 0.05, "omega_n": 2, "x0": 0.8, "x": 0.8, "u": 0}
    assert scene.horizon > np.pi / 2 * np.ceil((0.8 - 0.05) / 0.06)
    run = sf.simulate(scene, 1e-11)  # N = ceil(12.5) = 13
    assert run.outputs["stop_time"] == pytest.approx(13 * np.pi / 2, rel=1e-9)
    assert run.final[0] == pytest.approx(-(0.8 - 26 * 0.03), abs=1e-10)


def test_equations_read_like_the_source():
    (kinematic, dynamic) = sf.scenes.mass_on_belt(sf.laws.coulomb(0.3), v_b=0.2).equations()
    x, u = sp.Function("x", real=True)(sf.TIME), sp.Function("u", real=True)(sf.TIME)
    assert kinematic == sp.Eq(x.diff(sf.TIME), u)
    assert dynamic.lhs == u.diff(sf.TIME)
    numbers = {"v_b": 0.2, "beta": 0.05, "gamma2": 2.0, "a": 0.0, "Omega": 1.0}
    right = dynamic.rhs.subs({x: 0.5, u: 0.1}).subs({s: numbers[s.name] for s in dynamic.rhs.free_symbols - {sf.TIME}})
    assert float(right) == pytest.approx(-0.5 - 0.01 + 2 * 0.3)
    assert "sign" in str(dynamic)


def test_equations_print_as_latex():
    latex = sf.scenes.mass_on_belt(v_b=0.2)._repr_latex_()
    assert latex.startswith("$")
    assert "gamma_{2}" in latex or "gamma_2" in latex or "gamma" in latex


def test_repr_is_one_short_line():
    text = repr(sf.scenes.mass_on_belt(v_b=0.2))
    assert "\n" not in text
    assert len(text) < 160
    assert "v_b=0.2" in text
    assert "belt" in text


def test_scenes_pickle_with_their_motion():
    signal, ground = sf.Signal(np.sin(np.arange(50)), 0.1), sp.Symbol("ground", real=True)
    shaken = sf.Scene(
        system=sf.System(q=[X], u=[U], mass=[[1]], force=[-X - ground]),
        contacts=[sf.Contact("floor", U, 1, sf.laws.stribeck(0.3, 0.2, 0.1))],
        initial={X: 1.0, U: 0.0},
        inputs={ground: signal},
        horizon=6.0,
    )
    for scene in (sf.scenes.mass_on_belt(v_b=0.2), sf.scenes.coulomb_oscillator(0.03), shaken):
        again = pickle.loads(pickle.dumps(scene))
        assert again.values == scene.values
        assert again.initial == scene.initial
        assert sf.simulate(again, 1e-9).final.tolist() == sf.simulate(scene, 1e-9).final.tolist()


def test_names_are_keys_wherever_symbols_are():
    body = sf.System(q=[X], u=[U], mass=[[1]], force=[-sp.Symbol("k") * X])
    by_name = sf.Scene(system=body, values={"k": 2.0}, initial={"x": 1.0, "u": 0}, horizon=1)
    by_symbol = sf.Scene(system=body, values={sp.Symbol("k"): 2.0}, initial={X: 1.0, U: 0}, horizon=1)
    assert by_name.values == by_symbol.values
    assert by_name.initial == by_symbol.initial


def test_a_scene_keeps_symbols_floats_and_tuples_whatever_it_is_given():
    body = sf.System(q=[X], u=[U], mass=[[1]], force=[-sp.Symbol("k") * X])
    belt = sf.Contact("belt", slip=U, normal=1, law=sf.laws.coulomb(0.1))
    scene = sf.Scene(body, [belt], {"k": 2}, {"x": 1, U: sp.Rational(1, 2)}, 1, {"end": sf.End()})
    assert scene.contacts == (belt,)
    assert scene.values == scene.parameter_values() == {sp.Symbol("k"): 2.0}
    assert scene.initial == {X: 1.0, U: 0.5}
    assert scene.outputs == {"end": sf.End()}
    assert all(type(v) is float for v in (*scene.values.values(), *scene.initial.values(), scene.horizon))


def test_default_output_is_the_trajectory():
    body = sf.System(q=[X], u=[U], mass=[[1]], force=[-X])
    assert sf.Scene(system=body, initial={X: 1, U: 0}, horizon=1).outputs == {"path": sf.Trajectory()}


def test_lagrange_refuses_a_bare_sign():
    with pytest.raises(sf.SceneError, match="jumps"):
        sf.mechanics.lagrange(kinetic=U**2 / 2, loads={X: -sp.sign(U)}, q=[X], u=[U])


def test_energies_with_kinks_can_be_run():
    system = sf.mechanics.lagrange(kinetic=U**2 / 2, potential=sp.Abs(X) ** 3 / 3, q=[X], u=[U])
    run = sf.simulate(sf.Scene(system=system, initial={X: 1.0, U: 0.0}, horizon=5.0), 1e-10)
    assert run.final[1] ** 2 / 2 + abs(run.final[0]) ** 3 / 3 == pytest.approx(1 / 3, abs=1e-8)
