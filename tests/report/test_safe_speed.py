"""The speed above which nothing vibrates, against motions and branches, and the values that a summary recommends."""

from pathlib import Path

import pytest

import symfric as sf
from symfric.report.study.sections.onset import SafeSpeed, safe_speed
from symfric.scenefile import SweepPlan, read_scene_file

EXAMPLES = Path(__file__).parents[2] / "examples"


def asked(name):
    file = read_scene_file(EXAMPLES / f"{name}.toml")
    plan = file.sweep
    onset = sf.hopf(file.scene, plan.parameter, (plan.start, plan.stop)).value
    return file.scene, safe_speed(file.scene, plan, onset)


@pytest.mark.long(beside="test_a_vibration_that_sets_in_gently_ends_at_the_onset")
def test_a_vibration_goes_on_beyond_the_onset_and_ends_at_the_speed_that_is_said():
    scene, found = asked("brake_pad")
    assert found.overhangs
    orbit = sf.limit_cycle(scene)
    branch = sf.continue_cycle(scene, "v_b", (scene.values[scene.parameter("v_b")], 1.2 * found.value))
    last = max(v for v, o in zip(branch.values, branch.orbits, strict=True) if o.stable)
    assert found.value == pytest.approx(last, rel=1e-3)
    assert found.onset < 0.9 * found.value
    start = dict(zip(orbit.names, orbit.start.tolist(), strict=True))
    above = scene.where({"v_b": 1.01 * found.value}).starting(start).until(40 * scene.horizon)
    x = scene.system.q[0]
    late = sf.simulate(above.wanting({"size": sf.HalfRange(x), "end": sf.End()})).checked()
    again = above.starting(dict(zip(late.names, late["end"].tolist(), strict=True))).until(scene.horizon)
    assert sf.simulate(again.wanting({"size": sf.HalfRange(x)})).checked()["size"] < 1e-3 * late["size"]


def test_a_vibration_that_sets_in_gently_ends_at_the_onset():
    _, found = asked("belt")
    assert not found.overhangs
    assert found.value == pytest.approx(found.onset, rel=0.01)
    assert found.to_dict()["overhangs"] is False


def test_without_vibration_there_is_no_such_speed():
    scene = sf.scenes.mass_on_belt(v_b=0.6)
    with pytest.raises(sf.NotFound, match="nothing vibrates at v_b = 0.6"):
        safe_speed(scene, SweepPlan("v_b", 0.1, 1.0, 3, "x"), 0.44)
    assert not SafeSpeed("v_b", 0.441, 0.44).overhangs


def test_recommended_values_are_those_that_the_full_model_confirms():
    file = read_scene_file(EXAMPLES / "machine_slide.toml")
    (plan,) = file.designs
    design = plan(file.scene)
    values, _ = plan.working(design)
    assert values["c"] >= design.values["c"]
    assert values["c"] == pytest.approx(design.values["c"], rel=1e-4)
    settled = file.scene.where({**values, "v_f": 0.005})
    start = sf.simulate(settled.until(0.3).wanting({"end": sf.End()})).checked()
    later = settled.starting(dict(zip(start.names, start["end"].tolist(), strict=True)))
    assert sf.simulate(later.wanting({"size": sf.HalfRange(file.scene.system.q[0])})).checked()["size"] <= 1e-5
