"""The reference of the planar tests, proved on motions with known answers, against regularised friction, and on lines."""

import math
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

import symfric as sf
from tests.longer import longer
from tests.plane.compiled_regularised import regularised as compiled
from tests.plane.plane_reference import Planar, Problem, Simulator, incline, least_use, polar_incline, regularised
from tests.plane.plane_scenes import before_a_fast_turn, drawn
from tests.reference_cases import values_of

SLOPE = math.radians(20)


# -- known motions


@pytest.mark.one_in(6)
@pytest.mark.parametrize("direction", [0.3, math.pi / 2, 3.0])
@pytest.mark.parametrize("k", [1.05, 1.5, 4.0])
def test_block_stops_on_an_incline(direction, k):
    mu = k * math.tan(SLOPE)
    rest = sf.theory.plane.incline_stop(SLOPE, mu, 1.0, direction)
    problem = incline(SLOPE, 1.1 * mu, mu, [math.cos(direction), math.sin(direction)], horizon=rest.time + 1)
    motion = Simulator(problem).run()
    assert motion.kinds() == [(0, "stick")]
    assert motion.events[0][0] == pytest.approx(rest.time, rel=1e-11)
    assert motion.final == pytest.approx([rest.downslope, rest.cross, 0, 0], abs=1e-11)


@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-6])
def test_block_turns_fast_on_an_incline_without_a_stop(delta):
    mu = 0.5 * math.tan(SLOPE)
    start = [-math.cos(delta), math.sin(delta)]
    end = sf.theory.plane.incline_motion(SLOPE, mu, 1.0, math.pi - delta, 0.2 * delta)
    motion = Simulator(incline(SLOPE, mu, mu, start, horizon=end.time)).run()
    assert motion.events == []
    expected = [end.downslope, end.cross, end.speed * math.cos(end.direction), end.speed * math.sin(end.direction)]
    assert motion.final == pytest.approx(expected, abs=1e-10)


@pytest.mark.long(beside="test_block_stops_on_an_incline")
def test_polar_taylor_series_of_the_incline():
    mu = 1.5 * math.tan(SLOPE)
    time, down, across = polar_incline(SLOPE, mu, 1.0, math.pi / 2, digits=20)
    rest = sf.theory.plane.incline_stop(SLOPE, mu, 1.0)
    assert float(time) == pytest.approx(rest.time, rel=1e-12)
    assert (float(down), float(across)) == pytest.approx((rest.downslope, rest.cross), rel=1e-12)


def test_coupled_springs_come_to_rest_where_known():
    K = np.array([[1.0, 0.3], [0.3, 2.5]])
    contact = Planar(np.eye(2), 1.0, 0.1, 0.1)
    start = np.array([1.0, 0.4, 0.3, -0.6])
    problem = Problem(lambda q: np.eye(2), lambda t, q, u: -K @ q, (contact,), start, 25.0)
    motion = Simulator(problem).run()
    assert (motion.events[-1][0], *motion.final[:2]) == pytest.approx(
        values_of("coupled_springs_planar_stop"), rel=1e-10
    )


def test_puck_crosses_a_conveyor():
    contact = Planar(np.eye(2), 9.81, 0.3, 0.3, lambda t: np.array([1.5, 0.0]))
    start = np.array([0.0, 0.0, 0.0, 1.2])
    motion = Simulator(Problem(lambda q: np.eye(2), lambda t, q, u: np.zeros(2), (contact,), start, 0.3)).run()
    leaves = brentq(lambda t: motion.at(t)[1] - 0.25, 0.1, 0.3, xtol=1e-15)
    x, _, vx, vy = motion.at(leaves)
    assert (leaves, x, vx, vy) == pytest.approx(values_of("puck_across_conveyor"), rel=1e-10)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("ratio", [1.0, 1.4])
