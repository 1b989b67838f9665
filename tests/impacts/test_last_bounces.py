"""Integrals of forces over bounces that die out: the closed form of the ball, tight runs, horizons among the bounces.

A ball dropped from the height h rests after ``T = sqrt(2 h/g) (1 + e)/(1 - e)``, and until then its floor carries it in
impacts alone: the normal force is zero before T and g after.
"""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, Y, U, V = sp.symbols("x y u v", real=True)
E, G, MU, C = sp.symbols("e g mu c", positive=True)
N, F, S = sf.normal_force("floor"), sf.friction_force("floor"), sf.slip("floor")
END, FAST = 12.0, 60.0
OUTPUTS = {
    "normal": sf.Integral(N),
    "square": sf.Integral(N**2),
    "friction": sf.Integral(F),
    "work": sf.Integral(F * S),
    "mean": sf.Mean(N, after=1.5),
    "rms": sf.RMS(N),
    "stop": sf.StopTime(),
}


def thrown(e, end=END, drag=0.0, outputs=OUTPUTS, u=FAST):
    """Return a ball thrown along a floor; its drag, if small, only hides from the solver that flights are parabolas."""
    system = sf.System([X, Y], [U, V], sp.eye(2), [-C * U, -G - C * V - C * sp.sin(Y)])
    floor = sf.Contact("floor", U, sf.Unilateral(Y, restitution=E), sf.laws.coulomb(MU))
    values = {E: e, G: 9.81, MU: 0.3, C: max(drag, 1e-300)}
    return sf.Scene(system, [floor], values, {X: 0.0, Y: 1.0, U: u, V: 0.0}, end, outputs)


def rest(e, g=9.81, h=1.0):
    """Return the time T of rest."""
    return np.sqrt(2 * h / g) * (1 + e) / (1 - e)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("e", [0.01, 0.3, 0.6, 0.9])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-8, 1e-11])
def test_a_ball_without_drag(e, tolerance):
    run = sf.simulate(thrown(e), tolerance=tolerance)
    left, g = END - rest(e), 9.81
    u = FAST - 0.3 * g * rest(e)  # all impulses until then make up for the weight
    slips = min(left, u / (0.3 * g))
    assert run["normal"] == pytest.approx(g * left, rel=1e-12)
    assert run["square"] == pytest.approx(g**2 * left, rel=1e-12)
    assert run["friction"] == pytest.approx(-0.3 * g * slips, rel=1e-12)
    assert run["work"] == pytest.approx(-0.3 * g * (u * slips - 0.15 * g * slips**2), rel=1e-12)
    assert run["mean"] == pytest.approx(g * min(left, END - 1.5) / (END - 1.5), rel=1e-12)
    assert run["rms"] == pytest.approx(g * np.sqrt(left / END), rel=1e-12)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("e", [0.3, 0.6, 0.9])
def test_the_error_with_drag_is_that_of_the_motion(e):
    tight = sf.simulate(thrown(e, drag=0.05), tolerance=1e-14)
    for tolerance in (1e-5, 1e-8, 1e-11):
        run = sf.simulate(thrown(e, drag=0.05), tolerance=tolerance)
        for name in ("normal", "square", "friction", "work", "mean", "rms"):
            assert run[name] == pytest.approx(tight[name], rel=30 * tolerance + 1e-13), (name, tolerance)


@pytest.mark.long(beside="test_a_ball_without_drag")
@pytest.mark.parametrize("e", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-9])
def test_derivatives_of_a_ball(e, tolerance):
    outputs = {"normal": sf.Integral(N), "stop": sf.StopTime()}
    scene = thrown(e, outputs=outputs, u=0.0)
    run = sf.simulate(scene, tolerance=tolerance, sensitivities=["e", "g", "y"]).checked()
    at = rest(e)
    by = {"e": 2 * at / (1 - e**2), "g": -at / (2 * 9.81), "y": at / 2}
    assert run["stop"] == pytest.approx(at, rel=1e-12)
    for key, slope in by.items():
        assert run.output_sensitivities["stop"][key] == pytest.approx(slope, rel=1e-9), key
        weight = (END - at if key == "g" else 0.0) - 9.81 * slope
        assert run.output_sensitivities["normal"][key] == pytest.approx(weight, rel=1e-9), key


