"""No check of the ledger is blind: a changed claim leaves a residual. Beside test_ledger.py, to run at the same time."""

import pytest

from derivations.ledger import fails, mutants
from derivations.sources import SOURCES, ledger_of

CHECKED = [e for s in SOURCES for e in ledger_of(s).entries if e.check is not None]


@pytest.mark.parametrize("entry", CHECKED, ids=lambda e: f"{e.source} {e.equation} {e.title}")
def test_a_changed_claim_is_rejected(entry):
    for name, claim in mutants(entry.right):
        assert fails(entry, claim), name
