"""Several contacts at once, loads that vary, kinks, first-order states and sampled inputs: the next mode and its motion."""

import itertools

import numpy as np
import pytest
import sympy as sp
from scipy import integrate, optimize

import symfric as sf
from tests.longer import longer

CUBIC = sf.laws.cubic(0.4, 0.25, 0.5)
X, U, Y, W = sp.symbols("x u y w", real=True)


def one_mass(force, contacts=(), *, x=0.0, u=0.0, horizon=30.0, **more):
    """One mass of 1 with the states x and u; `more` goes to the scene."""
    initial = {X: x, U: u, **more.pop("initial", {})}
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[force], **more.pop("first_order", {}))
    return sf.Scene(system=system, contacts=contacts, initial=initial, horizon=horizon, **more)


def chain(n, loads, speed=0.2, law=CUBIC, horizon=20.0):
    """Masses on one belt, each held by a spring and tied to its neighbours."""
    q, u = sp.symbols(f"q:{n}", real=True), sp.symbols(f"u:{n}", real=True)
    force = [-q[i] / 2 - sp.Rational(1, 20) * u[i] for i in range(n)]
    for i in range(n - 1):
        force[i] += q[i + 1] - q[i]
        force[i + 1] += q[i] - q[i + 1]
    contacts = [sf.Contact(f"c{i}", slip=u[i] - speed, normal=loads[i], law=law) for i in range(n)]
    system = sf.System(q=q, u=u, mass=sp.eye(n), force=force)
    return sf.Scene(system=system, contacts=contacts, initial=dict.fromkeys([*q, *u], 0.0), horizon=horizon)


def stack(law=None, horizon=20.0, drive=1.5, loads=(3.0, 2.0, 1.0)):
    """Three blocks on each other, the lowest on the ground and shaken by a force."""
    law = sf.laws.stribeck(0.3, 0.2, 0.5) if law is None else law
    q, u = sp.symbols("q1:4", real=True), sp.symbols("u1:4", real=True)
    force = [-2 * q[0] + drive * sp.sin(sf.TIME), 0, -q[2] / 10]
    slips = [u[0], u[1] - u[0], u[2] - u[1]]
    contacts = [sf.Contact(f"face{i}", slip=slips[i], normal=loads[i], law=law) for i in range(3)]
    system = sf.System(q=q, u=u, mass=sp.eye(3), force=force)
    return sf.Scene(system=system, contacts=contacts, initial=dict.fromkeys([*q, *u], 0.0), horizon=horizon)


def two_belts(v1=0.3, v2=-0.15, horizon=30.0):
    """One block between two belts that run in opposite directions."""
    contacts = [
        sf.Contact("lower", slip=U - v1, normal=1.2, law=CUBIC),
        sf.Contact("upper", slip=U - v2, normal=0.7, law=sf.laws.coulomb(0.3, 0.2)),
    ]
    return one_mass(-X - U / 10 + sp.cos(1.3 * sf.TIME), contacts, x=0.5, horizon=horizon)


def carried(horizon=12.0):
    """Two blocks with coupled mass matrix, rubbing on each other and on ground and belt: slips of several velocities."""
    contacts = [
        sf.Contact("ground", slip=U, normal=1, law=sf.laws.coulomb(0.25, 0.2)),
        sf.Contact("between", slip=W - U, normal=0.8, law=sf.laws.stribeck(0.3, 0.1, 0.4)),
        sf.Contact("belt", slip=W + U / 2 - 0.3, normal=0.5, law=CUBIC),
    ]
    system = sf.System(
        q=[X, Y], u=[U, W], mass=[[2, 0.3], [0.3, 1]], force=[-3 * X + 0.7 * sp.cos(sf.TIME), -Y - (Y - X) / 2]
    )
    return sf.Scene(system=system, contacts=contacts, initial={X: 0.5, Y: 0.0, U: 0.0, W: 0.0}, horizon=horizon)


