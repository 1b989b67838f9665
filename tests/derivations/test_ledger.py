"""Every entry of the ledger holds, and its check rejects every changed claim; by default, one change of some.

A source is imported where its entries are tested, not where tests are collected: every worker collects all tests, and
most sources take seconds to derive what they enter. What takes all sources stands here, for one worker to import them.
"""

import random
from pathlib import Path

import pytest
import sympy as sp

import derivations.sources
from derivations.ledger import Verdict, evaluate, fails, mutants, stated
from derivations.sources import SOURCES, ledger_of
from derivations.written import markdown
from tests.derivations.costly_entries import COSTLY

FOLDER = Path(derivations.sources.__file__).parent


def label(entry):
    return f"{entry.source} {entry.equation} {entry.title}"


def checked(source):
    return [e for e in ledger_of(source).entries if e.check is not None]


def hold(entries):
    rows = [(label(entry), evaluate(entry)) for entry in entries]
    assert [(name, row.residual) for name, row in rows if row.residual != "0"] == []
    assert [name for name, row in rows if not row.sound] == [], "the printed form passes the check too"


@pytest.mark.parametrize("source", SOURCES)
def test_derivations_leave_nothing_of_their_claims(source):
    hold(entry for entry in checked(source) if entry.equation not in COSTLY.get(source, ()))


@pytest.mark.long(beside="test_derivations_leave_nothing_of_their_claims")
@pytest.mark.parametrize("source", COSTLY)
def test_costly_derivations_leave_nothing_of_their_claims(source):
    found = [entry for entry in checked(source) if entry.equation in COSTLY[source]]
    assert {entry.equation for entry in found} == COSTLY[source]
    hold(found)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("source", SOURCES)
def test_a_changed_claim_fails(source):
    passed = []
    for entry in checked(source):
        draw = random.Random(label(entry))
        if draw.random() < 0.08:
            name, claim = draw.choice(list(mutants(entry.right)))
            passed += [] if fails(entry, claim) else [(label(entry), name)]
    assert passed == []


@pytest.mark.long(beside="test_a_changed_claim_fails")
@pytest.mark.parametrize("source", SOURCES)
def test_no_changed_claim_passes(source):
    tried = [(entry, name, claim) for entry in checked(source) for name, claim in mutants(entry.right)]
    assert [(label(entry), name) for entry, name, claim in tried if not fails(entry, claim)] == []


@pytest.mark.parametrize("source", SOURCES)
def test_what_is_not_proved_says_why(source):
    for entry in ledger_of(source).entries:
        if entry.verdict in (Verdict.CORRECTED, Verdict.UNVERIFIABLE):
            assert entry.note, label(entry)
        if entry.verdict == Verdict.CORRECTED:
            assert entry.printed, label(entry)
        if any(claim.has(sp.Float) for claim in entry.right):
            assert entry.numbers, label(entry)


def test_every_ledger_is_listed():
    files = [*FOLDER.glob("*.py"), *FOLDER.glob("*/__init__.py")]
    having = {p.parent.name if p.name == "__init__.py" else p.stem for p in files if "\nLEDGER = " in p.read_text()}
    assert having == set(SOURCES)
    assert [ledger_of(s).source for s in SOURCES] == list(SOURCES)


def test_the_readme_is_current():
    found = {source: [stated(e) for e in ledger_of(source).entries] for source in SOURCES}
    current = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert current == markdown(found), "run: python -m derivations --markdown > derivations/README.md"
