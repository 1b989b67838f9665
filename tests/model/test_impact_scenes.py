"""The ready scenes of contacts that open against closed forms, published figures and other computations."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf
from symfric.solve.facts import warn_of_redundance


@pytest.mark.one_in(6)
@pytest.mark.parametrize("beta", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("mu", [0.3, 0.6])
def test_a_part_begins_to_slide_and_to_fly_where_the_track_says(mu, beta):
    a, g = 0.002, 9.81
    slides = np.sqrt(mu * g / (a * (np.cos(beta) + mu * np.sin(beta))))
    flies = np.sqrt(g / (a * np.sin(beta)))
    scene = sf.scenes.vibratory_conveyor(mu=mu, a=a, Omega=1.0, beta=beta, horizon=2.0)
    for limit, kind in ((slides, ("slip", "reverse")), (flies, ("open",))):
        for factor in (0.995, 1.005):
            run = sf.simulate(scene.where({"Omega": factor * limit}))
            assert any(event.kind in kind for event in run.events) == (factor > 1)
    assert run.energy_residual() < 1e-9


def test_a_part_that_sticks_is_not_carried():
    scene = sf.scenes.vibratory_conveyor(mu=0.6, a=0.002, Omega=20.0, beta=0.5)
    assert abs(sf.simulate(scene)["distance"]) < 0.002


def conveyor_by_steps(Omega, steps, *, mu, a, beta, e, horizon, g=9.81):
    """Moreau's scheme at first order, with the projection of friction in the impulse."""
    dt = horizon / steps
    x = np.zeros(2)
    u = a * Omega * np.array([np.cos(beta), np.sin(beta)])
    for k in range(steps):
        t = k * dt
        middle = x + 0.5 * dt * u
        free = u + dt * np.array([0.0, -g])
        if middle[1] - a * np.sin(beta) * np.sin(Omega * (t + 0.5 * dt)) <= 0:
            track = [a * Omega * np.cos(Omega * s) * np.array([np.cos(beta), np.sin(beta)]) for s in (t, t + dt)]
            p = max(0.0, track[1][1] - e * (u[1] - track[0][1]) - free[1])
            f = np.clip(track[1][0] - free[0], -mu * p, mu * p)
            free = free + np.array([f, p])
        x, u = middle + 0.5 * dt * free, free
    return x[0]


@pytest.mark.long(beside="test_a_part_that_sticks_is_not_carried")
def test_transport_against_a_time_stepping_scheme():
    given = {"mu": 0.4, "a": 0.002, "beta": 0.5, "e": 0.0, "horizon": 0.5}
    off = np.zeros(2)
    for Omega in (80.0, 95.0, 110.0):
        exact = sf.simulate(sf.scenes.vibratory_conveyor(Omega=Omega, **given))["distance"]
        own = [abs(conveyor_by_steps(Omega, n, **given) - exact) for n in (1000, 16000)]
        assert own[1] < 2e-3 * abs(exact)
        off += own
    assert off[1] < 0.2 * off[0]  # at first order, one sixteenth


def test_impact_oscillator_has_the_orbit_of_thirty_digits():
    orbit = sf.limit_cycle(sf.scenes.impact_oscillator(e=0.7, zeta=0.05, Omega=2.2))
    (event,) = orbit.events
    period = 2 * np.pi / 2.2
    assert event.t % period == pytest.approx(1.1070263803145, abs=1e-9)
    found = orbit.multipliers[np.argsort(orbit.multipliers.imag)][-1]
    assert found == pytest.approx(0.486387161 + 0.3628963134j, abs=1e-8)
    assert np.prod(orbit.multipliers).real == pytest.approx(0.7**2 * np.exp(-0.1 * period), rel=1e-9)


