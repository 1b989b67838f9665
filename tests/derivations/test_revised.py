"""The table of revised verdicts: every row points to one of the ledger, and says why."""

import json

import pytest
from click.testing import CliRunner

from derivations.__main__ import main as command
from derivations.ledger import Verdict, evaluate
from derivations.revised import NONE, REVISED
from derivations.sources import ledger_of


@pytest.mark.parametrize("revision", REVISED, ids=lambda r: f"{r.source} {r.equation}")
def test_a_revision_rests_on_a_row(revision):
    rows = [e for e in ledger_of(revision.source).entries if e.equation == revision.equation]
    assert rows
    assert revision.now in set(map(str, Verdict))
    assert revision.before != revision.now or revision.now == "corrected"  # the second reading of one statement
    assert len(revision.why) > 10
    if revision.now == "unverifiable":
        assert rows[0].note


@pytest.mark.parametrize("name", ["Section 5.1 underestimate", "after Table 2 second condition"])
def test_the_row_holds(name):
    rows = [e for e in ledger_of("rolling_isolation").entries if e.equation == name]
    assert all(evaluate(row).sound for row in rows)


def test_the_command_prints_it():
    shown = CliRunner().invoke(command, ["--revised"])
    assert shown.exit_code == 0
    assert shown.output.count("before") >= len(REVISED)
    data = json.loads(CliRunner().invoke(command, ["--revised", "--json"]).output)
    assert [row["statement"] for row in data] == [r.statement for r in REVISED]
    assert {row["before"] for row in data} > {NONE}
    assert CliRunner().invoke(command, ["guida", "--revised"]).exit_code == 2