SCENES = {
    "chain of six": chain(6, [1 + 0.07 * i for i in range(6)]),
    "chain of six, equal": chain(6, [1] * 6),
    "stack of three": stack(),
    "stack of three, coulomb": stack(sf.laws.coulomb(0.3), drive=2.5),
    "two belts": two_belts(),
    "carried": carried(),
}


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", longer(SCENES, ("chain of six, equal",)))
def test_several_contacts_agree_with_a_finer_tolerance_and_conserve_energy(name):
    coarse, fine = (sf.simulate(SCENES[name], tolerance).checked() for tolerance in (1e-8, 1e-13))
    assert np.max(np.abs(coarse.final - fine.final)) < 1e-7
    assert len(coarse.events) == len(fine.events) > 3
    assert {e.contact for e in fine.events} == {c.name for c in SCENES[name].contacts}
    assert coarse.energy_residual() < 1e-6
    assert fine.energy_residual() < 1e-11


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["stack of three", "two belts", "carried"])
def test_several_contacts_agree_with_an_independent_rule_and_integrator(name):
    scene = SCENES[name]
    exact, other = sf.simulate(scene, 1e-12).checked(), sf.simulate(scene, 1e-8, route="integrators").checked()
    assert np.max(np.abs(exact.final - other.final)) < 1e-6
    modes = lambda run: sorted((e.contact, e.before, e.after) for e in run.events)  # noqa: E731
    assert modes(exact) == modes(other)


def moreau(scene, dt):
    """Time stepping of the inclusion with a projected Gauss-Seidel sweep, free of modes; Coulomb laws only."""
    system = scene.system
    n = len(system.q)
    states = (*system.q, *system.u)
    force = sp.lambdify((*states, sf.TIME), list(system.force), "numpy")
    J = np.array(sp.Matrix([c.slip for c in scene.contacts]).jacobian(sp.Matrix(system.u)), dtype=float)
    belt = np.array([float(c.slip.subs(dict.fromkeys(states, 0))) for c in scene.contacts])
    bound = np.array([float(c.normal * c.law.stick) for c in scene.contacts]) * dt
    inverse = np.linalg.inv(np.array(system.mass, dtype=float))
    A = J @ inverse @ J.T
    q, u = np.zeros(n), np.zeros(n)
    pull = np.zeros(len(bound))
    for k in range(round(scene.horizon / dt)):
        middle = q + 0.5 * dt * u
        free = J @ (u + dt * inverse @ np.array(force(*middle, *u, (k + 0.5) * dt))) + belt
        for _ in range(400):
            before = pull.copy()
            for i in range(len(bound)):
                w = free[i] + A[i] @ pull
                pull[i] = np.clip(pull[i] - w / A[i, i], -bound[i], bound[i])
            if np.max(np.abs(pull - before)) < 1e-13:
                break
        u = u + inverse @ (dt * np.array(force(*middle, *u, (k + 0.5) * dt)) + J.T @ pull)
        q = middle + 0.5 * dt * u
    return np.concatenate([q, u])


def test_stack_agrees_with_a_time_stepping_scheme_that_knows_no_modes():
    scene = stack(sf.laws.coulomb(0.3), drive=2.5, horizon=8.0)
    exact = sf.simulate(scene, 1e-12).final
    errors = [np.max(np.abs(moreau(scene, dt) - exact)) for dt in (0.02, 0.005)]
    assert errors[1] < 0.01
    assert errors[1] < 0.5 * errors[0]


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "laws", [(sf.laws.coulomb(0.2), sf.laws.coulomb(0.3)), (CUBIC, CUBIC)], ids=["coulomb", "cubic"]
)
def test_redundant_contacts_move_like_one_with_the_summed_law(laws):
    first, second = laws
    slip = U - 0.2
    force = -X - U / 10 + 2 * sp.sin(1.3 * sf.TIME)
    both = one_mass(force, [sf.Contact("a", slip, 1, first), sf.Contact("b", slip, 2, second)])
    total = sf.laws.custom(first.kinetic + 2 * second.kinetic, first.stick + 2 * second.stick)
    single = one_mass(force, [sf.Contact("sum", slip, 1, total)])
    two, one = sf.simulate(both, 1e-11).checked(), sf.simulate(single, 1e-11).checked()
    t = np.linspace(0, both.horizon, 301)
    assert len(one.events) > 4
    assert np.max(np.abs(two(t) - one(t))) < 1e-9


def test_a_chain_of_equal_masses_moves_as_one():
    run = sf.simulate(chain(4, [1] * 4), 1e-11).checked()
    single = one_mass(-X / 2 - U / 20, [sf.Contact("belt", U - 0.2, 1, CUBIC)], horizon=20.0)
    expected = sf.simulate(single, 1e-11).checked().final
    assert run.final == pytest.approx(np.repeat(expected, 4), abs=1e-9)


