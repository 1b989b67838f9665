"""The smallest damper against closed forms, grids of simulations, and the branches of the cycles."""

from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.design import damper
from symfric.scenefile import read_scene_file

ROOT = Path(__file__).parents[2]

BELT = sf.scenes.mass_on_belt(v_b=0.2)
STRIBECK = sf.scenes.mass_on_belt(sf.laws.exponential(0.4, 1.0), v_b=1.0)


def settled_size(scene, speed, beta):
    """Half range after a long time, from far out; by simulation alone."""
    far = scene.where({"v_b": speed, "beta": beta}).starting({"x": 8.0}).until(2000.0)
    end = sf.simulate(far.wanting({"end": sf.End()}), 1e-10).final
    late = far.starting(dict(zip(("x", "u"), end, strict=True))).until(30.0)
    run = sf.simulate(late.wanting({"size": sf.HalfRange(late.system.q[0])}), 1e-10)
    return run["size"]


def test_the_bound_of_the_source():
    """2 beta = eta, for belts however slow: Thomsen (19) at v_b = 0."""
    found = damper(BELT, "beta", (0.0, 1.0), (0.0, 0.5))
    eta = 1.5 * (0.4 - 0.25) / 0.5
    assert found.values["beta"] == pytest.approx(eta / 2, rel=1e-8)
    assert found.check.agrees
    assert "stability" in found.active[0]


@pytest.mark.long(beside="test_the_bound_of_the_source")
@pytest.mark.parametrize("low", [0.1, 0.2, 0.35])
def test_slow_belts_decide_with_the_cubic_law(low):
    found = damper(BELT, "beta", (0.0, 1.0), (low, 0.45))
    assert found.values["beta"] == pytest.approx(0.225 * (1 - (low / 0.5) ** 2), rel=1e-8)
    assert found.check.agrees
    assert found.scene.values[BELT.parameter("beta")] == found.values["beta"]
    assert found.objective == found.values["beta"]


@pytest.mark.long(beside="test_the_bound_of_the_source")
def test_a_law_with_its_steepest_fall_inside_the_range():
    """-mu' is largest between the ends: the speed that decides is a maximum, and no sample."""
    law = sf.laws.gauss(0.4, 0.3)
    scene = sf.scenes.mass_on_belt(law, v_b=0.2)
    found = damper(scene, "beta", (0.0, 2.0), (0.05, 0.6), sticking=True)
    steepest = 0.3 / np.sqrt(2)  # of exp(-(v/v_c)^2)
    slope = 0.4 * 2 * steepest / 0.09 * np.exp(-0.5)
    assert found.values["beta"] >= slope / 2 * (1 - 1e-9)
    assert found.check.agrees
    if "stability" in found.active[0]:
        assert found.values["beta"] == pytest.approx(slope / 2, rel=1e-8)


@pytest.mark.long(beside="test_a_limit_on_the_half_range_is_met_at_the_worst_speed")
def test_large_cycles_beside_stable_sliding_count():
    """Exponential law: sliding is stable above beta = .2 exp(-v), but the large cycle lasts longer."""
    found = damper(STRIBECK, "beta", (0.01, 1.0), (0.5, 3.0))
    assert found.values["beta"] > 0.2 * np.exp(-0.5) * 1.02
    assert "stick-onset" in found.active[0]
    branch = sf.continue_cycle(STRIBECK.where({"v_b": 0.5, "beta": 0.1}), "beta", (0.05, 0.2))
    fold = next(s for s in branch.special if s.kind == "stick-onset")
    assert found.values["beta"] == pytest.approx(fold.value, rel=1e-8)
    assert settled_size(STRIBECK, 0.5, 0.999 * found.values["beta"]) > 0.4
    assert settled_size(STRIBECK, 0.5, 1.01 * found.values["beta"]) < 1e-3
    assert found.check.agrees


@pytest.mark.parametrize(
    ("scene", "speeds", "limit"),
    [(BELT, (0.05, 0.45), 0.2), pytest.param(STRIBECK, (0.5, 3.0), 0.6, marks=pytest.mark.long)],
)
def test_a_limit_on_the_half_range_is_met_at_the_worst_speed(scene, speeds, limit):
    found = damper(scene, "beta", (0.01, 1.0), speeds, half_range=limit)
    beta = found.values["beta"]
    assert found.check.agrees
    sizes = [settled_size(scene, v, beta * 1.0005) for v in np.linspace(*speeds, 6)]
    assert max(sizes) <= limit * (1 + 1e-9)
    (worst,) = found.curve.marks
    assert settled_size(scene, worst, beta * 0.999) > limit
    orbit = sf.limit_cycle(found.scene.starting({"x": 8.0}).where({"beta": beta * (1 - 1e-9)}))
    assert orbit.half_range[0] == pytest.approx(limit, rel=1e-6)


