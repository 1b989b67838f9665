"""Random scenes: a sample of what ``symfric stress`` runs, and more numbers drawn by hypothesis."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import symfric as sf
from symfric.cli import main
from symfric.errors import SceneError
from symfric.model.laws import Law
from symfric_evidence.stress import (
    FAMILIES,
    StressResult,
    Verdict,
    comparison_of,
    examine,
    orbit_comparison,
    scene_named,
    stress,
)
from symfric_evidence.stress.random_scenes import KINDS, LAWS, Dice, structure
from symfric_evidence.stress.scene_comparison import judged
from tests.longer import longer

MIXED = {0: 60, 2: 20, 3: 20, 6: 40, 25: 20, 30: 40}  # runs of each structure
prepared = cache(comparison_of)
SEEDS = {"weak-load": 1, "vanishing-load": 3, "parallel": 11, "cell-edge": 1, "cycle": 1}  # 0 for the others


def failures(found):
    return list(StressResult(tuple(found)).unexplained)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("seed", "number"), [(5000, 12), (9001, 46), (5005, 0)])
def test_slips_that_differ_by_a_billionth(seed, number):
    # a contact that only passes through zero slip must not pull others there: its rounding is 1e-7 of their speeds
    found = comparison_of("parallel", seed).verdict(number)
    assert found.verdict == "agrees"
    assert max(found.second, found.finer) < 1e-8


@pytest.mark.one_in(24)
@pytest.mark.parametrize("family", longer([name for name in FAMILIES if name != "mixed"], ("derivatives",)))
def test_no_scene_of_a_family_fails_in_silence(family):
    comparison = prepared(family, SEEDS.get(family, 0))
    found = [comparison.verdict(number) for number in range(1 if family == "branch" else 6)]
    assert failures(found) == []
    assert any(v.verdict == "agrees" for v in found)


@pytest.mark.long(beside="test_no_scene_of_a_family_fails_in_silence")
@pytest.mark.parametrize("seed", range(1, 5))
@pytest.mark.parametrize("family", FAMILIES)
def test_no_scene_of_more_structures_fails_in_silence(family, seed):
    comparison = prepared(family, seed)
    assert failures(comparison.verdict(number) for number in range(1 if family == "branch" else 12)) == []


@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", longer(MIXED, (0, 6, 30)))
def test_no_mixed_scene_fails_in_silence(seed):
    found = [prepared("mixed", seed).verdict(number) for number in range(MIXED[seed])]
    assert failures(found) == []
    assert sum(v.verdict == "agrees" for v in found) > 0.8 * len(found)
    assert {v.kind for v in found} == set(KINDS)


@pytest.mark.long(beside="test_no_mixed_scene_fails_in_silence")
def test_all_routes_choose_the_same_of_two_modes_that_agree_with_the_forces():
    """A stuck joint and a belt that its body reaches, static friction above kinetic: either may go on slipping."""
    assert prepared("mixed", 40).verdict(165).verdict == "agrees"


@pytest.mark.long(beside="test_no_mixed_scene_fails_in_silence")
@pytest.mark.parametrize("scene", longer(["44/68", "6/84", "1/87", "1/165"], ("1/87", "1/165")))
def test_rounding_of_forces_that_cancel_decides_nothing(scene):
    """A law without a jump at balance; a bound exceeded by rounding; a stiff spring; five contacts on two masses."""
    _, seed, number = scene_named(f"mixed/{scene}")
    found = prepared("mixed", seed).verdict(number)
    assert (found.status, found.verdict) == ("OK", "agrees")


FOUND = ["no-contact/100/25", "mixed/104/24", "mixed/94/23", "weak-load/92/19", "weak-load/106/17", "redundant/109/0"]


@pytest.mark.long(beside="test_no_mixed_scene_fails_in_silence")
@pytest.mark.parametrize("scene", [*FOUND, "redundant/109/17", "lanes/104/24"])
def test_scenes_on_which_run_and_reference_once_differed(scene):
    """A state that rests on a kink; an infinite slope at rest; overflow; a weak load; two modes after a release."""
    name, seed, number = scene_named(scene)
    found = prepared(name, seed).verdict(number)
    assert (found.status, found.verdict) == ("OK", "agrees")


@pytest.mark.long(beside="test_no_mixed_scene_fails_in_silence")
@settings(derandomize=True, deadline=None, max_examples=12)
@given(seed=st.sampled_from([2, 3, 25]), number=st.integers(1000, 10**9))
def test_no_other_draw_fails_in_silence(seed, number):
    assert prepared("mixed", seed).verdict(number).verdict != "silent failure"


@pytest.mark.one_in(9)
@pytest.mark.parametrize("family", FAMILIES)
def test_draws_follow_from_their_seeds(family):
    build, draw = FAMILIES[family].build, FAMILIES[family].draw
    assert build(5).scene.equations() == build(5).scene.equations()
    assert draw(build(5), 5, 42) == draw(build(5), 5, 42) != draw(build(5), 5, 43)


def test_every_law_size_and_number_of_contacts_occurs():
    scenes = [structure(seed) for seed in range(50)]
    assert {len(s.system.q) for s in scenes} == {len(s.contacts) for s in scenes} == {1, 2, 3, 4, 5}
    found = {c.law.source for s in scenes for c in s.contacts}
    numbers = [0.3, 0.1, 0.5, 0.05]
    assert {law(*numbers).source for law in LAWS.values()} <= found
    assert all(isinstance(law(*numbers), Law) for law in LAWS.values())


def test_a_start_at_the_edge_has_its_forces_at_their_bounds():
    scene = structure(3)
    number = KINDS.index("edge")
    draw = Dice(scene).draw(3, number)
    start = scene.where(draw.values).starting(draw.initial)
    run = prepared("mixed", 3).chosen.run(draw.values, draw.initial)
    (force,) = start.system.force
    pull = float(force.subs(start.numbers()))
    assert abs(pull) == pytest.approx(draw.values["N1"] * draw.values["mu1"], rel=1e-12)
    assert run.x[1, 0] == draw.values.get("v1", 0.0)


def test_other_units_are_undone(monkeypatch):
    comparison = prepared("rescaled", 2)
    structure, draw, units = comparison.structure, comparison.draw(1), comparison.structure.units(2, 1)
    assert max(abs(np.log10(u)) for u in units) > 1
    values, initial = structure.in_units(draw, units)
    stated = [draw.initial[s.name] for s in structure.scene.system.states] * structure.state_units(units)
    assert [initial[s.name] for s in structure.scene.system.states] == pytest.approx(stated)
    assert values.keys() == draw.values.keys() <= structure.dimensions.keys()
    assert comparison.verdict(1).verdict == "agrees"
    monkeypatch.setattr(type(structure), "in_units", lambda self, draw, units: ({}, initial))  # another scene
    assert comparison.verdict(1).verdict == "silent failure"


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("family", "seed", "number"), [("mixed", 3, 0), ("belt", 0, 1), ("no-contact", 0, 2)])
def test_a_wrong_run_would_be_seen(monkeypatch, family, seed, number):
    comparison = prepared(family, seed)
    assert comparison.verdict(number).verdict == "agrees"
    name = {"mixed": "N1", "belt": "k1", "no-contact": "k1"}[family]
    for program in (comparison.chosen, comparison.fine):
        run = program.run
        wrong = lambda values, initial, run=run: run(values | {name: 1.01 * values[name]}, initial)  # noqa: E731
        monkeypatch.setattr(program, "run", wrong)
    found = comparison.verdict(number)
    assert found.verdict == "silent failure"
    assert found.finer < 1e-6  # both runs are wrong alike: only the reference tells
    assert found.change < found.second  # what is wrong is not called sensitive


def wrong_reference(monkeypatch, comparison, off=0.0, scatter=0.0, alternatives=False):
    run = comparison.reference.run
    rng = np.random.default_rng(1)

    def other(values, initial, **options):
        found = run(values, initial, **options)
        if options.get("preference"):
            return found
        return replace(found, x=found.x + off + scatter * rng.normal(), alternatives=alternatives)

    monkeypatch.setattr(comparison.reference, "run", other)


@pytest.mark.long(beside="test_a_run_that_raises_is_a_failure")
def test_a_wrong_reference_is_a_failure_of_its_side(monkeypatch):
    comparison = prepared("belt", 0)
    wrong_reference(monkeypatch, comparison, off=0.1)
    found = comparison.verdict(1)
    assert found.verdict == "silent failure"
    assert float(found.note.split()[0]) < 1e-6  # the third method agrees with the run
    assert "route integrators" in found.note


@pytest.mark.long(beside="test_another_admissible_motion_is_named")
def test_a_motion_is_sensitive_only_if_both_methods_say_so(monkeypatch):
    comparison = prepared("belt", 0)
    wrong_reference(monkeypatch, comparison, scatter=0.1)  # a reference that changes by itself, and a run that does not
    found = comparison.verdict(1)
    assert found.verdict == "silent failure"
    assert found.change < 1e-3


def test_another_admissible_motion_is_named(monkeypatch):
    comparison = prepared("belt", 0)
    wrong_reference(monkeypatch, comparison, off=0.1, alternatives=True)
    assert comparison.verdict(1).verdict == "not unique"


@pytest.mark.long(beside="test_slips_that_differ_by_a_billionth")
def test_a_reference_without_an_answer_is_replaced_by_a_third_method(monkeypatch):
    comparison = prepared("belt", 0)
    run = comparison.reference.run
    without = lambda *args, **options: replace(run(*args, **options), reason="no admissible mode")  # noqa: E731
    monkeypatch.setattr(comparison.reference, "run", without)
    found = comparison.verdict(1)
    assert found.verdict == "agrees"
    assert found.note.startswith("no admissible mode; ")
    monkeypatch.setattr(comparison, "third", lambda *args: None)
    found = comparison.verdict(1)
    assert (found.verdict, StressResult((found,)).unexplained) == ("unconfirmed", (found,))


@pytest.mark.parametrize(
    ("found", "verdict"),
    [
        ((0.1, 0.1, 0.1, np.nan), "agrees"),
        ((np.nan, 0.1, 0.1, np.nan), "agrees"),  # the finer run ended with a status
        ((2.0, 0.1, 0.1, np.nan), "silent failure"),  # the finer run is wrong
        ((2.0, 0.1, 0.1, 0.5), "sensitive"),
        ((0.1, 20.0, 0.1, 1.0), "silent failure"),
        ((0.1, 20.0, 0.1, 3.0), "sensitive"),
        ((0.1, 20.0, 3.0, 30.0), "silent failure"),  # the energies do not balance
        ((0.1, 0.1, np.nan, np.nan), "silent failure"),
        ((0.1, np.nan, 0.1, np.nan), "unconfirmed"),  # two runs by one method do not confirm each other
        ((np.nan, np.nan, 0.1, np.nan), "unconfirmed"),
        ((2.0, np.nan, 0.1, np.nan), "silent failure"),
    ],
)
def test_verdicts_follow_from_what_was_measured(found, verdict):
    assert judged(found, 1.0, True) == verdict
    assert judged(found, 1.0, False) == ("not unique" if verdict == "agrees" else verdict)


@pytest.mark.long(beside="test_no_mixed_scene_fails_in_silence")
@pytest.mark.parametrize("number", range(0, 24, 3))
def test_the_reference_goes_through_the_rest_of_a_law_with_a_root(number):
    """Square root, averaged and other laws with an infinite slope: trial steps fall beyond zero slip."""
    found = prepared("mixed", 5002).verdict(number)
    assert found.verdict == "agrees" or (found.verdict, found.status) == ("status", "NOT_FINITE")
    assert "collapsed" not in found.note


def test_a_bit_that_differs_in_a_lane_would_be_seen(monkeypatch):
    comparison = prepared("lanes", 0)
    assert comparison.verdict(5).verdict == "agrees"
    together = comparison._together

    def turned(block):
        batch = together(block)
        final = batch.final.copy()
        final[0, 5] = np.nextafter(final[0, 5], 1.0)
        return replace(batch, final=final)

    monkeypatch.setattr(comparison, "_together", turned)
    assert [comparison.verdict(n).verdict for n in (4, 5)] == ["agrees", "silent failure"]


@pytest.mark.long(beside="test_a_wrong_run_would_be_seen")
def test_a_wrong_derivative_would_be_seen():
    comparison = prepared("derivatives", 0)
    draw = comparison.family.draw(comparison.structure, 0, 0)
    run, direction = comparison.program.run(draw.values, draw.initial), comparison.directions[0]
    right = run.sensitivities[direction]
    assert comparison.judged(right, run.final, draw, direction)[0] == "agrees"
    assert comparison.judged(1.01 * right, run.final, draw, direction)[0] == "silent failure"


@pytest.mark.long(beside="test_a_wrong_run_would_be_seen")
def test_an_onset_in_the_wrong_place_would_be_seen(monkeypatch):
    found = prepared("branch", 3)
    continued = orbit_comparison.continue_cycle

    def moved(*args):
        branch = continued(*args)
        onset = next(s for s in branch.special if s.kind == "stick-onset")
        near = [
            i
            for i in range(len(branch.values) - 1)
            if min(branch.values[i : i + 2]) <= onset.value <= max(branch.values[i : i + 2])
        ]
        wrong = replace(onset, value=float(0.9 * branch.values[near[0]] + 0.1 * branch.values[near[0] + 1]))
        return replace(branch, special=(wrong,))

    monkeypatch.setattr(orbit_comparison, "continue_cycle", moved)
    verdict = found.verdict(0)
    assert verdict.verdict == "silent failure"
    assert "an onset of sticking lies between" in verdict.note


def test_an_orbit_that_does_not_close_would_be_seen():
    comparison = prepared("cycle", 1)
    draw = comparison.family.draw(comparison.structure, 1, 0)
    orbit = sf.limit_cycle(comparison.structure.scene.where(draw.values).starting(draw.initial))
    assert comparison.misfit(orbit, draw.values)[0] < 1e-9
    assert comparison.misfit(replace(orbit, period=1.01 * orbit.period), draw.values)[0] > 1e-4


def test_a_run_that_raises_is_a_failure(monkeypatch):
    comparison = prepared("mixed", 3)

    def fail(values, initial):
        raise RuntimeError("broken")

    monkeypatch.setattr(comparison.chosen, "run", fail)
    found = comparison.verdict(0)
    assert (found.verdict, found.note) == ("silent failure", "RuntimeError: broken")


@pytest.mark.long(beside="test_the_command_counts_and_names")
def test_a_stress_run_counts_by_family_whatever_the_jobs():
    one, two = (stress(4, families=("no-contact", "belt"), jobs=jobs) for jobs in (1, 2))
    assert repr(one) == repr(two)
    assert [v.name for v in one.verdicts] == [v.name for v in two.verdicts]
    assert {name: sum(counts.values()) for name, counts in one.by_family.items()} == {"no-contact": 2, "belt": 2}


def test_an_unknown_family_is_named():
    with pytest.raises(SceneError, match="no family of scenes is called 'blet'; did you mean belt"):
        stress(1, families=("blet",))


def test_the_command_counts_and_names(monkeypatch):
    done = CliRunner().invoke(main, ["stress", "--scene", "mixed/3/4", "--json", "--quiet"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.output)["families"]["mixed"]["agrees"] == 1
    none = (np.nan, 1e-9, 1e-9)
    for verdict in ("silent failure", "unconfirmed"):
        wrong = Verdict("belt", "belt/3/4", "", verdict, "taylor", "OK", 1e-6, 0.1, *none, "")
        monkeypatch.setattr("symfric_evidence.stress.examine", lambda family, seed, numbers, wrong=wrong: [wrong])
        done = CliRunner().invoke(main, ["stress", "--scene", "belt/3/4", "--json"])
        assert done.exit_code == 1
        assert f"{verdict}: belt/3/4" in done.output
        assert "--scene belt/3/4" in done.output
    for name in ("mixed/3-4", "3/4", "felt/3/4"):
        done = CliRunner().invoke(main, ["stress", "--scene", name])
        assert done.exit_code == 2
    done = CliRunner().invoke(main, ["stress", "--list"])
    assert done.output.split() == list(FAMILIES)


def test_examine_gives_the_verdicts_of_one_structure():
    found = StressResult(tuple(examine("no-contact", 0, [1, 2])))
    assert found.counts["agrees"] == 2
    assert found.failures == ()


def test_a_disagreement_is_told_at_once_and_an_interrupted_run_counts(monkeypatch):
    wrong = Verdict("belt", "belt/3/4", "", "silent failure", "taylor", "OK", 1e-6, 0.1, np.nan, 1e-9, 1e-9, "")

    def run(scenes, *, seed, families, jobs, told):
        told([replace(wrong, verdict="agrees")] * 3)
        told([wrong])
        raise KeyboardInterrupt

    monkeypatch.setattr("symfric_evidence.stress.stress", run)
    done = CliRunner().invoke(main, ["stress", "--scenes", "9", "--quiet", "--json"])
    assert done.exit_code == 130
    assert "silent failure: belt/3/4" in done.stderr
    assert "interrupted; 4 of 9 scenes are compared" in done.stderr
    assert json.loads(done.stdout)["counts"]["agrees"] == 3