@pytest.mark.parametrize("gap", [0.5, 1.0])
def test_the_orbit_without_impacts_touches_where_its_amplitude_is_the_gap(gap):
    zeta, Omega = 0.05, 0.8
    F = gap * np.hypot(1 - Omega**2, 2 * zeta * Omega)
    scene = sf.scenes.impact_oscillator(e=0.5, zeta=zeta, Omega=Omega, F=F, gap=gap)
    for factor in (0.99, 1.01):
        run = sf.simulate(scene.where({"F": factor * F}).until(500.0))
        late = [event for event in run.events if event.t > 400.0]
        assert bool(late) == (factor > 1)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("m", "k", "preload", "h"), [(0.5, 400.0, 0.02, 0.01), (0.2, 900.0, 0.0, 0.02), (1, 50, 0.3, 0.1)]
)
def test_cam_lifts_off_above_the_speed_of_the_closed_form(m, k, preload, h):
    limit = np.sqrt(k * (2 * h + preload) / (m * h))
    for factor in (0.9999, 1.0001):
        cam = sf.scenes.cam_follower(m=m, k=k, preload=preload, h=h, Omega=factor * limit, horizon=6.3 / limit)
        run = sf.simulate(cam)
        assert any(event.kind == "open" for event in run.events) == (factor > 1)
        at_top = k * (2 * h + preload) - m * h * (factor * limit) ** 2
        assert run["least_force"] == pytest.approx(max(at_top, 0.0), abs=1e-9 * k * (h + preload))


def test_a_pad_lifts_off_where_its_support_takes_the_load():
    pad = sf.scenes.brake_pad(v_b=0.2, k_t=-3.5)
    run = sf.simulate(pad, tolerance=1e-11)
    opened = [event.t for event in run.events if event.kind == "open"]
    assert len(opened) > 10
    assert [run(t)[0] for t in opened] == pytest.approx([1 / 3.5] * len(opened), abs=1e-8)
    assert run.energy_residual() < 1e-8


def test_a_pad_that_stays_on_moves_like_one_under_a_load_that_follows():
    x, u = sp.symbols("x u", real=True)
    load = 1 - 2 * x
    alone = sf.Scene(
        system=sf.System([x], [u], [[1]], [-x - u / 20]),
        contacts=[sf.Contact("disc", slip=u - sp.Rational(1, 5), normal=load, law=sf.laws.cubic(0.4, 0.25, 0.5))],
        initial={x: 0.0, u: 0.0},
        horizon=100.0,
    )
    run, other = sf.simulate(sf.scenes.brake_pad(v_b=0.2, k_t=-2.0, horizon=100.0), 1e-11), sf.simulate(alone, 1e-11)
    assert run.final[[0, 2]] == pytest.approx(other.final, abs=1e-7)
    assert run["least_force"] == pytest.approx(1 - 2 * np.max(other(np.linspace(0, 100, 40001))[0]), abs=1e-6)


def test_mass_with_stops_is_that_of_the_modelica_library():
    run = sf.simulate(sf.scenes.mass_with_stops(), tolerance=1e-12)
    (hit,) = [event for event in run.events if event.contact == "stop_low"]

    def rate(_t, y):  # sliding backward, then to and fro, by another integrator
        v = abs(y[1])
        return [y[1], -500 * (y[0] + 0.25) - np.sign(y[1]) * (3 + v + 5 * np.exp(-2 * v))]

    def hits(_t, y):
        return y[0] + 0.4

    hits.terminal = True
    other = solve_ivp(rate, (0, 1), [0, -5], method="DOP853", rtol=1e-12, atol=1e-13, events=hits)
    assert hit.t == pytest.approx(other.t[-1], rel=1e-10)
    assert (hit.t, run.events[-1].t) == pytest.approx((0.0605970956085218, 1.04597374851725), abs=1e-9)
    assert run.final == pytest.approx([-0.247513987281765, 0.0], abs=1e-9)