def test_no_sticking():
    found = damper(BELT, "beta", (0.01, 1.0), (0.1, 0.45), sticking=False)
    assert found.check.agrees
    assert "stick-onset" in found.active[0]
    orbits = [
        sf.limit_cycle(BELT.where({"v_b": 0.1, "beta": share * found.values["beta"]}).starting({"x": 3.0}))
        for share in (0.9999, 1.0001)
    ]
    assert orbits[0].stick_fraction > 0 == orbits[1].stick_fraction


def test_bounds_that_are_too_low_or_already_enough():
    with pytest.raises(sf.NotFound, match=r"beta = 0.05 is not enough: at v_b = 0.5 small vibration still grows"):
        damper(STRIBECK, "beta", (0.01, 0.05), (0.5, 3.0))
    with pytest.raises(sf.NotFound, match="not enough: at v_b"):
        damper(STRIBECK, "beta", (0.01, 0.1217), (0.5, 3.0), half_range=0.1)
    found = damper(BELT, "beta", (0.3, 1.0), (0.1, 0.45))
    assert found.values["beta"] == 0.3
    assert found.active == ("beta at its lower bound",)
    assert found.check.agrees


def test_several_masses():
    """Two masses on a belt: the damper of the first alone, against a grid of eigenvalues and simulations."""
    x, u = sp.symbols("x1 x2", real=True), sp.symbols("u1 u2", real=True)
    v_b, c = sp.symbols("v_b c", positive=True)
    law = sf.laws.exponential(0.4, 1.0)
    force = [-2 * c * u[0] - x[0] + (x[1] - x[0]), -0.5 * u[1] - x[1] + (x[0] - x[1])]
    contact = sf.Contact("belt", slip=u[0] - v_b, normal=1, law=law)
    start = {**dict.fromkeys(x, 0.0), **dict.fromkeys(u, 0.0)}
    scene = sf.Scene(sf.System(x, u, sp.eye(2), force), [contact], {v_b: 1.0, c: 0.1}, start, 200.0)
    found = damper(scene, "c", (0.0, 1.0), (0.6, 2.0))
    assert found.check.agrees
    best = found.values["c"]
    rates = [sf.stability(scene.where({"v_b": v, "c": best * 1.0001})).margin for v in np.linspace(0.6, 2.0, 15)]
    assert min(rates) > 0


def test_errors():
    with pytest.raises(sf.SceneError, match="did you mean beta"):
        damper(BELT, "betta", (0.0, 1.0), (0.1, 0.4))
    with pytest.raises(sf.SceneError, match="give two numbers, bounds"):
        damper(BELT, "beta", 1.0, (0.1, 0.4))
    with pytest.raises(sf.SceneError, match="0 <= low <= high"):
        damper(BELT, "beta", (1.0, 0.5), (0.1, 0.4))
    with pytest.raises(sf.SceneError, match="both v_b"):
        damper(BELT, "v_b", (0.0, 1.0), (0.1, 0.4))


@pytest.mark.long(beside="test_the_bound_of_the_source")
def test_a_machine_slide_in_si_units():
    slide = read_scene_file(ROOT / "examples/machine_slide.toml").scene
    found = damper(slide, "c", (1e3, 4e4), (0.004, 0.02), speed="v_f")
    assert found.active == ("stick-onset of the cycle at v_f = 0.004",)
    assert found.check.agrees


def steep(mu, fall, speed):
    """A law that falls by `fall` within a small speed."""
    v = sf.SPEED
    return sf.laws.custom(mu + fall * sp.exp(-v / speed), mu + fall)


def stepped(mu, fall, at, width):
    """A law that falls by twice `fall` around a speed."""
    v = sf.SPEED
    return sf.laws.custom(mu - fall * sp.tanh((v - at) / width), mu + fall * float(np.tanh(at / width)))


