"""Words, letters and units of the study page: what is set as mathematics, what has a unit, what is predicted."""

import re

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.report.html.mathml import friction_of_contact, to_mathml
from symfric.report.html.words import typeset
from symfric.report.study import designs
from symfric.report.study.drawing import axes
from symfric.report.study.measurement import motion
from symfric.report.study.page import summary
from symfric.report.study.sections import MOTION, STEADY
from symfric.report.study.sections.closed_forms import closed_forms
from symfric.report.study.sections.friction import friction_curves, plot_friction
from symfric.report.study.sections.how import without_answer
from symfric.report.study.sections.motion import motion_in_words
from symfric.report.study.sections.onset import safe_speed
from symfric.report.study.sections.prediction import PredictionCurve, averaged_curves
from symfric.report.study.sections.stability import what_slides
from symfric.report.study.study import study
from symfric.scenefile import read_scene_file
from symfric.scenefile.starters import starter

X, U, K = sp.symbols("x u k")


def started(model, tmp_path, **changed):
    """Return the scene file that `symfric new` writes, with some values changed."""
    text = starter(model)
    for name, value in changed.items():
        text, count = re.subn(rf"^{name} = \S+", f"{name} = {value}", text, flags=re.MULTILINE)
        assert count == 1
    path = tmp_path / f"{model}.toml"
    path.write_text(text, encoding="utf-8")
    return read_scene_file(path)


def moving(file):
    """Return the motion, and the vibration if it settles to one."""
    found = study(file, sections=(MOTION, STEADY))
    steady = found.steady.value
    return found.motion.value, steady if steady.settled else None


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    ("model", "changed", "near"),
    [
        ("coulomb_oscillator", {"delta": 0.05, "delta_s": 0.06}, 1e-9),
        ("coulomb_oscillator", {"omega_n": 3.0}, 1e-9),
        ("contact_damper", {"mu_m": 0.07}, 0.08),  # half of a half cycle of some fifteen
        ("drive_stop", {"lam": 3.0}, 1e-7),
        ("two_slides", {"fs1": 9.0}, 1e-6),
        ("two_slides", {"zeta": 1.5}, 1e-6),
        ("positioning_stage", {"k_i": 1.5, "mu_s": 1.7}, 1e-6),
    ],
)
def test_closed_forms_of_ready_scenes_stand_beside_the_motion(model, changed, near, tmp_path):
    file = started(model, tmp_path, **changed)
    moved, steady = moving(file)
    rows = closed_forms(file, moved, steady)
    assert rows
    for _, predicted, computed, *_ in rows:
        assert predicted == pytest.approx(computed, rel=near)


def test_closed_forms_are_left_out_where_they_do_not_hold(tmp_path):
    for model, changed in (("positioning_stage", {"compensation": 0.5}), ("two_slides", {"fs1": 7.2})):
        file = started(model, tmp_path, **changed)
        assert closed_forms(file, *moving(file)) == []


def test_the_letters_of_slip_and_speed_are_free_ones():
    w, v = sp.symbols("w v", real=True)
    for slip, law, taken in (
        (w - K, sf.laws.coulomb(0.3), {"w"}),
        (v - K, sf.laws.stribeck(0.5, 0.3, 0.1), {"v", "s"}),
    ):
        text = "".join(friction_of_contact(sf.Contact("c", slip, 2, law), law, taken))
        assert not re.search(r"<mi>(\w)</mi><mo>=</mo><mi>\1</mi>", text)
        for letter in taken:
            assert f"sgn</mi><mo stretchy='false'>(</mo><mi>{letter}</mi>" not in text
    assert "<mi>v</mi>" not in friction_of_contact(sf.Contact("c", U - K, 1, law), law, {"v"})[2]


def test_a_load_that_is_all_of_the_friction_is_not_multiplied_by_one():
    law = sf.laws.coulomb(1)
    lines = friction_of_contact(sf.Contact("floor", U, K, law), law)
    assert len(lines) == 2
    assert "·" not in lines[1]


