"""The scenes of drawn slides: equations, scalings, symbols, and what is refused."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

DRAWN = {"mu1": -0.3, "mu2": 0.4, "p_star": -0.25, "epsilon": 1.5}
PAIR = {"r": 0.5, "zeta": 2.0, "s1": 0.2, "s2": 0.3, "fc1": 1.0, "fs1": 7.8}


def test_the_drawn_slide_has_the_source_s_friction_in_the_v_scaling():
    scene = sf.scenes.drive_slide(**DRAWN, fc=3.0)
    law = scene.contacts[0].law.where({s.name: v for s, v in scene.values.items()})
    corner = 1 - 0.25
    speeds = np.array([1e-9, 0.3, corner, 1.0, 4.0])
    expected = 3.0 * corner - 0.6 * np.minimum(speeds, corner) + 0.8 * np.maximum(speeds - corner, 0)
    assert law(speeds) == pytest.approx(expected, rel=1e-14)
    assert float(law.stick - law.at_rest) == pytest.approx(1.5 * corner)  # eps1 = eps (1 + p*)
    assert [float(b) for b in law.breaks] == [corner]


def test_both_scalings_describe_one_motion():
    # over 1 + p*, lengths and forces of the v-scaling are those of the v*-scaling, where the drive moves at 4/3
    drawn = sf.scenes.drive_slide(**{**DRAWN, "epsilon": 6.0}, horizon=60.0)
    stopped = sf.scenes.drive_stop(mu1=-0.3, mu2=0.4, lam=1.5, epsilon=6.0)
    (u,) = drawn.system.u
    contact = sf.Contact("way", slip=u + 4 / sp.Integer(3), normal=1, law=stopped.contacts[0].law)
    by_v_star = sf.Scene(
        drawn.system,
        [contact],
        values={k: stopped.values[k] for k in stopped.contacts[0].law.free_symbols},
        initial={"x": 0, "u": -4 / 3},
        horizon=60.0,
    )
    a, b = sf.simulate(drawn, 1e-12), sf.simulate(by_v_star, 1e-12)
    assert a.stats["events"] == b.stats["events"] > 2
    assert b.final * 0.75 == pytest.approx(a.final, abs=1e-10)


def test_symbols_carry_the_names_of_the_arguments():
    for scene, names in (
        (sf.scenes.drive_slide(**DRAWN), {*DRAWN, "fc"}),
        (sf.scenes.drive_stop(mu1=-0.5, mu2=0.8, lam=4.0), {"mu1", "mu2", "lam", "epsilon", "fc", "speed"}),
        (sf.scenes.two_slides(**PAIR), set(PAIR)),
    ):
        assert {s.name for s in scene.parameters} == names
        for name in names:
            assert scene.where({name: 3.0}).values[scene.parameter(name)] == 3.0
        assert scene.horizon > 20
        scene.numbers()


def test_the_kinetic_friction_at_rest_does_not_become_negative_below_the_corner():
    for mu1 in (-3.0, -0.2, 0.5):
        scene = sf.scenes.drive_slide(**{**DRAWN, "mu1": mu1})
        law = scene.contacts[0].law.where({s.name: v for s, v in scene.values.items()})
        assert np.all(law(np.linspace(1e-9, 0.75, 50)) >= -1e-15)


def test_two_slides_in_the_form_of_the_source():
    for damping, d2 in (("omega1", 0.3), ("omega2", 0.15)):
        scene = sf.scenes.two_slides(**PAIR, damping=damping)
        e1, e2, u1, u2 = scene.system.states
        rates = scene.system.mass.inv() * sp.Matrix(scene.system.force).subs(scene.values)
        rates = rates.subs(scene.values)
        assert sp.simplify(rates[0] + 2 * 0.2 * u1 + e1) == 0
        assert sp.expand(rates[1] + 2 * d2 * u2 + e2 / 4) == pytest.approx(0, abs=1e-15)
        push = (scene.system.mass.inv() * sp.Matrix([scene.contacts[0].slip]).jacobian([u1, u2]).T).subs(scene.values)
        assert list(push) == [1, -0.5]  # F acts on the first as -F, on the second as r F
        assert scene.contacts[0].slip.subs({u1: -1, u2: 0}) == 0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sf.scenes.drive_slide(**{**DRAWN, "p_star": -1.0}), "p_star is -1"),
        (lambda: sf.scenes.drive_slide(**{**DRAWN, "mu1": "a"}), "mu1 is 'a'"),
        (lambda: sf.scenes.drive_slide(**{**DRAWN, "epsilon": -0.1}), "static coefficient"),
        (lambda: sf.scenes.drive_stop(mu1=-0.5, mu2=0.8, lam=None), "lam is None"),
        (lambda: sf.scenes.two_slides(**{**PAIR, "zeta": 0.0}), "zeta is 0"),
        (lambda: sf.scenes.two_slides(**{**PAIR, "fs1": 0.5}), "static coefficient"),
        (lambda: sf.scenes.two_slides(**PAIR, damping="s2"), "damping is 's2'"),
    ],
)
def test_bad_numbers_are_named(make, message):
    with pytest.raises(sf.SceneError, match=message):
        make()