def crossing(run, event):
    """Return the state right at an event."""
    return run(np.array(event.t))


def test_a_load_that_depends_on_the_state_agrees_with_the_other_route():
    scene = one_mass(-X - U / 10, [sf.Contact("belt", U - 0.2, 1 + 0.3 * X, CUBIC)])
    exact, other = sf.simulate(scene, 1e-12).checked(), sf.simulate(scene, 1e-9, route="integrators").checked()
    assert np.max(np.abs(exact.final - other.final)) < 1e-7
    assert len(exact.events) == len(other.events) > 5
    assert exact.energy_residual() < 1e-10
    without = sf.simulate(one_mass(-X - U / 10, [sf.Contact("belt", U - 0.2, 1, CUBIC)]), 1e-12).final
    assert np.max(np.abs(exact.final - without)) > 1e-3  # the load matters


@pytest.mark.parametrize("tolerance", [1e-4, 1e-9, 1e-13])
def test_a_lost_contact_ends_the_run_where_the_load_vanishes(tolerance):
    # frictionless until the load is gone: x = 2 cos t, N = 1 + x vanishes at cos t = -1/2
    scene = one_mass(-X, [sf.Contact("floor", U, 1 + X, sf.laws.coulomb(0))], x=2.0)
    run = sf.simulate(scene, tolerance)
    assert run.status == sf.Status.LOST_CONTACT
    assert "Max(load, 0)" in run.advice
    assert run.t_final == pytest.approx(2 * np.pi / 3, abs=10 * tolerance)
    with pytest.raises(sf.RunFailed, match=r"LOST_CONTACT at t = 2\.09"):
        run.checked()


def test_a_load_that_touches_zero_is_not_lost():
    scene = one_mass(-X, [sf.Contact("floor", U, (X + 1) ** 2, sf.laws.coulomb(0))], x=2.0, horizon=5.0)
    run = sf.simulate(scene, 1e-10).checked()
    assert run.final == pytest.approx([2 * np.cos(5), -2 * np.sin(5)], abs=1e-8)


def test_a_load_with_a_floor_of_zero_lets_the_bodies_part():
    load = sp.Max(0, sp.Rational(1, 2) + X)
    scene = one_mass(-X, [sf.Contact("floor", U, load, sf.laws.coulomb(0.1))], x=2.0, horizon=3.0)
    run = sf.simulate(scene, 1e-12).checked()

    def rate(_t, y):
        return y[1], -y[0] - 0.1 * max(0, 0.5 + y[0]) * np.sign(y[1])

    touch = lambda _t, y: y[0] + 0.5  # noqa: E731
    touch.terminal = True
    first = integrate.solve_ivp(rate, (0, 3), [2.0, -1e-300], method="DOP853", rtol=1e-12, atol=1e-13, events=touch)
    rest = integrate.solve_ivp(
        lambda _t, y: (y[1], -y[0]), (first.t[-1], 3), first.y[:, -1], method="DOP853", rtol=1e-12, atol=1e-13
    )
    assert run.final == pytest.approx(rest.y[:, -1], abs=1e-9)


def test_a_kink_of_a_force_at_the_slip_itself():
    # quadratic drag on the ground: both change at u = 0; energy over one swing has a closed form
    mu, c = 0.05, 0.3
    scene = one_mass(-X - c * sp.Abs(U) * U, [sf.Contact("floor", U, 1, sf.laws.coulomb(mu))], x=1.0, horizon=20.0)
    run = sf.simulate(scene, 1e-12).checked()
    turns = [crossing(run, e)[0] for e in run.events]
    amplitude = 1.0
    for found in turns[:4]:
        # v = u^2 obeys dv/dx = -2 x +- 2 mu +- 2 c v: linear, solved from turning point to turning point
        energy = lambda x, a=amplitude: _swing(x, a, mu, c)  # noqa: E731
        nxt = optimize.brentq(energy, mu + 1e-12, amplitude - 1e-9)
        assert abs(found) == pytest.approx(nxt, abs=1e-10)
        amplitude = nxt


def _swing(b, a, mu, c):
    """u^2 at the displacement -b of a swing from rest at a, with friction mu and drag c u^2."""
    # moving left with s = a - x: dv/ds = 2 (a - s) - 2 mu - 2 c v
    s = a + b
    k = 2 * c
    return ((2 * a - 2 * mu) * (1 - np.exp(-k * s)) / k) - 2 * (s / k - (1 - np.exp(-k * s)) / k**2)


