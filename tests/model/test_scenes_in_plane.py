"""Ready scenes that slide in the plane, and outputs of the length of a vector."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

PAIR = (sf.motions.sine_burst(3.0, 0.5, cycles=5), sf.motions.sine_burst(2.0, 0.6, cycles=5))
X, Y = sp.symbols("x y", real=True)


def pendulum(**changes):
    return sf.scenes.friction_pendulum(**{"R": 2.0, "mu": 0.06, "m": 1e5, "motions": PAIR, **changes})


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("slope", "mu", "direction"), [(0.2, 0.5, 1.2), (0.4, 0.9, 3.0), (0.05, 0.1, 0.3)])
def test_a_block_stops_where_the_closed_form_says(slope, mu, direction):
    rest = sf.theory.plane.incline_stop(slope, mu, speed=1.3, direction=direction)
    block = sf.scenes.block_on_incline(slope=slope, mu=mu, speed=1.3, direction=direction)
    run = sf.simulate(block, tolerance=1e-13)
    assert (run["down"], run["across"]) == pytest.approx((rest.downslope, rest.cross), abs=1e-11)


@pytest.mark.long(beside="test_a_length_at_a_time_of_a_mass_that_starts_from_rest")
def test_a_shaken_block_creeps_and_one_at_rest_does_not():
    down = [
        sf.simulate(sf.scenes.block_on_incline(slope=0.2, mu=0.3, a=a, Omega=20.0))["down"] for a in (0.0, 1.0, 4.0)
    ]
    assert down[:2] == [0.0, 0.0]
    assert down[2] > 0.01


@pytest.mark.long(beside="test_a_length_at_a_time_of_a_mass_that_starts_from_rest")
def test_an_isolator_shaken_along_a_line_is_one_along_that_line():
    alone = sf.Signal(np.zeros(2), PAIR[0].dt)
    line = sf.simulate(pendulum(motions=(PAIR[0], alone)), tolerance=1e-12)
    assert line["residual_y"] == 0.0
    turned = [sf.Signal(c * PAIR[0].samples, PAIR[0].dt) for c in (0.6, 0.8)]
    both = sf.simulate(pendulum(motions=turned), tolerance=1e-12)
    for name in ("peak_displacement", "peak_velocity"):
        assert both[name] == pytest.approx(line[name], rel=1e-9)
    assert np.hypot(both["residual_x"], both["residual_y"]) == pytest.approx(abs(line["residual_x"]), abs=1e-9)


def test_two_directions_alone_miss_what_both_do_together():
    zero = sf.Signal(np.zeros(2), PAIR[0].dt)
    both = sf.simulate(pendulum())["peak_displacement"]
    single = [sf.simulate(pendulum(motions=m))["peak_displacement"] for m in ((PAIR[0], zero), (zero, PAIR[1]))]
    assert abs(both / np.hypot(*single) - 1) > 0.01


def test_the_largest_length_of_a_vector_is_that_of_its_path_with_derivatives():
    asked = {"size": sf.Max(sp.sqrt(X**2 + Y**2)), "path": sf.Trajectory()}
    scene = pendulum().wanting(asked)
    run = sf.simulate(scene, tolerance=1e-11)
    t = np.linspace(0, scene.horizon, 20001)
    path = run(t)
    length = np.hypot(path[0], path[1])
    assert run["size"] == pytest.approx(length.max(), rel=1e-5)
    assert run["size"] >= length.max() * (1 - 1e-9)


@pytest.mark.long(beside="test_a_block_stops_where_the_closed_form_says")
def test_the_derivative_of_a_length_is_that_of_the_closed_form():
    given = {"slope": 0.2, "mu": 0.5, "speed": 1.3, "direction": 1.2}
    asked = {"far": sf.Max(sp.sqrt(X**2 + Y**2)), "square": sf.Max(X**2 + Y**2), "down": sf.At(Y)}
    run = sf.prepare(sf.scenes.block_on_incline(**given).wanting(asked), 1e-12, sensitivities=["speed"]).run()
    slopes = {name: run.output_sensitivities[name]["speed"] for name in asked}
    assert slopes["far"] == pytest.approx(slopes["square"] / (2 * run["far"]), rel=1e-14)
    rest = sf.theory.plane.incline_stop(**given)  # all lengths go with the square of the speed
    assert slopes["down"] == pytest.approx(2 * rest.downslope / 1.3, rel=1e-9)
    # the largest length is at the stop, a flat extreme, whose instant is known to the root of rounding
    assert slopes["far"] == pytest.approx(2 * np.hypot(rest.downslope, rest.cross) / 1.3, rel=3e-7)


def test_a_length_at_a_time_of_a_mass_that_starts_from_rest():
    """The length has no series where it is zero, at the start; the square of it has one."""
    length = sp.sqrt(X**2 + Y**2)
    asked = {f"at {t}": sf.At(length, t) for t in (0.0, 0.5, 2.0)} | {"at end": sf.At(length)}
    asked |= {f"x {t}": sf.At(X, t) for t in (0.5, 2.0)} | {f"y {t}": sf.At(Y, t) for t in (0.5, 2.0)}
    program = sf.prepare(pendulum().wanting(asked), 1e-10)
    run = program.run().checked()
    assert run["at 0.0"] == 0.0
    for t in (0.5, 2.0):
        assert run[f"at {t}"] == pytest.approx(np.hypot(run[f"x {t}"], run[f"y {t}"]), rel=1e-12)
    assert program.map({"mu": [0.06, 0.1]})["at 2.0"][0] == pytest.approx(run["at 2.0"], rel=1e-12)


@pytest.mark.long(beside="test_a_length_at_a_time_of_a_mass_that_starts_from_rest")
def test_derivatives_of_a_length_at_a_time():
    asked = {"r": sf.At(sp.sqrt(X**2 + Y**2), 0.1), "square": sf.At(X**2 + Y**2, 0.1)}
    given = {"slope": 0.2, "mu": 0.5, "speed": 1.3, "direction": 1.2}
    scene = sf.scenes.block_on_incline(**given, horizon=0.15).wanting(asked)
    run = sf.prepare(scene, 1e-12, sensitivities=["speed", "direction"], order=2).run()
    first, second = run.output_sensitivities, run.second_output_sensitivities
    for name in ("speed", "direction"):
        assert first["r"][name] == pytest.approx(first["square"][name] / (2 * run["r"]), rel=1e-12)
    for (a, b), value in second["r"].items():
        product = first["r"][a] * first["r"][b]
        assert value == pytest.approx((second["square"][a, b] / 2 - product) / run["r"], rel=1e-9)


@pytest.mark.long(beside="test_the_largest_length_of_a_vector_is_that_of_its_path_with_derivatives")
def test_lengths_in_maps_and_half_ranges():
    scene = pendulum().wanting({"a": sf.Max(sp.sqrt(X**2 + Y**2)), "b": sf.HalfRange(sp.sqrt(X**2 + Y**2))})
    many = sf.prepare(scene).map({"mu": [0.04, 0.06, 0.1]})
    assert many["a"][1] == pytest.approx(sf.simulate(scene)["a"], rel=1e-12)
    assert many["b"] == pytest.approx(many["a"] / 2, rel=1e-6)  # from rest
    assert np.all(np.diff(many["a"]) < 0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: pendulum(motions=PAIR[:1]), "no pair"),
        (lambda: pendulum(motions=PAIR[0]), "no pair"),
        (lambda: pendulum(R=0.0), "R is 0"),
        (lambda: pendulum(mu=-0.1), "mu is -0.1"),
        (lambda: sf.scenes.block_on_incline(slope=2.0, mu=0.3), "below pi/2"),
        (lambda: sf.scenes.block_on_incline(slope=0.2, mu=-1), "must not be negative"),
    ],
)
def test_wrong_numbers_are_named(make, words):
    with pytest.raises(sf.SceneError, match=words):
        make()
