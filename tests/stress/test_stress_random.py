"""Random scenes: a slice of what ``symfric stress`` runs, and more numbers drawn by hypothesis."""

import json
from functools import cache

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from symfric.bench.random_scenes import KINDS, LAWS, Dice, structure
from symfric.bench.stress import Comparison, Verdict, scene_named
from symfric.cli import main
from symfric.model.laws import Law
from tests.longer import longer

SLICE = {0: 60, 2: 40, 3: 60, 6: 40, 25: 60, 30: 40}  # runs of each structure
prepared = cache(Comparison)


@pytest.mark.parametrize("seed", longer(SLICE, (0, 6, 30)))
def test_no_random_scene_fails_in_silence(seed):
    found = [prepared(seed).verdict(number) for number in range(SLICE[seed])]
    assert [v for v in found if v.verdict == "silent failure"] == []
    assert sum(v.verdict == "agrees" for v in found) > 0.8 * len(found)
    assert {v.kind for v in found} == set(KINDS)


@pytest.mark.long
def test_all_routes_choose_the_same_of_two_modes_that_agree_with_the_forces():
    """A stuck joint and a belt that its body reaches, static friction above kinetic: either may go on slipping."""
    assert prepared(40).verdict(165).verdict == "agrees"


@pytest.mark.parametrize("scene", longer(["44/68", "6/84", "1/87", "1/165"], ("1/87", "1/165")))
def test_rounding_of_forces_that_cancel_decides_nothing(scene):
    """A law without a jump at balance; a bound exceeded by rounding; a stiff spring; five contacts on two masses."""
    seed, number = scene_named(scene)
    found = prepared(seed).verdict(number)
    assert (found.status, found.verdict) == ("OK", "agrees")


@settings(derandomize=True, deadline=None, max_examples=40)
@given(seed=st.sampled_from([2, 3, 25]), number=st.integers(1000, 10**9))
def test_no_other_draw_fails_in_silence(seed, number):
    assert prepared(seed).verdict(number).verdict != "silent failure"


def test_draws_follow_from_their_seeds():
    first, second = (Dice(structure(17)).draw(17, 42) for _ in range(2))
    assert first == second
    assert first != Dice(structure(17)).draw(17, 43)


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
    run = prepared(3).chosen.run(draw.values, draw.initial)
    (force,) = start.system.force
    pull = float(force.subs(start.numbers()))
    assert abs(pull) == pytest.approx(draw.values["N1"] * draw.values["mu1"], rel=1e-12)
    assert run.x[1, 0] == draw.values.get("v1", 0.0)


def test_a_wrong_run_would_be_seen(monkeypatch):
    comparison = prepared(3)
    assert comparison.verdict(0).verdict == "agrees"
    run = comparison.chosen.run
    monkeypatch.setattr(
        comparison.chosen, "run", lambda values, initial: run(values | {"N1": 1.01 * values["N1"]}, initial)
    )
    assert comparison.verdict(0).verdict == "silent failure"


def test_the_command_counts_and_names(monkeypatch):
    done = CliRunner().invoke(main, ["stress", "--scene", "3/4", "--json", "--quiet"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.output)["counts"]["agrees"] == 1
    wrong = Verdict("3/4", "near", "silent failure", "exact", "OK", 1e-6, 0.1, np.nan, 1e-9, 1e-9)
    monkeypatch.setattr("symfric.bench.stress.examine", lambda seed, numbers: [wrong])
    done = CliRunner().invoke(main, ["stress", "--scene", "3/4", "--json"])
    assert done.exit_code == 1
    assert "--scene 3/4" in done.output
    done = CliRunner().invoke(main, ["stress", "--scene", "3-4"])
    assert done.exit_code == 2
    assert "no scene's name" in done.output