@pytest.mark.long(beside="test_derivatives_if_the_first_bounces_are_the_last")
@pytest.mark.parametrize("tolerance", [1e-6, pytest.param(1e-9, marks=pytest.mark.long)])
def test_derivatives_with_drag(tolerance):
    scene = thrown(0.6, drag=0.05)
    names = ("normal", "friction", "work", "mean")
    tight = sf.simulate(scene, tolerance=1e-13, sensitivities=["e", "c", "y"]).output_sensitivities
    found = sf.simulate(scene, tolerance=tolerance, sensitivities=["e", "c", "y"]).output_sensitivities
    for name in names:
        for key in ("e", "c", "y"):
            assert found[name][key] == pytest.approx(tight[name][key], rel=2000 * tolerance), (name, key)


@pytest.mark.parametrize("early", [1e-3, 1e-4])
def test_a_horizon_among_the_last_bounces(early):
    outputs = {"normal": sf.Integral(N), "stop": sf.StopTime(), "late": sf.Mean(N, after=rest(0.9) - 3 * early)}
    run = sf.simulate(thrown(0.9, rest(0.9) - early, 0.0, outputs), tolerance=1e-5)
    assert run["normal"] == pytest.approx(0.0, abs=1e-12)
    assert run["late"] == pytest.approx(0.0, abs=1e-9)
    assert np.isnan(run["stop"])
    later = sf.simulate(thrown(0.9, rest(0.9) + early, 0.0, outputs), tolerance=1e-5)
    assert later["normal"] == pytest.approx(9.81 * early, abs=1e-11)
    assert later["late"] == pytest.approx(9.81 / 4, abs=1e-9)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
def test_a_block_that_lands_on_two_feet(tolerance):
    # in impacts at their distance from the centre the feet do not feel each other
    gap = [sf.Unilateral(Y + sign * X, restitution=0.5) for sign in (-1, 1)]
    feet = [sf.Contact(name, None, normal) for name, normal in zip(("left", "right"), gap, strict=True)]
    system = sf.System([X, Y], [U, V], sp.eye(2), [0, -9.81 - 1e-300 * sp.sin(Y)])
    both = sf.Integral(sf.normal_force("left") + sf.normal_force("right"))
    scene = sf.Scene(system, feet, {}, {X: 0.0, Y: 1.0, U: 0.0, V: 0.0}, 4.0, {"both": both})
    assert sf.simulate(scene, tolerance=tolerance)["both"] == pytest.approx(9.81 * (4.0 - rest(0.5)), rel=1e-12)


def test_a_shaken_floor_and_many_cases():
    floor = sf.Unilateral(Y - sp.Rational(1, 50) * sp.sin(12 * sf.TIME), restitution=E)
    system = sf.System([Y], [V], [[1]], [-9.81])
    outputs = {"normal": sf.Integral(N), "square": sf.Integral(N**2)}
    scene = sf.Scene(system, [sf.Contact("floor", None, floor)], {E: 0.4}, {Y: 0.1, V: 0.0}, 2.0, outputs)
    values = np.linspace(0.1, 0.6, 7)
    batch = sf.prepare(scene, tolerance=1e-8).map({"e": values})
    tight = sf.prepare(scene, tolerance=1e-13)
    for k, e in enumerate(values):
        run = tight.run({"e": e})
        assert batch["normal"][k] == pytest.approx(run["normal"], rel=1e-6)
        assert batch["square"][k] == pytest.approx(run["square"], rel=1e-6)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("e", [1e-3, 0.02])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_derivatives_if_the_first_bounces_are_the_last(e, tolerance):
    run = sf.simulate(thrown(e, u=0.0), tolerance=tolerance, sensitivities=["e", "g", "y"]).checked()
    at = rest(e)
    for key, slope in {"e": 2 * at / (1 - e**2), "g": -at / (2 * 9.81), "y": at / 2}.items():
        assert run.output_sensitivities["stop"][key] == pytest.approx(slope, rel=1e-8), key
        weight = (END - at if key == "g" else 0.0) - 9.81 * slope
        assert run.output_sensitivities["normal"][key] == pytest.approx(weight, rel=1e-8), key