def test_released_block_starts_along_the_force(ratio):
    # a force that turns and grows: where it leaves the disc the block starts in its direction
    contact = Planar(np.eye(2), 1.0, 0.3 * ratio, 0.3)

    def force(t, _q, _u):
        return 0.2 * t * np.array([math.cos(t), math.sin(t)])

    motion = Simulator(Problem(lambda q: np.eye(2), force, (contact,), np.zeros(4), 3.0)).run()
    assert motion.kinds() == [(0, "stick"), (0, "slip")]
    release = motion.events[1][0]
    assert release == pytest.approx(1.5 * ratio, rel=1e-10)
    u = motion.at(release + 2e-3)[2:]
    # angle' = F (turn of the force - angle)/v; v = (F - .3) time where the friction drops, of second order where not
    force_at = 0.2 * release
    share = force_at / (2 * force_at - 0.3)
    assert (math.atan2(u[1], u[0]) - release) / 2e-3 == pytest.approx(share, abs=2e-3)


# -- on a line it is the line contact of the package


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_stick_slip_on_a_line_is_that_of_a_line_contact(angle):
    x, u = sp.symbols("x u", real=True)
    system = sf.System([x], [u], [[1]], [-x - 0.05 * u])
    line = sf.Scene(system, [sf.Contact("belt", u - 0.3, 1, sf.laws.coulomb(0.5, 0.3))], {}, {x: 0.0, u: 0.0}, 15.0)
    run = sf.simulate(line, tolerance=1e-12).checked()
    e = np.array([math.cos(angle), math.sin(angle)])
    contact = Planar(np.eye(2), 1.0, 0.5, 0.3, lambda t: 0.3 * e)
    problem = Problem(lambda q: np.eye(2), lambda t, q, v: -q - 0.05 * v, (contact,), np.zeros(4), 15.0)
    motion = Simulator(problem).run()
    known = [(ev.t, ev.kind) for ev in run.events if ev.kind in ("stick", "slip")]
    found = [(t, kind) for t, _, kind in motion.events]
    assert [k for _, k in found] == [k for _, k in known]
    assert [t for t, _ in found] == pytest.approx([t for t, _ in known], abs=1e-8)
    assert motion.final == pytest.approx([*(e * run.final[0]), *(e * run.final[1])], abs=1e-8)


# -- against friction regularised at decreasing speed


@pytest.mark.long(beside="test_redundant_contacts_share_with_the_least_use")
def test_regularised_incline_creeps_with_the_speed_eps():
    mu = 1.5 * math.tan(SLOPE)
    rest = sf.theory.plane.incline_stop(SLOPE, mu, 1.0)
    problem = incline(SLOPE, mu, mu, [0.0, 1.0], horizon=rest.time + 1)
    errors = [
        np.max(np.abs(regularised(problem, eps)[:2] - [rest.downslope, rest.cross])) for eps in (1e-3, 1e-4, 1e-5)
    ]
    assert [a / b for a, b in zip(errors, errors[1:], strict=False)] == pytest.approx([10, 10], rel=0.1)


@pytest.mark.long(beside="test_random_scenes_are_the_limit_of_regularised_ones")
def test_shaken_incline_sticks_and_slips_like_the_regularised_one():
    mu = 1.5 * math.tan(SLOPE)
    problem = incline(SLOPE, 1.3 * mu, mu, [0.2, 0.3], horizon=3.0, shake=(0.2, 0.9), frequency=6.0)
    motion = Simulator(problem).run()
    assert {kind for _, kind in motion.kinds()} == {"stick", "slip"}
    errors = [np.max(np.abs(regularised(problem, eps, 1e-9)[:2] - motion.final[:2])) for eps in (1e-3, 1e-4)]
    assert errors[1] < 0.3 * errors[0] < 0.3 * 0.05


SEEDS = (1, 12)
MORE = tuple(s for s in range(40) if s not in SEEDS)


SPEEDS = (1e-3, 1e-4, 1e-5)


