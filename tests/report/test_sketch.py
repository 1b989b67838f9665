"""The sketch of a system: what its equations say, legible at the width of a narrow screen."""

from pathlib import Path

import pytest
import sympy as sp

import symfric as sf
from symfric.report.study.drawing.diagram import GROUND, diagram_of
from symfric.report.study.drawing.labels import SCALE, WIDTH
from symfric.report.study.drawing.sketch import in_words, picture, plot_system
from symfric.scenefile import read_scene_file

EXAMPLES = Path(__file__).parents[2] / "examples"
COULOMB = sf.laws.coulomb(0.3)
NARROW = 368  # pixels of a figure on a screen of 400
READY = {
    "impact_oscillator": lambda: sf.scenes.impact_oscillator(e=0.7, zeta=0.05, Omega=2.2),
    "cam_follower": lambda: sf.scenes.cam_follower(m=0.5, k=400.0, preload=0.02, h=0.01, Omega=56.0),
    "vibratory_conveyor": lambda: sf.scenes.vibratory_conveyor(mu=0.4, a=0.002, Omega=60.0, beta=0.5),
    "rocking_block": lambda: sf.scenes.rocking_block(R=1.0, alpha=0.25, theta0=0.1),
    "brake_pad": lambda: sf.scenes.brake_pad(v_b=0.2),
    "mass_with_stops": lambda: sf.scenes.mass_with_stops(),
    "mass_on_belt": lambda: sf.scenes.mass_on_belt(v_b=0.2, a=0.01, Omega=50.0),
    "wavy_belt": lambda: sf.scenes.wavy_belt(v_b=0.2, F=0.1, k=3.0),
    "coulomb_oscillator": lambda: sf.scenes.coulomb_oscillator(0.1),
    "contact_damper": lambda: sf.scenes.contact_damper(f_n=10, mu_m=0.1, zeta=0.01),
    "drive_slide": lambda: sf.scenes.drive_slide(mu1=-0.5, mu2=0.8, p_star=2.0, epsilon=0.1),
    "drive_stop": lambda: sf.scenes.drive_stop(mu1=-0.5, mu2=0.8, lam=4.0),
    "two_slides": lambda: sf.scenes.two_slides(r=0.5, zeta=2, s1=0.2, s2=0.3, fc1=5.0, fs1=7.8),
    "rolling_isolator": lambda: sf.scenes.rolling_isolator(
        C=1.0, m=1.0, motion=sf.motions.sine_burst(1.0, 2.0), profile=(0.02, 0.3)
    ),
    "block_on_incline": lambda: sf.scenes.block_on_incline(slope=0.2, mu=0.3, a=3.0, Omega=20.0),
    "friction_pendulum": lambda: sf.scenes.friction_pendulum(
        R=2.0, mu=0.06, m=1.0, motions=(sf.motions.sine_burst(1.0, 2.0), sf.motions.sine_burst(1.0, 3.0))
    ),
    "positioning_stage": lambda: sf.scenes.positioning_stage(k_p=1.0, k_d=0.2, k_i=0.1, compensation=0.1),
    "absorber": lambda: sf.scenes.absorber(
        mass_ratio=0.1, tuning=0.9, damping=0.1, main_damping=0.02, friction=0.1, contact="absorber"
    ),
    "sprung_foundation": lambda: sf.scenes.sprung_foundation(
        sf.laws.cubic(0.4, 0.25, 0.5), mass_ratio=0.2, stiffness=0.3, damping=0.1, v_b=0.3
    ),
}


def chain(n: int, contacts: int = 1) -> sf.Scene:
    """Return bodies in a row, each on a damper of its own, the first ones on belts."""
    q, u = sp.symbols(f"x1:{n + 1}", real=True), sp.symbols(f"u1:{n + 1}", real=True)
    k, m, v = sp.symbols(f"k1:{n + 1}", positive=True), sp.symbols(f"m1:{n + 1}", positive=True), sp.Symbol("v_b")
    springs = sum(e * (a - b) ** 2 / 2 for e, a, b in zip(k, q, (0, *q), strict=False))
    force = [-sp.diff(springs, a) - w / 10 for a, w in zip(q, u, strict=True)]
    force[-1] += sp.Symbol("F") * sp.cos(sp.Symbol("Omega") * sf.TIME)
    rubs = [sf.Contact(f"belt {i}{'abc'[j]}", u[i] - v, m[i], COULOMB) for i in range(0, n, 2) for j in range(contacts)]
    numbers = dict.fromkeys((*k, *m), 1.0) | {"v_b": 0.2, "F": 1.0, "Omega": 2.0}
    return sf.Scene(sf.System(q, u, sp.diag(*m), force), rubs, numbers, dict.fromkeys((*q, *u), 0.0), 10.0)


