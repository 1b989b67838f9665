"""``python -m derivations`` and the README that it writes."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import sympy as sp
from click.testing import CliRunner

import derivations.sources
from derivations.__main__ import main
from derivations.ledger import Ledger, stated
from derivations.sources import SOURCES, ledger_of
from derivations.written import text

FOLDER = Path(derivations.sources.__file__).parent
ROOT = FOLDER.parent


def command(*arguments):
    return [sys.executable, "-m", "derivations", *arguments]


def run(*arguments):
    return subprocess.run(command(*arguments), capture_output=True, text=True, cwd=ROOT, timeout=180)


@pytest.mark.long(beside="test_an_unknown_source_is_named")
def test_one_source_in_full():
    done = run("foundation", "--json")
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    (source,) = data["sources"]
    assert data["sound"]
    assert [row["equation"] for row in source["rows"]] == [e.equation for e in ledger_of("foundation").entries]
    assert {row["residual"] for row in source["rows"]} <= {"", "0"}


def test_an_unknown_source_is_named():
    result = CliRunner().invoke(main, ["gida"])
    assert result.exit_code == 2
    assert result.output == "Error: no source 'gida'; did you mean guida?\n"


def test_help_has_an_example_and_the_sources():
    result = CliRunner().invoke(main, ["--help"])
    assert result.exit_code == 0
    assert "Example: python -m derivations guida" in result.output
    assert all(source in result.output for source in SOURCES)


@pytest.fixture
def unsound(monkeypatch):
    """One ledger with a wrong row and a check that raises, in the place of all others."""
    x = sp.Symbol("x")
    ledger = Ledger("wrong", "A ledger that does not hold")
    ledger.verified("(1)", "half of it", 2 * x)(lambda claim: x - claim)
    ledger.verified("(2)", "a check that does not run", x)(lambda claim: claim / "x")
    monkeypatch.setattr(derivations.sources, "ledger_of", lambda _: ledger)
    monkeypatch.setattr("derivations.written.ledger_of", lambda _: ledger)
    monkeypatch.setattr(
        "derivations.__main__.checked", lambda s, _: {k: derivations.sources.rows_of(k, 0, 9) for k in s}
    )


@pytest.mark.parametrize("form", ["--json", "--markdown", "--quiet"])
def test_what_does_not_hold_is_said(unsound, form):
    result = CliRunner().invoke(main, ["guida", form])
    assert result.exit_code == 1
    assert "-x" in result.output
    assert "TypeError" in result.output


def test_words_for_a_terminal():
    shown = text({"handbook": [stated(e) for e in ledger_of("handbook").entries]})
    assert "(19.105) at rest  corrected: static friction" in shown
    assert "\n    printed   f_s\n    right     F\n    residual  0\n" in shown
    assert "(numbers: against the motion in exact numbers, 256 starts)" in shown
    assert shown.endswith("none unsound")


@pytest.mark.skipif(os.name == "nt", reason="no such signal")
def test_an_interrupt_ends_it_cleanly():
    process = subprocess.Popen(
        command("rolling_isolation"),
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert "%" in process.stderr.readline()  # progress: the processes are at work
    os.killpg(process.pid, signal.SIGINT)
    out, error = process.communicate(timeout=30)
    assert process.returncode == 130
    assert out == ""
    assert error.splitlines()[-1] == "interrupted"
    assert "Traceback" not in error
