"""Friction and damping from a decay: what went into a motion comes out, from its turning points and from its record."""

import numpy as np
import pytest

import symfric as sf
from symfric.theory import decay_record


def rod(mu_m=0.19, zeta=0.009, f_n=5.3, **more):
    return sf.simulate(sf.scenes.contact_damper(f_n=f_n, mu_m=mu_m, zeta=zeta, **more), 1e-12).checked()


def turning_points(run, x0=0.01):
    """Distances of the turning points: the start, and where the rod reverses or sticks, to alternating sides."""
    times = [e.t for e in run.events if e.kind in ("reverse", "stick")]
    return [x0, *((-1) ** (k + 1) * float(run(t)[0]) for k, t in enumerate(times))]


def record(run, n=4001):
    t = np.linspace(0, run["stop_time"], n)
    return t, *run(t)


def test_the_rod_of_the_source():
    run = rod()
    assert run["stop_time"] == pytest.approx(0.2830567, abs=5e-8)
    points = turning_points(run)
    assert len(points) == 4
    fit = decay_record.from_turning_points(points, f_n=5.3)
    assert (fit.mu_m, fit.zeta) == pytest.approx((0.19, 0.009), rel=1e-4)
    by_time = decay_record.from_turning_points(points, t_d=run["stop_time"])  # which is that of three half cycles
    assert (by_time.mu_m, by_time.zeta) == pytest.approx((0.19, 0.009), rel=1e-3)
    fit = decay_record.from_motion(*record(run))
    assert (fit.mu_m, fit.zeta, fit.f_n) == pytest.approx((0.19, 0.009, 5.3), rel=2e-6)
    assert fit.misfit < 1e-7


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("mu_m", "zeta", "more"),
    [
        (0.05, 0.002, {}),
        (0.1, 0.0, {}),
        (0.02, 0.05, {}),
        (0.1, 0.01, {"v_c": 0.2}),  # friction falls to a fifth
        (0.2, 0.01, {"r": 0.5, "x0": 0.02}),
        (0.03, 0.005, {"f_n": 12.0, "x0": 0.004}),
    ],
)
def test_what_went_in_comes_out(mu_m, zeta, more):
    run = rod(mu_m, zeta, **more)
    given = {"r": more.get("r", 1.0), "v_c": more.get("v_c", 1.0)}
    fit = decay_record.from_motion(*record(run, 16001), **given)
    assert (fit.mu_m, fit.zeta, fit.f_n) == pytest.approx((mu_m, zeta, more.get("f_n", 5.3)), rel=1e-5, abs=1e-7)
    fit = decay_record.from_turning_points(turning_points(run, more.get("x0", 0.01)), f_n=more.get("f_n", 5.3), **given)
    assert (fit.mu_m, fit.zeta) == pytest.approx((mu_m, zeta), rel=5e-3, abs=2e-5)


def test_constant_friction_without_damping_is_exact():
    delta = 0.1 * 9.81 / (2 * np.pi * 5.3) ** 2
    points = 0.01 - 2 * delta * np.arange(5)
    fit = decay_record.from_turning_points(points, f_n=5.3, v_c=1e12)
    assert fit.mu_m == pytest.approx(0.1, rel=1e-9)
    assert abs(fit.zeta) < 1e-12


def test_the_error_of_the_turning_points_is_of_second_order():
    errors = []
    for share in (1.0, 0.5, 0.25):
        run = rod(0.04 * share, 0.08 * share)
        points = turning_points(run)[:4]
        errors.append(abs(decay_record.from_turning_points(points, f_n=5.3).zeta / (0.08 * share) - 1))
    assert 3 < errors[0] / errors[1] < 5
    assert 3 < errors[1] / errors[2] < 5


def test_a_record_with_noise_and_without_velocities():
    t, x, _ = record(rod(0.05, 0.01), 3001)
    fit = decay_record.from_motion(t, x)
    assert (fit.mu_m, fit.zeta, fit.f_n) == pytest.approx((0.05, 0.01, 5.3), rel=1e-4)
    rng = np.random.default_rng(1)
    found = np.array(
        [decay_record.from_motion(t, x, np.gradient(x, t) + 1e-3 * rng.normal(size=t.size)) for _ in range(20)]
    )
    mean, scatter = found[:, :2].mean(axis=0), found[:, :2].std(axis=0)
    assert mean == pytest.approx([0.05, 0.01], rel=0.03)
    assert np.all(scatter < [0.002, 0.0006])


def test_a_start_for_the_general_fit_lies_within_its_reach():
    run = rod()
    fit = decay_record.from_turning_points(np.round(turning_points(run), 4), f_n=5.3)  # read off to 0.1 mm
    again = rod(fit.mu_m, max(fit.zeta, 0.0))
    assert again["stop_time"] == pytest.approx(run["stop_time"], rel=1e-3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: decay_record.from_turning_points([0.01, 0.005], f_n=5), "three or more"),
        (lambda: decay_record.from_turning_points([0.01, 0.012, 0.005], f_n=5), "each smaller"),
        (lambda: decay_record.from_turning_points([3, 2, 1]), "give either f_n"),
        (lambda: decay_record.from_turning_points([3, 2, 1], f_n=5, t_d=1), "give either f_n"),
        (lambda: decay_record.from_turning_points([3, 2, 1], f_n=-5), "f_n is -5"),
        (lambda: decay_record.from_motion([0, 1], [1, 0]), "eight or more"),
        (lambda: decay_record.from_motion(np.arange(9.0), np.ones(9)), "nothing moves"),
        (lambda: decay_record.from_motion(np.arange(9.0), np.ones(9), [1.0]), "as many velocities"),
    ],
)
def test_bad_records(call, message):
    with pytest.raises(sf.SceneError, match=message):
        call()