@pytest.mark.long(beside="test_a_limit_on_the_half_range_is_met_at_the_worst_speed")
@pytest.mark.parametrize(
    ("law", "low", "limit"),
    [
        (steep(0.27, 0.16, 0.11), 0.05, 0.2),  # at slow belts the cycle is small before it ends
        (steep(0.31, 0.06, 0.036), 0.05, 0.05),
        (steep(0.21, 0.17, 0.063), 0.05, 0.1),
        (stepped(0.41, 0.054, 0.36, 0.024), 0.1, 0.05),
        (stepped(0.38, 0.036, 0.32, 0.18), 0.1, 0.05),
        (stepped(0.25, 0.072, 0.44, 0.053), 0.1, 0.05),
    ],
)
def test_limits_on_the_half_range_for_laws_that_fall_within_a_small_speed(law, low, limit):
    scene = sf.scenes.mass_on_belt(law, v_b=0.2)
    found = damper(scene, "beta", (0.0, 3.0), (low, 1.0), half_range=limit)
    assert found.status == "optimal", found.doubts
    beta, decides = found.values["beta"], found.scene.values[scene.parameter("v_b")]
    speeds = [*np.linspace(low, 1.0, 5), decides]
    assert max(settled_size(scene, v, 1.01 * beta) for v in speeds) <= limit
    assert settled_size(scene, decides, 0.99 * beta) > limit


@pytest.mark.long(beside="test_no_sticking")
@pytest.mark.parametrize(
    ("mu", "v_c", "low"),
    [
        (0.287, 0.186, 0.253),
        (0.263, 0.944, 0.353),
        (0.335, 0.182, 0.559),
    ],
)
def test_no_sticking_where_motions_from_far_out_hardly_settle(mu, v_c, low):
    """Without damping the friction far out is nothing, and motions there neither shrink nor stick."""
    scene = sf.scenes.mass_on_belt(sf.laws.exponential(mu, v_c), v_b=low)
    found = damper(scene, "beta", (0.0, 3.0), (low, 2 * low), sticking=False)
    assert found.status == "optimal", found.doubts
    assert found.active == (f"stick-onset of the cycle at v_b = {low:g}",)
    below = scene.where({"beta": 0.999 * found.values["beta"]}).starting({"x": 1.0})
    assert sf.limit_cycle(below).stick_fraction > 0
    for start in (8.0, 1.0):
        above = scene.where({"beta": 1.001 * found.values["beta"]}).starting({"x": start}).until(3000.0)
        events = sf.simulate(above.wanting({"events": sf.Events()})).events
        assert not [e for e in events if e.after == 0 and e.t > 1500]


@pytest.mark.parametrize(
    ("law", "low"),
    [
        (sf.laws.coulomb(0.43, 0.3), 1e-3),
        (sf.laws.coulomb(0.43, 0.3), 0.1),
        (sf.laws.gauss(0.3, 0.2, 0.4), 0.0),
    ],
)
@pytest.mark.long(beside="test_no_sticking")
def test_static_friction_above_the_kinetic(law, low):
    """The slower the belt, the more damping ends the cycle of stick and slip."""
    scene = sf.scenes.mass_on_belt(law, v_b=0.1)
    found = damper(scene, "beta", (0.0, 3.0), (low, 0.5))
    assert found.status == "optimal", found.doubts
    speed = found.scene.values[scene.parameter("v_b")]
    assert speed < 1.1 * max(low, 1e-4 * 0.5)
    for share, sticks in ((0.99, True), (1.01, False)):
        there = scene.where({"beta": share * found.values["beta"], "v_b": speed}).until(20 / speed)
        begin = {"x": 0.99 * float(law.stick), "u": speed}
        events = sf.simulate(there.starting(begin).wanting({"events": sf.Events()})).events
        assert bool([e for e in events if e.after == 0 and e.t > 5 / speed]) == sticks


@pytest.mark.long(beside="test_several_masses")
def test_the_check_starts_from_the_cycle_that_ends():
    """Of two masses: motions from far out miss a cycle that few starts lead to, and the check does not."""
    x, u = sp.symbols("x1 x2", real=True), sp.symbols("u1 u2", real=True)
    v_b, c = sp.symbols("v_b c", positive=True)
    force = [-2 * c * u[0] - 1.1 * x[0] + 0.9 * (x[1] - x[0]), -0.34 * u[1] - 1.5 * x[1] + 0.9 * (x[0] - x[1])]
    contact = sf.Contact("belt", slip=u[0] - v_b, normal=1, law=sf.laws.exponential(0.4, 0.5))
    start = {**dict.fromkeys(x, 0.0), **dict.fromkeys(u, 0.0)}
    scene = sf.Scene(sf.System(x, u, sp.diag(1, 2.7), force), [contact], {v_b: 0.5, c: 0.1}, start, 200.0)
    found = damper(scene, "c", (0.0, 3.0), (0.19, 1.08))
    assert found.status == "optimal", found.doubts
    assert found.check.below.half_range > 0
    probes = (found.check.above, found.check.below, *found.check.others)
    assert all(0.19 <= p.speed <= 1.08 for p in probes)
