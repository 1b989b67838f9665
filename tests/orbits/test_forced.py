"""Bounds of self-excitation under fast excitation, from the full model: Thomsen, figure 9."""

import numpy as np
import pytest

import symfric as sf
from symfric.orbits.forced import forced_orbit, forced_program, self_excitation


def belt(Omega, **changes):
    return sf.scenes.mass_on_belt(**{"v_b": 0.3, "a": 0.01, "Omega": Omega, **changes})


@pytest.mark.parametrize(
    ("Omega", "bracket", "lower", "upper"),
    [(20, (0.15, 0.45), 0.20048269538877, 0.41754591255332), (30, (0.25, 0.45), 0.30032749601118, 0.38645224271385)],
)
def test_bounds_of_figure_9(Omega, bracket, lower, upper):
    found = self_excitation(belt(Omega), bracket)
    assert found.lower == pytest.approx(lower, rel=1e-9)
    assert found.upper == pytest.approx(upper, rel=1e-9)
    averaged = sf.theory.belt.unstable_speeds(belt(Omega))
    assert np.allclose([found.lower, found.upper], averaged, rtol=5e-3)  # (55) is the limit of fast excitation
    assert not np.allclose([found.lower, found.upper], averaged, rtol=1e-5)


def test_fast_enough_excitation_quenches():
    with pytest.raises(sf.NotFound, match="quenches"):
        self_excitation(belt(40), (0.35, 0.45))


def test_upper_bound_is_where_the_mean_square_closes():
    """On the orbit at the upper bound v_b^2 + <x'^2> = v_b1^2, which needs no derivative."""
    scene = belt(20)
    upper = self_excitation(scene, (0.15, 0.45)).upper
    program = forced_program(scene)
    start = forced_orbit(program, {"v_b": upper}, np.array([0.26, -0.2])).start
    u = scene.system.u[0]
    period = 2 * np.pi / 20
    square = scene.where({"v_b": upper}).starting(dict(zip(("x", "u"), start, strict=True))).until(period)
    mean = sf.simulate(square.wanting({"square": sf.Integral(u**2)}), 1e-13)["square"] / period
    assert upper**2 + mean == pytest.approx(sf.theory.belt.onset_speed(scene) ** 2, rel=1e-10)


@pytest.mark.parametrize(("v_b", "grows"), [(0.40, True), (0.43, False)])
def test_multipliers_tell_what_disturbances_do(v_b, grows):
    """A second method: follow a small disturbance over many periods."""
    scene = belt(20).where({"v_b": v_b})
    orbit = forced_orbit(forced_program(scene), {}, np.array([0.26, -0.2]))
    assert (orbit.decay < 0) is grows
    program = sf.prepare(scene.until(200 * 2 * np.pi / 20).wanting({"end": sf.End()}), 1e-13)
    rest = program.run(initial={"x": orbit.start[0], "u": orbit.start[1]}).final
    moved = program.run(initial={"x": orbit.start[0] + 1e-6, "u": orbit.start[1]}).final
    growth = np.linalg.norm(moved - rest) / 1e-6
    assert (growth > 1) == grows
    assert np.log(growth) == pytest.approx(-orbit.decay * 200 / 2, abs=0.1)  # half of it for each multiplier
