"""The benchmark measures what it says: errors against known answers, for every solver that is there."""

import json

import pytest
from click.testing import CliRunner

from symfric.bench.measure import measure
from symfric.bench.peers import peers
from symfric.bench.problems import problems
from symfric.cli import main

EVENTS = problems()["P1"].events


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("bench")


@pytest.fixture(scope="module")
def result(folder):
    arguments = ["bench", "--peers", "--problem", "P1", "--rounds", "1", "--json", "--quiet", "-o", str(folder)]
    outcome = CliRunner().invoke(main, arguments)
    assert outcome.exit_code == 0, outcome.output
    return json.loads(outcome.output)


def test_every_installed_solver_has_a_curve_and_every_other_is_named(result):
    everyone = peers().values()
    assert {c["solver"] for c in result["curves"]} == {p.name for p in everyone if "P1" in p.problems and not p.missing}
    assert set(result["absent"]) == {p.name for p in everyone if p.missing}


def test_our_own_errors_stay_within_the_tolerance_and_every_event_is_found(result):
    own = [c for c in result["curves"] if c["solver"] == "symfric"]
    points = [p for c in own for p in c["points"]]
    assert len(points) >= 3
    for point in points:
        assert point["error"] <= 10 * point["tolerance"]
        assert point["events"] == EVENTS
        assert point["seconds"] > 0


def test_the_picture_and_the_numbers_are_written(result, folder):
    assert json.loads((folder / "bench.json").read_text()) == result
    assert (folder / "bench.png").read_bytes().startswith(b"\x89PNG")


def test_an_unknown_problem_is_one_line(result):
    outcome = CliRunner().invoke(main, ["bench", "--problem", "Q1"])
    assert outcome.exit_code == 2
    assert "no problem 'Q1'; known: P1, P2" in outcome.output
    with pytest.raises(Exception, match="no problem 'Q1'"):
        measure(["Q1"])
