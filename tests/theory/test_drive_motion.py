"""Closed forms of drawn slides against the event-driven solver, which knows nothing of them."""

import math

import numpy as np
import pytest

import symfric as sf
from symfric.theory import drive

MAPS = [
    (-0.1, 0.5, -0.1, 6.3940747605571819),
    (-0.3, 0.3, -0.2, 1.8590993575312826),
    (-0.6, 0.2, -0.5, 1.8350164158298183),
    (-0.9, 0.5, -0.4, 7.5763089731579039),
]
STOPS = [
    (-0.1, 0.5, 0.5, "a", 1.1856381703605572),
    (-0.5, 1.5, 2.0, "b", 3.9314073871663000),
    (-0.5, 0.8, 4.0, "c", 6.2873911205662231),
    (-1.5, 2.0, 5.0, "b", 8.7229673927621434),
]


@pytest.fixture(scope="module")
def drawn():
    """Count the events of a drawn slide over 150 units of time: 1, the first release, if it does not stick again."""
    scene = sf.scenes.drive_slide(mu1=-0.1, mu2=0.5, p_star=-0.1, epsilon=1.0, horizon=150.0)
    program = sf.prepare(scene.wanting({"end": sf.End()}), 1e-13)

    def events(mu1, mu2, p_star, epsilon, fc=2.0):
        values = {"mu1": mu1, "mu2": mu2, "p_star": p_star, "epsilon": epsilon, "fc": fc}
        nearly = 1 - (fc + epsilon) * (1 + p_star)  # the spring, one unit of time before the slide breaks loose
        return program.run(values, {"x": nearly}).checked().stats["events"]

    return events


@pytest.fixture(scope="module")
def stopped():
    """The run of a slide whose drive has stopped."""
    scene = sf.scenes.drive_stop(mu1=-0.1, mu2=0.5, lam=0.5, horizon=120.0)
    program = sf.prepare(scene, 1e-13)

    def run(mu1, mu2, lam, epsilon=0.0, speed=0.0, fc=5.0):
        values = {"mu1": mu1, "mu2": mu2, "lam": lam, "epsilon": epsilon, "speed": speed, "fc": fc}
        return program.run(values).checked()

    return run


@pytest.mark.parametrize("case", MAPS)
def test_thresholds_by_simulation_alone(drawn, case):
    *slopes, known = case
    low, high = 0.3 * known, 3.0 * known
    while high - low > 1e-11 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if drawn(*slopes, middle) > 1 else (middle, high)
    assert high == pytest.approx(known, rel=3e-11)
    assert drive.threshold(*slopes) == pytest.approx(high, rel=3e-11)


@pytest.mark.parametrize("case", MAPS)
@pytest.mark.parametrize("fc", [1.9, 30.0])
def test_a_billionth_beside_the_threshold_the_slide_decays_or_cycles(drawn, case, fc):
    critical = drive.threshold(*case[:3])
    assert drawn(*case[:3], critical * (1 - 1e-9), fc) == 1
    assert drawn(*case[:3], critical * (1 + 1e-9), fc) >= 5


def test_a_steep_second_section_needs_more_and_more(drawn):
    near = [drive.threshold(-0.3, mu2, -0.2) for mu2 in (0.9, 0.97, 0.98)]
    assert np.all(np.diff(np.log10(near)) > 1)
    assert drive.threshold(-0.3, 0.99, -0.2) > 1e9
    assert drawn(-0.3, 0.9, -0.2, near[0] * (1 - 1e-9)) == 1 < drawn(-0.3, 0.9, -0.2, near[0] * (1 + 1e-9))
    assert drive.threshold(-0.3, 1.0, -0.2) == math.inf
    assert drawn(-0.3, 1.0, -0.2, 30.0) == 1


@pytest.mark.parametrize("case", [(-1.0, 0.5, -0.1), (-0.5, 0.1, -0.1)])
def test_any_difference_of_friction_will_do_where_the_orbit_turns_back(drawn, case):
    assert drive.threshold(*case) == 0
    assert drawn(*case, 1e-6) >= 5


def test_a_corner_next_to_the_speed_of_the_drive(drawn):
    critical = drive.threshold(-0.3, 0.5, -1e-7)
    assert drawn(-0.3, 0.5, -1e-7, critical * (1 - 1e-8)) == 1
    assert drawn(-0.3, 0.5, -1e-7, critical * (1 + 1e-8)) >= 5


def test_the_threshold_in_both_scalings():
    for mu1, mu2, p_star, known in MAPS:
        assert drive.threshold(mu1, mu2, p_star, scaling="v*") == drive.threshold(mu1, mu2, p_star)
        assert drive.threshold(mu1, mu2, p_star, scaling="v") == pytest.approx(known * (1 + p_star), rel=1e-14)
    with pytest.raises(sf.SceneError, match="scaling is 'w'"):
        drive.threshold(-0.1, 0.5, -0.1, scaling="w")


@pytest.mark.parametrize(("mu1", "mu2", "lam", "kind", "known"), STOPS)
def test_positioning_errors_by_simulation(stopped, mu1, mu2, lam, kind, known):
    assert stopped(mu1, mu2, lam)["error"] == pytest.approx(known, rel=1e-12)
    found = drive.positioning_error(mu1, mu2, lam)
    assert found.value == pytest.approx(known, rel=1e-14)
    assert found.type == kind


@pytest.mark.parametrize(
    ("mu1", "mu2", "lam"), [(-1.0, 1.0, 3.0), (-1.0, 0.7, 0.1), (0.4, 0.2, 3.0), (-0.5, 1.0, 2.0), (-0.7, 12.0, 30.0)]
)
def test_errors_at_critical_damping_and_on_a_steep_section(stopped, mu1, mu2, lam):
    assert stopped(mu1, mu2, lam, fc=40.0)["error"] == pytest.approx(
        drive.positioning_error(mu1, mu2, lam).value, rel=1e-11
    )


def test_no_error_while_the_static_friction_holds(stopped):
    for lam, epsilon in ((4.0, 4.0), (-1.0, 0.0), (0.5, 2.0)):
        run = stopped(-0.5, 0.8, lam, epsilon)
        assert run["error"] == pytest.approx(0.0, abs=1e-15)
        assert run["stop_time"] == 0.0
        assert drive.positioning_error(-0.5, 0.8, lam, epsilon=epsilon) == drive.PositioningError(0.0, "none")
    beyond = stopped(-0.5, 0.8, 4.0, 4.0 * (1 - 1e-9))
    assert beyond["error"] == pytest.approx(drive.positioning_error(-0.5, 0.8, 4.0, epsilon=3.99).value, rel=1e-11)


@pytest.mark.parametrize(("damper", "sigma"), [("ground", 0.0), ("ground", 0.3), ("support", 0.3)])
def test_a_slide_that_still_moves_when_the_drive_stops(stopped, damper, sigma):
    speed = 3.0
    lam = drive.excess(-0.5, 0.8, speed, damper=damper, sigma=sigma)
    known = drive.positioning_error(-0.5, 0.8, lam, slide="moving", damper=damper, sigma=sigma)
    assert stopped(-0.5, 0.8, lam, speed=speed)["error"] == pytest.approx(known.value, rel=1e-11)
    at_rest = drive.positioning_error(-0.5, 0.8, lam)
    assert stopped(-0.5, 0.8, lam)["error"] == pytest.approx(at_rest.value, rel=1e-11)
    assert known.value > at_rest.value