@pytest.mark.parametrize(("alpha", "theta0"), [(0.2, 0.1), pytest.param(0.15, 0.1, marks=pytest.mark.long)])
def test_a_block_let_go_loses_speed_as_housner_says(alpha, theta0):
    still = sf.Signal([0.0, 0.0], 3.0)
    block = sf.scenes.rocking_block(R=1.0, alpha=alpha, mu=5.0, theta0=theta0, motion=still, horizon=3.0)
    run = sf.simulate(block, tolerance=1e-11)
    times = [event.t for event in run.events if event.kind == "close"]
    assert len(times) >= 3
    keeps = 1 - 1.5 * np.sin(alpha) ** 2
    for t in times:
        before, after = run.path.before(np.array([t]))[5, 0], run(t)[5]
        assert after / before == pytest.approx(keeps, abs=1e-8)
    # the quarter period of the large angle: J w^2/2 = m g (R cos(alpha - theta0) - ...) integrated by quadrature
    p2 = 3 * 9.81 / 4
    x = np.polynomial.legendre.leggauss(60)
    s = 0.5 * (1 + x[0])
    theta = theta0 * (1 - s**2)  # the integrand has the root of theta0 - theta in its denominator
    w = np.sqrt(2 * p2 * (np.cos(alpha - theta) - np.cos(alpha - theta0)) * -1)
    assert times[0] == pytest.approx(np.sum(0.5 * x[1] * 2 * theta0 * s / w), rel=1e-9)


@pytest.mark.long(beside="test_a_block_let_go_loses_speed_as_housner_says")
def test_a_block_rocks_where_the_ground_pulls_harder_than_its_slope():
    alpha = 0.25
    ramp = sf.Signal([0.0, 10.0], 2.0)  # the ground is pulled away ever harder
    run = sf.simulate(sf.scenes.rocking_block(R=0.8, alpha=alpha, mu=2.0, motion=ramp, horizon=1.0))
    opened = next(event for event in run.events if event.kind == "open")
    assert 5.0 * opened.t == pytest.approx(9.81 * np.tan(alpha), rel=1e-7)


@pytest.mark.long(beside="test_a_block_let_go_loses_speed_as_housner_says")
def test_a_block_that_slides_first_does_not_rock():
    ramp = sf.Signal([0.0, 10.0], 2.0)
    block = sf.scenes.rocking_block(R=0.8, alpha=0.25, mu=0.2, motion=ramp, horizon=1.0)
    run = sf.simulate(block, tolerance=1e-11)
    assert {event.kind for event in run.events} == {"slip"}
    slides = 0.2 * 9.81 / 5.0  # when both corners have reached their bounds
    assert run.events[-1].t == pytest.approx(slides, rel=1e-7)
    assert run(0.999 * slides)[3] == 0.0
    assert run.final[3] == pytest.approx(-(2.5 * (1 - slides**2) - 0.2 * 9.81 * (1 - slides)), rel=1e-9)


def test_a_block_that_falls_over_lies_on_its_side():
    burst = sf.motions.sine_burst(4.0, 1.0, cycles=4)
    run = sf.simulate(sf.scenes.rocking_block(R=1.0, alpha=0.25, mu=0.3, motion=burst), tolerance=1e-11)
    assert abs(run.final[2]) == pytest.approx(np.pi / 2, abs=1e-9)
    assert run.final[1] == pytest.approx(np.sin(0.25), abs=1e-9)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: sf.scenes.vibratory_conveyor(mu=0.4, a=0.0, Omega=1.0, beta=0.5), "a is 0"),
        (lambda: sf.scenes.impact_oscillator(e=1.2, zeta=0.1, Omega=1.0), "between 0 and 1"),
        (lambda: sf.scenes.brake_pad(v_b=0.2, k_t=6.0), "the pad in the air is not held"),
        (lambda: sf.scenes.mass_with_stops(peak=0.9), "peak is 0.9"),
        (lambda: sf.scenes.rocking_block(R=1.0, alpha=2.0), "below pi/2"),
        (lambda: sf.scenes.rocking_block(R=1.0, alpha=0.2, theta0=0.3), "falls over"),
        (lambda: sf.scenes.rocking_block(R=1.0, alpha=0.2, motion=3), "give a sf.Signal"),
    ],
)
def test_bad_numbers_are_one_line(make, said):
    with pytest.raises(sf.SceneError, match=said):
        make()


def test_a_block_on_two_corners_is_no_redundancy_worth_a_warning(caplog):
    warn_of_redundance.cache_clear()  # each set of names is told once
    sf.prepare(sf.scenes.rocking_block(R=1.0, alpha=0.2, mu=5.0, theta0=0.1, motion=sf.Signal([0.0, 0.0], 3.0)), 1e-11)
    assert not caplog.messages
