"""Drives that stop over a time: the error against another integrator, its limit, and the best ramp against a grid."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symfric as sf
from symfric.design import positioning
from symfric.theory import drive


def stopped(mu1, mu2, lam, epsilon, start, ramp, speed, sigma=0.0):
    """Positioning error of a slide pulled by a drive that slows down; SciPy, by phases, without the package."""

    def place(t):
        return -speed * max(0.0, ramp - t) ** 2 / (2 * ramp)

    def push(t):
        return 2 * sigma * speed * max(0.0, 1 - t / ramp)

    def field(t, y):  # forces without fc, which drops out while the slide moves forward
        u = y[1]
        return u, place(t) - y[0] + push(t) - 2 * mu1 * min(u, 1.0) - 2 * mu2 * max(u - 1.0, 0.0)

    def rest(_t, y):
        return y[1]

    vars(rest).update(terminal=True, direction=-1)
    t, y = 0.0, np.array([place(0.0) - lam, start])
    while True:
        if y[1] <= 0:  # it sticks until the spring exceeds the static friction, if it does
            times = np.linspace(t, max(t, ramp), 20001)
            pull = np.array([place(s) + push(s) for s in times]) - y[0]
            loose = np.flatnonzero(pull > epsilon + 1e-13)
            if not loose.size:
                return y[0] + lam
            t, y = times[loose[0]], np.array([y[0], 1e-14])
        stops = [e for e in (ramp, t + 200.0) if e > t]
        for end in stops:  # the acceleration has a kink where the drive stands
            run = solve_ivp(field, (t, end), y, "DOP853", rtol=1e-11, atol=1e-13, events=rest, max_step=0.5)
            t, y = run.t[-1], run.y[:, -1].copy()
            if run.status == 1:
                y[1] = 0.0
                break


@pytest.mark.one_in(4)
@pytest.mark.parametrize("sigma", [0.0, 0.15])
@pytest.mark.parametrize(
    ("mu1", "mu2", "epsilon", "V", "ramp"),
    [(0.3, 0.3, 0.1, 0.5, 3.0), (-0.2, 0.4, 0.2, 2.0, 1.0), (-0.2, 0.4, 0.2, 2.0, 7.0), (0.2, 1.5, 0.0, 3.0, 12.0)],
)
def test_the_error_is_that_of_another_integrator(mu1, mu2, epsilon, V, ramp, sigma):
    lam = drive.excess(mu1, mu2, V, damper="support", sigma=sigma)
    scene = sf.scenes.drive_stop(mu1=mu1, mu2=mu2, lam=lam, epsilon=epsilon, speed=V, ramp=ramp, sigma=sigma, fc=50.0)
    found = sf.simulate(scene, 1e-11).checked()
    assert found["error"] == pytest.approx(stopped(mu1, mu2, lam, epsilon, V, ramp, V, sigma), abs=3e-6)
    assert found["stop_time"] > 0


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    "given",
    [
        {"mu1": 0.1, "mu2": 0.1, "lam": 0.1, "epsilon": 0.05, "speed": 0.5},
        {"mu1": -0.5, "mu2": 0.8, "lam": 4.0, "epsilon": 1.0, "speed": 4.125},
        {"mu1": -0.5, "mu2": 0.8, "lam": 4.0, "epsilon": 1.0, "speed": 0.0, "drive": 3.0},  # at rest
        {"mu1": -0.1, "mu2": 0.8, "lam": 1.2, "epsilon": 0.3, "speed": 2.0, "sigma": 0.3},  # damper on the support
    ],
)
def test_a_short_ramp_is_an_abrupt_stop(given):
    abrupt = sf.simulate(sf.scenes.drive_stop(**given), 1e-12)["error"]
    errors = [sf.simulate(sf.scenes.drive_stop(**given, ramp=r), 1e-12)["error"] - abrupt for r in (0.1, 0.01, 0.001)]
    first, second = errors[0] / errors[1], errors[1] / errors[2]
    order = 2 if given["speed"] and "sigma" not in given else 1  # a slide at rest is pulled on meanwhile
    assert abs(errors[2]) < 0.1 * 1e-3 ** (order - 1)
    assert first == pytest.approx(10**order, rel=0.3)
    assert second == pytest.approx(10**order, rel=0.3)


def slide(**changes):
    return sf.scenes.drive_slide(**{"mu1": 0.1, "mu2": 0.1, "p_star": 1.0, "epsilon": 0.05, **changes})


@pytest.mark.long(beside="test_a_short_ramp_is_an_abrupt_stop")
def test_the_best_ramp_against_a_grid():
    found = positioning(slide(), "ramp", (0.0, 10.0), (0.5, 0.5))
    grid = np.linspace(0.2, 10, 50)
    errors = [abs(stopped(0.1, 0.1, 0.1, 0.05, 0.5, r, 0.5)) for r in grid]
    assert found.objective <= min(errors) + 1e-6
    assert found.objective > min(errors) - 1e-3
    assert abs(grid[np.argmin(errors)] - found.values["ramp"]) < 0.2
    assert found.objective < 0.3 * drive.positioning_error(0.1, 0.1, 0.1, slide="moving").value
    assert found.status == "optimal"
    assert found.plot() is not None


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("damper", "speeds"), [("ground", (0.3, 0.9)), ("support", (1.25, 4.0))])
def test_a_range_of_speeds_has_its_worst_one(damper, speeds):
    given = slide(mu1=-0.3, mu2=0.1, sigma=0.4, damper=damper, epsilon=0.4)
    found = positioning(given, "ramp", (0.0, 12.0), speeds)
    ramp, sigma = found.values["ramp"], 0.4 if damper == "support" else 0.0
    errors = [
        abs(stopped(0.1, 0.5, drive.excess(0.1, 0.5, V, damper=damper, sigma=sigma), 0.4, V, ramp, V, sigma))
        for V in np.linspace(*speeds, 9)
    ]
    assert max(errors) == pytest.approx(found.objective, abs=1e-5)
    assert found.check.agrees, str(found.check)


def test_a_jump_of_the_error_is_an_infimum():
    found = positioning(slide(mu1=-0.05, mu2=0.8, epsilon=0.3), "ramp", (0.0, 20.0), (2.0, 2.0))
    assert found.status == "infimum"
    assert any("jumps" in a for a in found.active)


def test_what_cannot_be_asked():
    with pytest.raises(sf.NotFound, match="stick-slip before the stop, whatever the ramp: at V = 1.25"):
        positioning(slide(mu1=-0.5, mu2=0.1, epsilon=1.0), "ramp", (0.0, 5.0), (1.25, 5.0))
    with pytest.raises(sf.SceneError, match="lower bound of ramp is -1"):
        positioning(slide(), "ramp", (-1.0, 5.0), (0.5, 0.5))
    with pytest.raises(sf.SceneError, match="ramp is -1"):
        sf.scenes.drive_stop(mu1=0.1, mu2=0.1, lam=0.1, ramp=-1.0)
    with pytest.raises(sf.SceneError, match="give drive=, its speed over"):
        sf.scenes.drive_stop(mu1=0.1, mu2=0.1, lam=0.1, ramp=1.0)
