"""No check of the ledger is blind: every changed claim leaves a residual."""

import pytest

from derivations.ledger import fails, mutants
from derivations.sources import SOURCES, ledger_of

pytestmark = pytest.mark.long  # test_ledger.py tries one change of some entries
CHECKED = [e for s in SOURCES for e in ledger_of(s).entries if e.check is not None]


@pytest.mark.parametrize("entry", CHECKED, ids=lambda e: f"{e.source} {e.equation} {e.title}")
def test_a_changed_claim_is_rejected(entry):
    for name, claim in mutants(entry.right):
        assert fails(entry, claim), name