def test_a_stop_that_is_touched_while_sticking_and_slipping():
    force = -X - U / 10 - 5 * sp.Max(0, X - sp.Rational(35, 100)) + sp.Piecewise((-X, X < 0), (0, True)) / 2
    scene = one_mass(force, [sf.Contact("belt", U - 0.2, 1, CUBIC)])
    exact, other = sf.simulate(scene, 1e-12).checked(), sf.simulate(scene, 1e-9, route="integrators").checked()
    assert exact.stats["kinks"] >= 4
    assert np.max(np.abs(exact.final - other.final)) < 1e-6
    assert exact.energy_residual() < 1e-10


def test_friction_that_grows_with_position_shortens_the_swings_by_the_closed_form():
    mu, slope = 0.05, 2.0
    contact = sf.Contact("floor", U, 1, sf.laws.coulomb(mu), profile=1 + slope * sp.Abs(X))
    run = sf.simulate(one_mass(-X, [contact], x=1.0, horizon=40.0), 1e-12).checked()
    amplitude = 1.0
    for event in run.events[:-1]:  # (1 - mu s) A^2 / 2 - mu A = (1 + mu s) B^2 / 2 + mu B
        lost = (1 - mu * slope) * amplitude**2 / 2 - mu * amplitude
        amplitude = (-mu + np.sqrt(mu**2 + 2 * (1 + mu * slope) * lost)) / (1 + mu * slope)
        assert abs(crossing(run, event)[0]) == pytest.approx(amplitude, abs=1e-10)
    assert run.events[-1].after == 0
    assert len(run.events) > 4


def test_cells_of_different_friction():
    profile = sp.Piecewise((1, X < 0), (1 + 4 * X, X < sp.Rational(1, 4)), (2, True))
    contact = sf.Contact("floor", U, 1, sf.laws.coulomb(0.05), profile=profile)
    run = sf.simulate(one_mass(-X, [contact], x=1.0, horizon=10.0), 1e-12).checked()
    # first swing to the left: 1/2 - B^2/2 = mu (2 * .75 + int_0^.25 (1 + 4x) dx + B)
    work = 0.05 * (1.5 + 0.25 + 2 * 0.25**2)
    turn = -0.05 + np.sqrt(0.05**2 + 1 - 2 * work)
    assert crossing(run, run.events[0])[0] == pytest.approx(-turn, abs=1e-11)


def reference(rate, y0, horizon):
    """A smooth problem by SciPy's DOP853."""
    found = integrate.solve_ivp(rate, (0, horizon), y0, method="DOP853", rtol=1e-12, atol=1e-14)
    return found.y[:, -1]


def test_lugre_friction_agrees_with_scipy():
    # Canudas de Wit et al. (1995): z' = w - sigma0 |w| z / g(w), F = sigma0 z + sigma1 z' + sigma2 w
    z, s0, s1, s2 = sp.Symbol("z", real=True), 100.0, 2.0, 0.02
    slip = U - 0.1
    g = 0.25 + 0.15 * sp.exp(-((slip / 0.05) ** 2))
    z_rate = slip - s0 * sp.Abs(slip) * z / g
    force = -X - (s0 * z + s1 * z_rate + s2 * slip)
    scene = one_mass(force, horizon=15.0, first_order={"z": [z], "z_rate": [z_rate]}, initial={z: 0.0})
    run = sf.simulate(scene, 1e-11).checked()

    def rate(_t, y):
        w = y[1] - 0.1
        zr = w - s0 * abs(w) * y[2] / (0.25 + 0.15 * np.exp(-((w / 0.05) ** 2)))
        return y[1], -y[0] - (s0 * y[2] + s1 * zr + s2 * w), zr

    assert run.final == pytest.approx(reference(rate, [0.0, 0.0, 0.0], 15.0), abs=1e-8)
    assert run.stats["kinks"] > 2
    assert run.energy_residual() < 1e-8