def tangled() -> sf.Scene:
    """Return a ring of four, with a contact between two, one behind a spring, coupled inertia and long names."""
    q, u = sp.symbols("x1:5", real=True), sp.symbols("u1:5", real=True)
    k, stiffness = sp.Symbol("stiffness_of_the_ring", positive=True), sp.Symbol("k_t", positive=True)
    ring = sum(k * (q[i] - q[(i + 1) % 4]) ** 2 / 2 for i in range(4)) + q[1] ** 4
    rubs = [
        sf.Contact("between them", u[0] - u[1], 1, COULOMB),
        sf.Contact("the guide of the carriage on the left", u[2], 1 + sf.scenes.mass_on_belt(v_b=1).horizon, COULOMB),
        sf.Contact("behind a spring", u[3] - sp.sin(sf.TIME), 5, COULOMB, stiffness=stiffness),
    ]
    mass = sp.eye(4)
    mass[0, 1] = mass[1, 0] = sp.Rational(1, 10)
    force = [-sp.diff(ring, a) for a in q]
    return sf.Scene(sf.System(q, u, mass, force), rubs, {k: 1, stiffness: 9}, dict.fromkeys((*q, *u), 0.0), 10.0)


OTHERS = {f"chain of {n}": lambda n=n: chain(n) for n in range(1, 9)}
OTHERS |= {"two contacts each": lambda: chain(3, 2), "three contacts": lambda: chain(1, 3), "tangled": tangled}
FILES = {
    f.stem: lambda f=f: read_scene_file(f).scene
    for f in sorted(EXAMPLES.glob("*.toml"))
    if "\nstructure" not in f.read_text()  # drawn as a mesh
}
ALL = {**READY, **FILES, **OTHERS}


def test_every_ready_scene_is_drawn_here():
    ready = {n for n in dir(sf.scenes) if not n.startswith("_") and callable(getattr(sf.scenes, n))}
    assert ready == set(READY)


@pytest.mark.one_in(18)
@pytest.mark.parametrize("name", ALL)
def test_a_sketch_is_legible_and_no_label_lies_on_another(name):
    ax = plot_system(diagram_of(ALL[name]()))
    figure = ax.figure
    figure.draw_without_rendering()
    shown = [t for t in ax.texts if t.get_text()]
    assert shown
    boxes = [t.get_window_extent().padded(-0.5) for t in shown]
    for k, (text, box) in enumerate(zip(shown, boxes, strict=True)):
        assert figure.bbox.x0 <= box.x0, text
        assert box.x1 <= figure.bbox.x1, text
        assert figure.bbox.y0 <= box.y0, text
        assert box.y1 <= figure.bbox.y1, text
        for other, there in zip(shown[:k], boxes, strict=False):
            assert not box.overlaps(there), (text, other)
    smallest = min(t.get_fontsize() for t in shown) / 72 / (SCALE * WIDTH) * NARROW
    assert smallest > 7.5  # pixels


def test_two_masses_are_read_from_their_equations():
    found = diagram_of(read_scene_file(EXAMPLES / "two_masses.toml").scene)
    links = {(x.kind, x.first, x.second): str(x.size) for x in found.links}
    assert links == {
        ("stiffness", 0, 1): "k2",
        ("stiffness", 0, GROUND): "k1",
        ("damping", 0, 1): "c",
        ("damping", 0, GROUND): "c",
    }
    assert [(s.body, s.name, str(s.velocity)) for s in found.surfaces] == [(0, "first", "v_b"), (1, "second", "v_b")]
    assert [str(b.mass) for b in found.bodies] == ["m1", "m2"]
    assert not found.loads


def test_a_contact_of_two_bodies_and_its_drive():
    found = diagram_of(READY["two_slides"]())
    (rub,) = [x for x in found.links if x.kind == "friction"]
    assert (rub.first, rub.second, rub.name, rub.size) == (0, 1, "slides", 1)
    assert not found.surfaces


def test_what_vanishes_with_the_values_is_said():
    still, shaken = (diagram_of(sf.scenes.mass_on_belt(v_b=0.2, a=a, Omega=50.0)) for a in (0.0, 0.1))
    assert [e.absent for e in (*still.loads, *shaken.loads)] == [True, False]
    words = [t.get_text() for t in plot_system(still).texts]
    assert "grey: zero with the values of the scene" in words


def test_forces_without_reaction_are_no_springs():
    x, y, u, w = sp.symbols("x y u w", real=True)
    system = sf.System([x, y], [u, w], sp.eye(2), [-2 * x + 0.5 * y, -3 * y - 0.5 * x])
    found = diagram_of(sf.Scene(system, [], {}, {x: 1, y: 0, u: 0, w: 0}, 1.0))
    assert [(e.kind, e.first, e.second, e.size) for e in found.links] == [
        ("coupling", 0, 1, 0),
        ("stiffness", 0, GROUND, 2),
        ("stiffness", 1, GROUND, 3),
    ]


def test_the_picture_is_told_in_words():
    scene = sf.scenes.mass_on_belt(v_b=0.2)
    assert "x in contact with belt, which moves at v_b" in in_words(diagram_of(scene))
    assert picture(scene).uri.startswith("data:image/svg+xml")
    assert picture(chain(25)) is None
