"""Contacts behind springs: exact stick and slip of a slider without mass."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf
from symfric.model.springs import stop_rate

x, u = sp.symbols("x u", real=True)
W, K, MU, N = sp.symbols("W k mu N", positive=True)
OSCILLATOR = sf.System([x], [u], [[1]], [-x - u / 10 + sp.cos(W * sf.TIME)])


def oscillator(normal=N, horizon=60.0, contacts=(), start=None, **values):
    """A driven oscillator with a joint: m = k = 1, damping ratio .05."""
    joint = sf.Contact("joint", u, normal, sf.laws.coulomb(MU), stiffness=K)
    given = {"W": 1.0, "k": 0.5, "mu": 0.3, "N": 1.0} | values
    return sf.Scene(OSCILLATOR, [joint, *contacts], given, {x: 0, u: 0} | (start or {}), horizon)


@pytest.mark.parametrize(
    ("omega", "amplitude"),
    [(1.0, 6.43134985898), (1.1, 3.9838389616)],  # event-driven with two tolerances, which agree to 1e-10
)
def test_steady_amplitude_of_a_driven_joint(omega, amplitude):
    orbit = sf.limit_cycle(oscillator(W=omega))
    assert orbit.x_max[0] == pytest.approx(amplitude, abs=1e-9)
    assert orbit.half_range[0] == pytest.approx(amplitude, abs=1e-9)  # symmetric
    assert orbit.multipliers[-1] == 0.0  # the slider forgets where it was
    assert orbit.stable
    assert orbit.differentiable
    assert [(e.before, e.after) for e in orbit.events] == [(1, 0), (0, -1), (-1, 0), (0, 1)]


def test_the_loop_of_force_over_displacement_in_closed_form():
    """Quasi-static: a mass that follows x = A sin t, the force in each of its four branches."""
    A, k, limit = 2.0, 0.5, 0.3
    system = sf.System([x], [u], [[1]], [-A * sp.sin(sf.TIME)])
    slip = A * sp.cos(sf.TIME) + sp.Float(1e-30) * u  # of a displacement that is given
    joint = sf.Contact("joint", slip, 1, sf.laws.coulomb(limit), stiffness=k)
    wanted = {"work": sf.Integral(sf.friction_force("joint") * sf.slip("joint")), "path": sf.Trajectory()}
    run = sf.simulate(sf.Scene(system, [joint], {}, {x: 0, u: A}, 4 * np.pi, wanted), 1e-12).checked()
    turns = [np.arcsin(limit / k / A), np.pi / 2]
    back = np.pi - np.arcsin(1 - 2 * limit / k / A)
    turns += [back, 1.5 * np.pi, back + np.pi, 2.5 * np.pi, back + 2 * np.pi, 3.5 * np.pi, back + 3 * np.pi]
    assert [e.t for e in run.events] == pytest.approx(turns[: len(run.events)], abs=1e-10)
    loop = -4 * limit * (A - limit / k)  # area of a loop: the work of each full period
    first = -limit * (A - limit / k) - 0.5 * limit**2 / k  # of the first quarter, the spring charged included
    rest = 3.5 * np.pi
    assert run.outputs["work"] == pytest.approx(
        first + 7 / 4 * loop + _from_turn(A, k, limit, rest, 4 * np.pi), abs=1e-9
    )


def _from_turn(A, k, limit, start, end):
    """Work from a turning point after which the slider sticks, then slides, less the quarter of a loop."""
    at, to = A * np.sin(start), A * np.sin(end)
    reach = 2 * limit / k
    elastic = min(reach, to - at)
    work = limit * elastic - 0.5 * k * elastic**2 - limit * max(0.0, to - at - reach)
    return work + limit * (A - limit / k)


def test_a_load_that_follows_the_motion_against_a_projected_integration():
    normal = 1 + sp.Rational(4, 10) * x
    joint = sf.Contact("joint", u, normal, sf.laws.coulomb(0.3), stiffness=0.5)
    scene = sf.Scene(OSCILLATOR, [joint], {W: 0.7}, {x: 0.5, u: 0}, 12.0)
    run = sf.simulate(scene, 1e-12).checked()
    assert len(run.events) > 4
    mode, t, y = 0, 0.0, np.array([0.5, 0.0, 0.0])
    k, limit = 0.5, lambda q: 0.3 * (1 + 0.4 * q)
    while t < 12.0:

        def rate(t, y, e):
            pull = k * y[2] if e == 0 else e * limit(y[0])
            return [y[1], -y[0] - y[1] / 10 + np.cos(0.7 * t) - pull, y[1] if e == 0 else e * 0.12 * y[1] / k]

        if mode == 0:
            guards = [lambda t, y, e: limit(y[0]) - k * y[2], lambda t, y, e: limit(y[0]) + k * y[2]]
        else:
            guards = [lambda t, y, e: e * y[1] - 0.12 * y[1] / k]
        for g in guards:
            g.terminal, g.direction = True, -1
        leg = solve_ivp(rate, (t, 12.0), y, args=(mode,), events=guards, rtol=1e-11, atol=1e-13, method="DOP853")
        t, y = leg.t[-1], leg.y[:, -1]
        hit = [i for i, e in enumerate(leg.t_events) if e.size]
        if hit:
            mode = (1, -1)[hit[0]] if mode == 0 else 0
    assert run.final == pytest.approx(y, abs=1e-8)


def test_derivatives_of_state_and_peak_by_everything():
    scene = oscillator(horizon=9.0).wanting({"top": sf.Max(x)})
    names = ("k", "mu", "N", "W", "joint.z")
    run = sf.simulate(scene, 1e-12, sensitivities=names)
    for name in names:
        ends, tops = [], []
        for step in (1e-5, -1e-5):
            if name == "joint.z":
                beside = scene.starting({name: step})
            else:
                beside = scene.where({name: scene.values[scene.parameter(name)] + step})
            there = sf.simulate(beside, 1e-13)
            ends.append(there.final)
            tops.append(there["top"])
        assert run.sensitivities[name] == pytest.approx((ends[0] - ends[1]) / 2e-5, abs=1e-7)
        assert run.output_sensitivities["top"][name] == pytest.approx((tops[0] - tops[1]) / 2e-5, abs=1e-7)


def test_energy_balance_and_modes_in_the_order_of_the_contacts():
    floor = sf.Contact("floor", u - sp.Rational(1, 10), 1, sf.laws.coulomb(0.1))
    scene = oscillator(contacts=[floor], horizon=30.0)
    run = sf.simulate(scene, 1e-11).checked()
    assert {e.contact for e in run.events} == {"joint", "floor"}
    assert run.energy_residual() < 1e-9
    first = next(e for e in run.events if e.contact == "joint")
    at = int(np.searchsorted(run.t, first.t * (1 + 1e-12))) - 1
    assert run.mode.shape[0] == 2
    assert run.mode[0, at] == first.after
    stretched = np.abs(run["joint.z"]) * 0.5
    assert np.max(stretched) == pytest.approx(0.3, abs=1e-12)


def test_a_spring_stretched_beyond_the_limit_starts_at_it():
    scene = oscillator(start={"joint.z": 5.0}, horizon=1.0)
    other = oscillator(start={"joint.z": 0.6}, horizon=1.0)
    assert sf.simulate(scene).final == pytest.approx(sf.simulate(other).final, abs=1e-9)


def test_many_runs_and_no_load_at_all():
    scene = oscillator(horizon=8.0).wanting({"end": sf.End(), "top": sf.Max(x)})
    batch = sf.prepare(scene).map(values={"N": np.array([0.0, 0.5, 1.0])})
    assert np.all(batch.status == sf.Status.OK)
    assert batch.final[:, 2] == pytest.approx(sf.simulate(scene).final, abs=1e-9)
    free = sf.Scene(OSCILLATOR, (), {W: 1.0}, {x: 0, u: 0}, 8.0)
    assert batch.final[:2, 0] == pytest.approx(sf.simulate(free).final, abs=1e-8)


FAULTS = {
    "law": (lambda: sf.Contact("a", u, 1, sf.laws.stribeck(0.4, 0.3, 0.1), stiffness=1.0), "only Coulomb's law"),
    "drop": (lambda: sf.Contact("a", u, 1, sf.laws.coulomb(0.4, 0.3), stiffness=1.0), "only Coulomb's law"),
    "zero": (lambda: sf.Contact("a", u, 1, sf.laws.coulomb(0.4), stiffness=0), "must be positive"),
    "negative": (lambda: sf.Contact("a", u, 1, sf.laws.coulomb(0.4), stiffness=-2.0), "must be positive"),
    "value": (lambda: oscillator(k=-1.0), "stiffness of contact 'joint' is -1; it must be positive"),
    "load": (lambda: oscillator(1 + u), "may depend on q and time only"),
    "smooth": (lambda: oscillator().regularised(1e-3), "is behind a spring"),
    "peer": (lambda: sf.simulate(oscillator(), route="integrators"), "is behind a spring"),
}


def test_the_route_exact_agrees():
    a, b = (sf.simulate(oscillator(), 1e-13, route=route).checked() for route in ("exact", "taylor"))
    assert len(a.events) == len(b.events) > 3
    assert a.final == pytest.approx(b.final, abs=1e-11)


@pytest.mark.parametrize("name", FAULTS)
def test_what_a_spring_does_not_take(name):
    act, words = FAULTS[name]
    with pytest.raises((sf.SceneError, sf.NoRoute), match=words):
        act()


def test_the_rate_of_a_spring_that_is_read():
    """It follows the slip while it carries less than the limit, and back from the limit; beyond it stands still."""
    joint = sf.Contact("joint", u, N, sf.laws.coulomb(MU), stiffness=K)
    z, rate = stop_rate(joint)
    for at, speed, expected in (
        (0.5, 1.0, 1.0),
        (0.6, 1.0, 0.0),
        (0.6, -1.0, -1.0),
        (-0.6, -1.0, 0.0),
        (-0.6, 2.0, 2.0),
    ):
        assert float(rate.subs({z: at, u: speed, K: 0.5, MU: 0.3, N: 1.0})) == expected


def test_static_friction_of_a_slider_equals_the_kinetic():
    for law in (sf.laws.coulomb(0.4, 0.3), sf.laws.coulomb(MU, W), sf.laws.coulomb(2 * MU, MU)):
        with pytest.raises(sf.SceneError, match="one coefficient determines its motion"):
            sf.Contact("joint", u, N, law, stiffness=K)
    for law in (sf.laws.coulomb(0.4), sf.laws.coulomb(MU), sf.laws.coulomb(MU + W, W + MU)):
        assert sf.Contact("joint", u, N, law, stiffness=K).stiffness == K