def test_an_integral_controller_beside_a_contact_that_sticks_again_and_again():
    # the hunting of an integral controller against static friction
    z, ref = sp.Symbol("z", real=True), sp.Symbol("ref", real=True)
    scene = one_mass(
        4 * (ref - X) + 2 * z - 1.5 * U,
        [sf.Contact("guide", U, 1, sf.laws.stribeck(0.5, 0.3, 0.05))],
        horizon=150.0,
        first_order={"z": [z], "z_rate": [ref - X]},
        initial={z: 0.0},
        values={ref: 1.0},
    )
    fine, other = sf.simulate(scene, 1e-12).checked(), sf.simulate(scene, 1e-9, route="integrators").checked()
    assert sum(e.after == 0 for e in fine.events) > 4
    assert [(e.before, e.after) for e in fine.events] == [(e.before, e.after) for e in other.events]
    assert np.max(np.abs(fine.final - other.final)) < 1e-6


def test_sampled_input_without_friction_agrees_with_scipy_piece_by_piece():
    samples = np.random.default_rng(5).normal(size=60)
    signal, ground = sf.Signal(samples, 0.13, t0=0.4), sp.Symbol("ground", real=True)
    scene = one_mass(-4 * X - U / 5 - X**3 - ground, horizon=12.0, inputs={ground: signal})
    run = sf.simulate(scene, 1e-12).checked()
    edges = np.concatenate([[0.0, 0.4 - 1e-13], 0.4 + 0.13 * np.arange(60), [signal.t_end + 1e-13, 12.0]])
    y = np.array([0.0, 0.0])
    for a, b in itertools.pairwise(edges):
        va, vb = float(signal(a + 1e-14)), float(signal(b - 1e-14))
        line = lambda t, a=a, b=b, va=va, vb=vb: va + (vb - va) * (t - a) / (b - a)  # noqa: E731
        rate = lambda t, y, f=line: (y[1], -4 * y[0] - y[1] / 5 - y[0] ** 3 - f(t))  # noqa: E731
        y = integrate.solve_ivp(rate, (a, b), y, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    assert run.final == pytest.approx(y, abs=1e-9)


def test_two_sampled_inputs_of_different_rates_and_a_contact():
    rng = np.random.default_rng(8)
    a, b = sp.symbols("a b", real=True)
    inputs = {a: sf.Signal(rng.normal(size=150), 0.1), b: sf.Signal(rng.normal(size=31), 1 / 3, t0=-1.0)}
    contacts = [sf.Contact("floor", U - 0.1 * b, 1 + 0.2 * b**2, sf.laws.coulomb(0.4, 0.3))]
    scene = one_mass(-2 * X - a, contacts, horizon=12.0, inputs=inputs)
    coarse, fine = (sf.simulate(scene, tolerance).checked() for tolerance in (1e-8, 1e-13))
    other = sf.simulate(scene, 1e-9, route="integrators").checked()
    assert np.max(np.abs(coarse.final - fine.final)) < 1e-7
    assert np.max(np.abs(other.final - fine.final)) < 1e-6
    assert len(fine.events) > 10


def test_constraints_hold_while_sticking():
    run = sf.simulate(SCENES["carried"], 1e-12).checked()
    slips = sp.lambdify([(X, Y, U, W)], [c.slip for c in SCENES["carried"].contacts])
    for k in range(len(run.t) - 1):
        middle = 0.5 * (run.t[k] + run.t[k + 1])
        w = np.array(slips(run(middle)))
        mode = run.mode[:, k]
        assert np.all(np.abs(w[mode == 0]) < 1e-11)
        assert np.all(w[mode != 0] * mode[mode != 0] > -1e-12)
    assert {0, 1, -1} <= set(run.mode.ravel())


def test_one_contact_released_by_another_that_is_caught():
    # a block pushed against a second one by a stop-like stick: the catch of one contact changes the load of the other
    law = sf.laws.coulomb(0.3)
    contacts = [sf.Contact("a", U, 1, law), sf.Contact("b", W - U, 1, law)]
    system = sf.System(q=[X, Y], u=[U, W], mass=sp.eye(2), force=[0, 0])
    scene = sf.Scene(system=system, contacts=contacts, initial={X: 0, Y: 0, U: 1.0, W: 2.0}, horizon=20.0)
    run = sf.simulate(scene, 1e-12).checked()
    # a: u' = -.3 + .3 = 0, b: w' = -.3; they meet at u = 1 at t = 10/3; together u' = -.15 until rest at t = 10
    assert run.final == pytest.approx([10 / 3 + 1 / 0.3, 10 / 3 * 1.5 + 1 / 0.3, 0, 0], abs=1e-10)
    assert [(e.contact, e.before, e.after) for e in run.events] == [("b", 1, 0), ("a", 1, 0)]
    assert [e.t for e in run.events] == pytest.approx([10 / 3, 10], abs=1e-10)


JOINT = sf.laws.coulomb(0.1, 0.08)
T = sf.TIME


def double_pendulum(contacts, horizon=15.0):
    mass = [[2, sp.cos(X - Y)], [sp.cos(X - Y), 1]]
    force = [-(W**2) * sp.sin(X - Y) - 2 * sp.sin(X), U**2 * sp.sin(X - Y) - sp.sin(Y)]
    system = sf.System(q=[X, Y], u=[U, W], mass=mass, force=force)
    return sf.Scene(system=system, contacts=contacts, initial={X: 1.2, Y: 0.3, U: 0, W: 0}, horizon=horizon)


def on_belt(force=-X - U / 10, slip=U - 0.2, normal=1, law=CUBIC, profile=1, **more):
    return one_mass(force, [sf.Contact("belt", slip, normal, law, profile)], **more)


VARIED = {
    "belt speed that varies": on_belt(slip=U - 0.2 * sp.cos(3 * T), normal=1 + 0.3 * U),
    "load that follows the velocity": on_belt(normal=1 + U / 2),
    "load that varies in time": on_belt(normal=1 + 0.9 * sp.sin(5 * T)),
    "load that touches zero": on_belt(normal=1 + sp.sin(5 * T)),
    "load with a floor": on_belt(normal=sp.Max(0, 1 + 2 * sp.sin(5 * T))),
    "profile that touches zero": on_belt(-X, U, law=sf.laws.coulomb(0.3), profile=sp.Abs(X), x=1.0),
    "profile in pieces": on_belt(-X, U - 0.1, law=sf.laws.coulomb(0.3, 0.2), profile=1 + sp.Max(X, 0), x=1.0),
    "kink at the slip": on_belt(-X - 0.3 * sp.Abs(U - 0.2)),
    "kink at rest": on_belt(-X - sp.Abs(X) / 2, U, law=sf.laws.coulomb(0.1), x=1.0),
    "dead zone": on_belt(-sp.Max(X - 0.1, 0) - sp.Min(X + 0.1, 0) - U / 10, law=sf.laws.coulomb(0.05, 0.03)),
    "largest of four": on_belt(-X - sp.Max(X, U, X * U, sp.Rational(1, 10))),
    "pendulum": on_belt(-sp.sin(X), U, 0.5 + 0.2 * U**2 + 0.3 * sp.cos(X) ** 2, JOINT, x=2.5),
    "Hertzian spring": on_belt(sp.Rational(1, 2) - sp.Max(X, 0) ** sp.Rational(3, 2)),
    "double pendulum": double_pendulum([sf.Contact("a", U, 1, JOINT), sf.Contact("b", W - U, 1, JOINT)]),
    "tip on a belt": double_pendulum([sf.Contact("tip", U * sp.cos(X) + W * sp.cos(Y) - 0.3, 0.4, CUBIC)]),
}


@pytest.mark.one_in(16)
@pytest.mark.parametrize("name", longer(VARIED, ("tip on a belt",)))
def test_loads_kinks_and_geometry_agree_with_the_independent_route(name):
    scene = VARIED[name]
    fine, other = sf.simulate(scene, 1e-12).checked(), sf.simulate(scene, 1e-8, route="integrators").checked()
    assert np.max(np.abs(fine.final - other.final)) < 1e-6
    coarse = sf.simulate(scene, 1e-7).checked()
    assert np.max(np.abs(coarse.final - fine.final)) < 2e-6
    events = [[(e.contact, e.before, e.after) for e in run.events] for run in (coarse, fine, other)]
    assert events[0] == events[1] == events[2]
    assert fine.energy_residual() < 1e-10


@pytest.mark.long(beside="test_redundant_contacts_move_like_one_with_the_summed_law")
def test_redundant_contacts_whose_slip_turns_with_the_position():
    slip = U * sp.cos(X) + W * sp.cos(Y) - 0.3
    both = double_pendulum([sf.Contact("a", slip, 0.4, CUBIC), sf.Contact("b", slip, 0.4, CUBIC)])
    single = double_pendulum([sf.Contact("a", slip, 0.8, CUBIC)])
    two, one = (sf.simulate(scene, 1e-10).checked() for scene in (both, single))
    assert np.max(np.abs(two.final - one.final)) < 1e-13
    assert two.stats["events"] == 2 * one.stats["events"]
    assert np.max(np.abs(two.final - sf.simulate(both, 1e-8, route="integrators").checked().final)) < 1e-6


def test_parallel_contacts_hold_with_the_sum_of_their_static_bounds():
    law = sf.laws.coulomb(0.5, 0.3)
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[-X])

    def belt(*contacts):
        return sf.simulate(sf.Scene(system, contacts, initial={X: 0, U: 0}, horizon=50), 1e-11).checked()

    one = belt(sf.Contact("a", U - 0.1, 1.0, law))
    two = belt(sf.Contact("a", U - 0.1, 0.6, law), sf.Contact("b", 2 * (0.1 - U), 0.2, law))
    assert np.max(np.abs(two.final - one.final)) < 1e-13
    assert two.energy_residual() < 1e-11
    releases = [[e.t for e in run.events if e.contact == "a" and e.kind == "slip"] for run in (one, two)]
    assert releases[1] == pytest.approx(releases[0], abs=1e-12)
    assert releases[0][0] == pytest.approx(one.events[0].t + (0.5 - one(one.events[0].t)[0]) / 0.1, abs=1e-10)


