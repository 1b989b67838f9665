"""Friction that differs along the two slips of a contact in the plane: an ellipse of forces, sliding normal to it."""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf
from symfric.report.study.page import page
from symfric.report.study.study import study
from symfric.scenefile import read_scene_text

x, y, u, w = sp.symbols("x y u w", real=True)
ASKED = {
    "f0": sf.At(sf.friction_force("table", 0)),
    "f1": sf.At(sf.friction_force("table", 1)),
    "v": sf.At(sf.slip("table")),
}


def block(force, start, horizon, ellipse, *, law=None, slip=(u, w), values=None, outputs=None):
    law = sf.laws.coulomb(0.4, 0.3) if law is None else law
    table = sf.Contact("table", slip=slip, normal=1, law=law, ellipse=ellipse)
    system = sf.System([x, y], [u, w], sp.eye(2), force)
    return sf.Scene(
        system,
        [table],
        values or {},
        dict(zip((x, y, u, w), start, strict=True)),
        horizon,
        outputs={"events": sf.Events(), **(outputs or {})},
    )


@pytest.mark.one_in(6)
@pytest.mark.parametrize("angle", [0.3, 1.2, 2.5])
@pytest.mark.parametrize("ellipse", [(1, 0.5), (0.7, 1.6)])
def test_a_block_holds_up_to_the_ellipse_and_slips_along_its_normal(angle, ellipse):
    """Released by a force that grows in a fixed direction, it starts along the force plus that of kinetic friction."""
    c, s = math.cos(angle), math.sin(angle)
    scene = block(
        [sf.TIME * c, sf.TIME * s],
        [0, 0, 0, 0],
        2.0,
        ellipse,
        outputs={"path": sf.Trajectory()},
        law=sf.laws.coulomb(0.4),
    )
    run = sf.simulate(scene, tolerance=1e-12).checked()
    release = 0.4 / math.hypot(c / ellipse[0], s / ellipse[1])
    (event,) = run.events
    assert (event.kind, event.t) == ("slip", pytest.approx(release, abs=1e-12))
    # the motion starts as t^2: where the force leaves the ellipse, the slip is normal to it
    start = run(release + 1e-4)[2:]
    normal = np.array([c / ellipse[0] ** 2, s / ellipse[1] ** 2])
    assert math.atan2(start[1], start[0]) == pytest.approx(math.atan2(normal[1], normal[0]), abs=1e-3)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("ellipse", [(1, 0.5), (0.7, 1.6)])