def test_names_of_several_letters_stay_apart():
    ratio, tuning = sp.symbols("ratio tuning")
    assert "<mspace" in to_mathml(ratio * tuning)
    assert to_mathml(sp.Symbol("lam")) == to_mathml(sp.Symbol("lambda"))
    assert axes.label("lam", {}) == r"$\lambda$"


def test_expressions_of_contacts_are_set_as_mathematics():
    e = X - K * U
    said = typeset(f"One contact: floor, slipping at {e} under the normal load {K}.", ["x", "u", "k"], [e, K])
    assert said.count("<math>") == 2
    assert str(e) not in said
    assert typeset("rates (-3 and -0.5) of a-b", []) == "rates (−3 and −0.5) of a-b"


def numbers_without_unit(text, names):
    """Return what follows "name = " that is a number without a unit."""
    return [m for n in names for m in re.findall(rf"\b{n} = [-−\d.e+]++(?! ?[\w/²])", text)]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("value", [0.03, 0.091359, 5.0, 1e-5, 250.0, 0.1])
def test_every_number_of_a_design_gets_its_unit_once_and_whole(value, tmp_path):
    file = read_scene_file("examples/brake_pad.toml")
    text = f"at v_b = {value:.5g} stable (decay rate {value:.4g}, less); mean power at v_b = {value:.5g}: {value:.4g}"
    once = designs.wording(file).with_units(text)
    assert numbers_without_unit(once, ["v_b"]) == []
    assert f"decay rate {value:.4g} 1/s" in once
    assert once.endswith(f"{value:.4g} W")
    assert re.sub(r" (m/s|1/s|W)\b", "", once) == text  # nothing but units was put in
    assert designs.wording(file).with_units(once) == once


def test_a_scene_without_units_shows_none(tmp_path):
    file = started("mass_on_belt", tmp_path)
    assert designs.wording(file).with_units("at v_b = 0.3 (decay rate 2)") == "at v_b = 0.3 (decay rate 2)"


def test_a_stable_scene_that_vibrates_says_both(tmp_path):
    result = study(started("drive_slide", tmp_path))
    first = summary(result)[0]
    assert "stable" in first
    assert "A large one need not" in first
    quiet = study(started("two_slides", tmp_path, fs1=7.2))
    assert "A large one" not in summary(quiet)[0]


def test_a_scene_without_contact_does_not_slide(tmp_path):
    result = study(started("absorber", tmp_path))
    said = " ".join(
        [*summary(result), motion_in_words(result.motion.value, result.file), what_slides(result.file.scene)]
    )
    assert "The equilibrium" in said
    assert not re.search("slid|mode|stick", said)


def test_reasons_are_given_once(tmp_path):
    lines = without_answer(study(started("coulomb_oscillator", tmp_path)))
    reasons = [line.partition(": ")[2] for line in lines]
    assert len(set(reasons)) == len(reasons)
    assert lines[0].startswith("equilibrium, stability: ")


def test_a_vibration_that_never_ends_is_said_to_go_on():
    file = read_scene_file("examples/rig_record.toml")
    found = safe_speed(file.scene.where({"v_s": 0.3}), file.sweep, 0.46)
    assert not found.ended
    assert found.overhangs


def test_friction_of_the_place_is_drawn_over_the_place(tmp_path):
    file = started("rolling_isolator", tmp_path)
    (curve,) = friction_curves(file.scene, motion(file.scene), None, None)
    assert curve.place == "u"
    assert curve.coefficient == pytest.approx(0.005 + 0.05 * np.abs(curve.speed))
    assert "u" in plot_friction(curve, "m").get_xlabel()


def test_a_legend_names_only_what_is_drawn():
    belt = sf.scenes.mass_on_belt(v_b=0.2)
    for low, high in ((0.05, 0.43), (0.3, 0.46)):
        for curve in averaged_curves(belt, "v_b", np.linspace(low, high, 9)):
            line = np.isfinite(curve.amplitude)
            assert (line[1:] & line[:-1]).any()
    assert PredictionCurve("a", "b", np.array([1.0]), np.array([2.0]))(1.0) == 2.0