def test_contacts_that_cannot_all_stick_let_the_weakest_slip():
    # two belts at different speeds pull one body: it follows the stronger one
    law = sf.laws.coulomb(0.5)
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[-X / 100])
    belts = [sf.Contact("slow", U - 0.1, 1.0, law), sf.Contact("fast", U - 0.1 - 0.3 * T**2 / (1 + T**2), 3.0, law)]
    scene = sf.Scene(system, belts, initial={X: 0, U: 0.1}, horizon=5)
    for tolerance in (1e-7, 1e-11):
        run = sf.simulate(scene, tolerance).checked()
        assert run.mode[:, -1].tolist() == [1, 0]
        assert run.final[1] == pytest.approx(0.1 + 0.3 * 25 / 26, abs=1e-9)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("tolerance", [1e-7, 1e-9, 1e-11])
def test_more_contacts_than_coordinates_hold_the_system_at_rest(tolerance):
    slip = U * sp.cos(X) + W * sp.cos(Y)
    contacts = [sf.Contact("tip", slip, 0.4, CUBIC), sf.Contact("a", U, 0.4, CUBIC), sf.Contact("b", W - U, 0.4, CUBIC)]
    run = sf.simulate(double_pendulum(contacts, horizon=30.0), tolerance)
    assert run.status == sf.Status.OK, run.advice
    assert np.max(np.abs(run.final[2:])) < 1e-12
    assert run.mode[:, -1].tolist() == [0, 0, 0]


