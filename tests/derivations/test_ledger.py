"""Every entry of the ledger holds, and its check rejects every changed claim; by default, one change of some."""

import random

import pytest
import sympy as sp

from derivations.ledger import Verdict, evaluate, fails, mutants
from derivations.sources import SOURCES, ledger_of

ENTRIES = [e for s in SOURCES for e in ledger_of(s).entries]
CHECKED = [e for e in ENTRIES if e.check is not None]


def label(entry):
    return f"{entry.source} {entry.equation} {entry.title}"


@pytest.mark.parametrize("entry", CHECKED, ids=label)
def test_the_derivation_leaves_nothing_of_the_claim(entry):
    row = evaluate(entry)
    assert row.residual == "0"
    assert row.sound, "the printed form passes the check too"
    draw = random.Random(label(entry))
    if draw.random() < 0.08:
        name, claim = draw.choice(list(mutants(entry.right)))
        assert fails(entry, claim), name


@pytest.mark.long(beside="test_the_derivation_leaves_nothing_of_the_claim")
@pytest.mark.parametrize("entry", CHECKED, ids=label)
def test_no_changed_claim_passes(entry):
    for name, claim in mutants(entry.right):
        assert fails(entry, claim), name


@pytest.mark.parametrize("entry", ENTRIES, ids=label)
def test_what_is_not_proved_says_why(entry):
    if entry.verdict in (Verdict.CORRECTED, Verdict.UNVERIFIABLE):
        assert entry.note
    if entry.verdict == Verdict.CORRECTED:
        assert entry.printed
    if any(claim.has(sp.Float) for claim in entry.right):
        assert entry.numbers
