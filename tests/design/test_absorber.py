"""Designs of the mass damper: their objectives, the event-driven model, and friction in it."""

import json

import numpy as np
import pytest

import symfric as sf
from symfric.design import absorber
from symfric.theory import absorber as theory
from tests.longer import longer

MU = 0.1
EXPECTED = {
    "hinf": theory.least_peak(MU).value,
    "h2": 0.5 * np.sqrt((4 + 3 * MU) / (MU * (1 + MU))),
    "decay": 0.5 * np.sqrt(MU / (1 + MU)),
    "self-excited": np.sqrt(np.sqrt(1 + MU) * (np.sqrt(1 + MU) - 1) / 2),
}


@pytest.mark.parametrize("ratio", [0.01, 3.99, 4.0, 4.01, 9.0])
def test_coinciding_eigenvalues_are_no_disagreement(ratio):
    found = absorber(ratio, "decay")
    assert found.status == "optimal", found.doubts


@pytest.mark.parametrize("criterion", EXPECTED)
def test_objectives(criterion):
    found = absorber(MU, criterion)
    assert set(found.values) == {"tuning", "damping"}
    assert found.objective == pytest.approx(EXPECTED[criterion], rel=1e-12)
    assert found.status == ("infimum" if criterion == "self-excited" else "optimal")
    assert found.check.agrees, str(found.check)
    assert found.scene.numbers()[found.scene.parameter("tuning")] == found.values["tuning"]
    json.dumps(found.to_dict())
    assert found.plot() is not None


def test_least_peak_has_two_active_frequencies():
    found = absorber(mass_ratio=0.05)
    assert len(found.active) == 2
    assert found.check.rows[0].computed == pytest.approx(found.objective, rel=1e-8)


def test_self_excitation_beside_the_bound():
    less, more = absorber(MU, "self-excited").check.rows
    assert less.computed > 0 > more.computed


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"criterion": "h3"}, "no criterion 'h3'; known: decay, h2"),
        ({"friction": 0.1}, "without a contact"),
        ({"contact": "nowhere", "friction": 0.1}, "contact is 'nowhere'"),
        ({"contact": "main", "friction": -0.1}, "must not be negative"),
        ({"contact": "main", "friction": 0.1, "band": (2, 1)}, "band"),
        ({"contact": "main", "friction": 0.1, "criterion": "h2"}, "the criterion is 'hinf'"),
    ],
)
def test_bad_arguments(arguments, words):
    with pytest.raises(sf.SceneError, match=words):
        absorber(MU, **arguments)


@pytest.mark.long(beside="test_least_peak_has_two_active_frequencies")
def test_a_contact_without_friction_changes_nothing():
    found, plain = absorber(MU, contact="absorber", friction=0.0, band=(0.7, 1.2)), theory.least_peak(MU)
    assert found.status == "optimal"
    assert found.objective == pytest.approx(plain.value, rel=1e-6)
    assert found.values["tuning"] == pytest.approx(plain.tuning, rel=2e-3)


@pytest.mark.long(beside="test_least_peak_has_two_active_frequencies")
@pytest.mark.parametrize("contact", longer(["absorber", "main"], ["main"]))
def test_friction_is_beaten_by_no_neighbour(contact):
    found = absorber(MU, contact=contact, friction=0.1, band=(0.75, 1.15))
    assert found.status == "optimal"
    assert found.check.agrees, str(found.check)
    plain = theory.least_peak(MU).value
    assert (found.objective < plain) == (contact == "main")  # in the absorber it resists small motions too much
    # worst amplitude at neighbours over a grid of frequencies, by runs of the ready scene over some 40 periods
    program = sf.prepare(found.scene.until(300.0).wanting({"path": sf.Trajectory()}), 1e-8)
    for f, z in ((0.98, 1.0), (1.02, 1.0), (1.0, 0.8), (1.0, 1.25), (0.9, 0.5)):
        values = {"tuning": f * found.values["tuning"], "damping": z * found.values["damping"]}
        worst = 0.0
        for g in np.linspace(0.8, 1.1, 21):
            run = program.run(values={**values, "Omega": g})
            last = run(np.linspace(300 - 2 * np.pi / g, 300, 200))[0]
            worst = max(worst, 0.5 * np.ptp(last))
        assert worst > found.objective * (1 - 2e-3)


@pytest.mark.long(beside="test_least_peak_has_two_active_frequencies")
def test_a_contact_that_sticks_for_whole_periods():
    """The amplitude jumps, so the status stays modest, and no random design is better by more than a few per cent."""
    found = sf.design.absorber(0.22, contact="absorber", friction=0.42)
    assert found.status == "best found"
    scene = sf.scenes.absorber(mass_ratio=0.22, tuning=0.9, damping=0.1, contact="absorber", friction=0.42)
    late = sf.Samples(scene.system.q[0], np.linspace(500.0, 1000.0, 5001))
    program = sf.prepare(scene.until(1000.0).wanting({"late": late}), 1e-8)
    rng, g = np.random.default_rng(3), np.linspace(0.5, 1.5, 41)
    worst = []
    for f, z in zip(rng.uniform(0.75, 1.0, 60), rng.uniform(0.0, 0.3, 60), strict=True):
        settled = program.map(values={"tuning": f, "damping": z, "Omega": g})
        assert np.all(settled.status == sf.Status.OK)
        worst.append(0.5 * np.max(np.ptp(settled.outputs["late"], axis=0)))
    assert found.objective < 1.03 * min(worst)