def test_a_free_block_stops_along_the_invariant_of_the_ellipse(ellipse):
    """With u' = -N mu a^2 u/s, w' = -N mu b^2 w/s the ratio |u|^(b^2)/|w|^(a^2) is kept; the time is a quadrature."""
    a, b = ellipse
    speeds = np.array([1.0, 0.8])
    run = sf.simulate(
        block([0, 0], [0, 0, *speeds], 30.0, ellipse, outputs={"path": sf.Trajectory()}), tolerance=1e-12
    ).checked()
    early = run(0.5)[2:]
    kept = [b**2 * math.log(v[0]) - a**2 * math.log(v[1]) for v in (speeds, early)]
    assert kept[0] == pytest.approx(kept[1], abs=1e-11)
    # sigma = int dt/s falls u as exp(-mu a^2 sigma): t = int s d sigma, x = int s u d sigma

    def rates(sigma, _):
        v = speeds * np.exp(-0.3 * np.array([a**2, b**2]) * sigma)
        s = math.hypot(*(np.array(ellipse) * v))
        return [s, *(s * v)]

    exact = solve_ivp(rates, (0, 150 / min(a, b) ** 2), [0.0, 0.0, 0.0], "DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    (event,) = run.events
    assert (event.kind, event.t, *run.final[:2]) == ("stick", *(pytest.approx(e, abs=1e-10) for e in exact))
    assert run.energy_residual() < 1e-10


LAWS = {"constant": sf.laws.coulomb(0.3), "Stribeck": sf.laws.stribeck(0.4, 0.25, 0.2)}


def by_hand(scene_force, start, horizon, ellipse, mu, stick, eps):
    """Return the final state with friction that rises over the scaled speed eps."""
    e = np.array(ellipse)

    def rates(t, state):
        v, s = state[2:], math.hypot(*(e * state[2:]))
        size = mu(math.hypot(*v)) / math.hypot(s, eps)
        return [*v, *(scene_force(t, state) - e**2 * v * size)]

    return solve_ivp(rates, (0, horizon), start, "Radau", rtol=1e-10, atol=1e-10 * eps).y[:, -1]


@pytest.mark.long(beside="test_a_block_holds_up_to_the_ellipse_and_slips_along_its_normal")
@pytest.mark.parametrize("law", LAWS)
def test_stops_sticks_and_releases_are_the_limit_of_regularised_friction(law):
    ellipse, start = (1.3, 0.6), [0.2, -0.1, 0.5, 0.9]
    t = sf.TIME
    force = [0.43 * sp.cos(1.7 * t) - 0.02 * x, 0.08 * sp.sin(1.1 * t) - 0.02 * y + 0.01 * x]
    chosen = LAWS[law] if law == "constant" else sf.laws.custom(0.3 + 0.2 * sf.SPEED / (1 + sf.SPEED), mu_s=0.3)
    mu = (lambda v: 0.3) if law == "constant" else (lambda v: 0.3 + 0.2 * v / (1 + v))
    run = sf.simulate(block(force, start, 7.5, ellipse, law=chosen), tolerance=1e-11).checked()
    assert {e.kind for e in run.events} == {"stick", "slip"}

    def applied(t, s):
        return np.array([0.43 * math.cos(1.7 * t) - 0.02 * s[0], 0.08 * math.sin(1.1 * t) - 0.02 * s[1] + 0.01 * s[0]])

    apart = [np.max(np.abs(by_hand(applied, start, 7.5, ellipse, mu, 0.3, eps) - run.final)) for eps in (5e-3, 5e-4)]
    assert 4 * apart[1] < apart[0] < 2e-2
    assert run.energy_residual() < 1e-9


@pytest.mark.long(beside="test_a_free_block_stops_along_the_invariant_of_the_ellipse")
@pytest.mark.parametrize("law", LAWS)
def test_equal_factors_are_a_factor_of_the_coefficient(law):
    force, start = [0.3 * sp.cos(sf.TIME), 0.2], [0, 0, 0.7, -0.4]
    one = sf.simulate(block(force, start, 6.0, (1.5, 1.5), law=LAWS[law]), tolerance=1e-12).checked()
    table = sf.Contact("table", slip=(u, w), normal=1.5, law=LAWS[law])
    system = sf.System([x, y], [u, w], sp.eye(2), force)
    other = sf.simulate(
        sf.Scene(system, [table], {}, dict(zip((x, y, u, w), start, strict=True)), 6.0), tolerance=1e-12
    )
    assert one.final == pytest.approx(other.checked().final, abs=1e-11)
    assert [e.t for e in one.events] == pytest.approx([e.t for e in other.events], abs=1e-10)


def test_outputs_are_those_of_the_slip_and_the_force_themselves():
    run = sf.simulate(block([0, 0], [0, 0, 0.6, 0.8], 0.5, (1, 0.5), law=sf.laws.coulomb(0.3), outputs=ASKED)).checked()
    v = run.final[2:]
    s = math.hypot(v[0], 0.5 * v[1])
    assert (run["f0"], run["f1"]) == pytest.approx((-0.3 * v[0] / s, -0.3 * 0.25 * v[1] / s), rel=1e-10)
    assert run["v"] == pytest.approx(math.hypot(*v), rel=1e-12)


@pytest.mark.long(beside="test_a_free_block_stops_along_the_invariant_of_the_ellipse")
def test_derivatives_by_a_factor():
    k = sp.Symbol("k", positive=True)
    scene = block([0, 0], [0, 0, 1.0, 0.8], 10.0, (1, k), values={k: 0.5}, outputs={"x": sf.At(x), "y": sf.At(y)})
    slopes = sf.prepare(scene, 1e-12, sensitivities=["k"]).run().output_sensitivities
    for name in ("x", "y"):
        ends = [sf.simulate(scene.where({"k": 0.5 + h}), tolerance=1e-12)[name] for h in (-1e-4, 1e-4)]
        assert slopes[name]["k"] == pytest.approx((ends[1] - ends[0]) / 2e-4, rel=1e-6)


def test_damping_across_steady_sliding():
    """Steady sliding along the first slip at the speed v meets the damper N mu e_1^2/(e_0 v) across it."""
    v = 0.7
    system = sf.System([x, y], [u, w], sp.eye(2), [-x, -4 * y])
    table = sf.Contact("table", slip=(u - v, w), normal=1, law=sf.laws.coulomb(0.3), ellipse=(0.8, 0.5))
    scene = sf.Scene(system, [table], {}, dict.fromkeys((x, y, u, w), 0.0), 10.0)
    assert sf.equilibrium(scene).sliding["table"] == pytest.approx(v)
    across = max(sf.stability(scene).eigenvalues, key=lambda e: abs(e.real))
    assert -2 * across.real == pytest.approx(0.3 * 0.25 / (0.8 * v), rel=1e-9)


SLED = """
[scene]
coordinates = ["x", "y"]
velocities = ["u", "w"]
mass = [1, 1]
force = [0, 0]
initial = { x = 0, y = 0, u = 1, w = 0.8 }
horizon = 3
[values]
k = 0.5
[friction]
law = "coulomb"
mu_s = 0.4
mu_k = 0.3
slip = ["u", "w"]
normal = 1
ellipse = [1, "k"]
"""


def test_a_scene_file_gives_the_ellipse():
    own = sf.simulate(block([0, 0], [0, 0, 1, 0.8], 3.0, (1, 0.5))).checked()
    assert sf.simulate(read_scene_text(SLED).scene).checked().final == pytest.approx(own.final, abs=1e-8)


@pytest.mark.long(beside="test_a_scene_file_gives_the_ellipse")
def test_the_page_of_a_scene_file_shows_the_ellipse():
    assert "<mi>k</mi>" in page(study(read_scene_text(SLED))).split('aria-label="friction of contact')[1][:3000]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("ellipse = [1]", "friction.ellipse is [1]; write two factors"),
        ("ellipse = 2", "friction.ellipse is 2; write two factors"),
        ("ellipse = [1, -1]", "ellipse of contact 'contact' has the factor -1"),
        ('ellipse = [1, "x"]', "contains x; its factors may depend on parameters only"),
    ],
)
def test_a_bad_ellipse_of_a_file_is_named(change, words):
    with pytest.raises(sf.SceneError) as error:
        read_scene_text(SLED.replace('ellipse = [1, "k"]', change))
    assert words in str(error.value)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"slip": u, "ellipse": (1, 2)}, "give a pair of slips"),
        ({"ellipse": (1, 2, 3)}, "give two factors"),
        ({"ellipse": (1, 0)}, "has the factor 0; both must be positive"),
    ],
)
def test_a_bad_ellipse_is_named(given, words):
    with pytest.raises(sf.SceneError, match=words):
        sf.Contact("table", **{"slip": (u, w), "normal": 1, "law": sf.laws.coulomb(0.3), **given})