def check_trend(seed, approached, horizon=8.0):
    scene = replace(drawn(seed), horizon=horizon)
    motion = Simulator(scene.problem()).run()
    scene = replace(scene, horizon=before_a_fast_turn(scene, motion, SPEEDS[-1]))
    errors = [np.max(np.abs(approached(scene, eps) - motion.at(scene.horizon))) for eps in SPEEDS]
    assert scene.horizon > 2
    assert errors[2] < max(0.1 * errors[0], 1e-8), errors
    return motion


@pytest.mark.parametrize("seed", longer(SEEDS, [1]))
def test_random_scenes_are_the_limit_of_regularised_ones(seed):
    check_trend(seed, lambda scene, eps: regularised(scene.problem(), eps, 1e-9), 4.0)


@pytest.mark.long(beside="test_random_scenes_are_the_limit_of_regularised_ones")
@pytest.mark.parametrize("seed", MORE)
def test_more_random_scenes_are_the_limit_of_regularised_ones(seed):
    check_trend(seed, compiled)


@pytest.mark.long(beside="test_random_scenes_are_the_limit_of_regularised_ones")
@pytest.mark.parametrize("seed", [1, 3, 12])
def test_the_compiled_regularised_scenes_are_the_same(seed):
    scene = drawn(seed)
    for eps in (1e-2, 1e-3):
        assert compiled(scene, eps) == pytest.approx(regularised(scene.problem(), eps, 1e-9), abs=1e-8)


@pytest.mark.long(beside="test_random_scenes_are_the_limit_of_regularised_ones")
def test_a_looser_tolerance_gives_the_same_events():
    problem = drawn(10).problem()
    tight, loose = (Simulator(problem, tolerance).run() for tolerance in (1e-12, 1e-10))
    assert len(tight.events) > 2
    assert tight.kinds() == loose.kinds()
    assert tight.final == pytest.approx(loose.final, abs=1e-7)


# -- forces


def test_redundant_contacts_share_with_the_least_use():
    # three parallel contacts on one body: the same force bears on all discs, in proportion to their bounds
    G = np.kron(np.ones((3, 3)), np.eye(2))
    bounds = np.array([1.0, 2.0, 3.0])
    pulled = np.array([1.2, -1.6])
    forces, use = least_use(G, np.tile(pulled, 3), bounds)
    assert use == pytest.approx(2.0 / 6.0, rel=1e-6)
    assert forces.reshape(3, 2).sum(axis=0) == pytest.approx(pulled, abs=1e-12)
    assert forces.reshape(3, 2) == pytest.approx(bounds[:, None] * pulled / 6.0, abs=1e-3)


def test_a_body_on_two_feet_releases_at_the_sum_of_their_bounds():
    # one body on two tables with the same motion: each disc may carry its share
    feet = (Planar(np.eye(2), 1.0, 0.3, 0.3), Planar(np.eye(2), 2.0, 0.2, 0.2))
    pull = np.array([0.6, 0.8])
    problem = Problem(lambda q: np.eye(2), lambda t, q, u: t * pull, feet, np.zeros(4), 0.6)
    assert Simulator(problem).run().kinds() == [(0, "stick"), (1, "stick")]
    simulator = Simulator(problem)
    use = [simulator.accelerations(t, np.zeros(2), np.zeros(2), [0, 1], {})[2] for t in (0.35, 0.7)]
    assert use == pytest.approx([0.5, 1.0], rel=1e-6)


def test_scenes_are_the_same_for_every_call():
    for seed in range(3):
        a, b = drawn(seed), drawn(seed)
        assert np.array_equal(a.start, b.start)
        assert len(a.tables) == len(b.tables)
        assert np.linalg.eigvalsh(a.M).min() > 0.2 * np.linalg.eigvalsh(a.M).max() * a.swing
    sizes = {(len(drawn(s).tables), drawn(s).n) for s in range(60)}
    assert sizes >= {(1, 2), (1, 4), (2, 4), (1, 6), (2, 6), (3, 6)}
