"""Friction examples of Modelica: published numbers, and references that are right to more digits than these."""

import json

import mpmath as mp
import numpy as np
import pytest
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric_evidence.bench import known_times
from symfric_evidence.bench.friction_table import motion_in_many_digits, table_scene
from symfric_evidence.bench.many_digits import many_digits
from symfric_evidence.bench.problems import named
from symfric_evidence.bench.published import MODELS, scene_of


def test_published_results_are_met_to_their_accuracy():
    outcome = CliRunner().invoke(main, ["bench", "--published", "--json", "--quiet"])
    assert outcome.exit_code == 0, outcome.output
    rows = json.loads(outcome.output)["published"]
    assert {row["model"] for row in rows} == {model.name for model in MODELS}
    for row in rows:  # DASSL with its default tolerance
        assert row["difference"] < (1e-11 if "Brake" in row["model"] else 3e-4)


@pytest.mark.long(beside="test_references_are_met")
@pytest.mark.parametrize("until", [0.3, 0.45, 2.0, 2.6, 5.0])
def test_mass_on_a_table_moves_as_its_closed_form(until):
    place, speed = motion_in_many_digits(until) if until > 0.41 else (0, 0)
    run = sf.simulate(table_scene().until(until), 1e-13)
    assert np.max(np.abs(run.final - [float(place), float(speed)])) < 1e-13


@pytest.mark.parametrize("name", ["P11", "P12", "P13"])
def test_references_are_met(name):
    problem = named(name)
    run = sf.simulate(problem.scene, 1e-12)
    assert np.max(np.abs(run.final - [float(e) for e in problem.reference])) < 1e-12
    assert run.stats["events"] == problem.events


@pytest.mark.long(beside="test_references_are_met")
@pytest.mark.parametrize("name", ["clutch_and_brake", "coupled_clutches"])
def test_references_are_found_again_in_multiple_precision(name):
    problem = named({"clutch_and_brake": "P11", "coupled_clutches": "P12"}[name])
    found = many_digits(scene_of(name), 24)
    with mp.workdps(30):
        for value, known in zip(found.final, problem.reference, strict=True):
            assert abs(value - mp.mpf(known)) < 1e-15
    assert found.events == problem.events


@pytest.mark.long(beside="test_references_are_met")
def test_of_several_events_in_a_step_the_reference_takes_the_first():
    # the third clutch closes shortly before the slip of the first one ends
    short = scene_of("coupled_clutches").until(0.91)
    found = np.array(many_digits(short, 14).final, dtype=float)
    assert np.max(np.abs(found - sf.simulate(short, 1e-12).final)) < 1e-9  # an event missed by 2 ms is 1e-2


@pytest.mark.long(beside="test_references_are_met")
def test_events_at_known_times_cost_little():
    cost = {row.wanted: row.seconds for row in known_times.instant_costs()}
    assert cost["one step in time"] < 3 * cost["plain"]
    assert cost["a reset with 64 times"] < 12 * cost["plain"]