@pytest.mark.one_in(6)
@pytest.mark.parametrize("profile", [1 + 1.6 * sp.Abs(X), 1 + sp.Max(0, X), 2 - sp.Min(sp.Abs(X), 1)])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_sticking_at_a_kink_of_the_profile(profile, tolerance):
    def shaken(x0, tolerance):
        contact = sf.Contact("c", slip=U, normal=9.81, law=sf.laws.coulomb(0.05), profile=profile)
        system = sf.System(q=[X], u=[U], mass=[[1]], force=[-3 * sp.sin(4 * T)])
        scene = sf.Scene(system=system, contacts=[contact], initial={X: x0, U: 0}, horizon=5)
        return sf.simulate(scene, tolerance).checked()

    at_kink, beside = shaken(0.0, tolerance), shaken(1e-9, 1e-13)
    assert np.max(np.abs(at_kink.final - beside.final)) < 1e-7 + 10 * tolerance
    assert at_kink.stats["events"] == beside.stats["events"]


@pytest.mark.one_in(6)
@pytest.mark.parametrize("how", ["linear", "tanh", "arctan"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
def test_a_law_without_a_jump_starts_where_forces_cancel_to_rounding(how, tolerance):
    def pulled(x, tolerance):
        law = sf.laws.coulomb(0.5).regularised(0.01, how)
        scene = one_mass(0.11 + 0.66 + 0.03 - 1.1 * X - 0.1 * U, [sf.Contact("belt", U - 0.3, 1, law)], x=x, u=0.3)
        return sf.simulate(scene, tolerance, route="taylor").checked().final

    assert pulled(0.7, tolerance) == pytest.approx(pulled(0.7 + 1e-13, 1e-13), abs=10 * tolerance)
