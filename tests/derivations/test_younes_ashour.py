"""Every numbered equation of the contact-damping paper has a row."""

import re
from pathlib import Path

import pytest

from derivations.sources import ledger_of

SOURCE = Path(__file__).parents[3] / "shared" / "sources" / "younes_ashour_contact_damping.txt"


@pytest.mark.skipif(not SOURCE.exists(), reason=f"no {SOURCE.name} beside the project")
def test_every_numbered_equation_has_a_row():
    printed = {f"({n})" for n in re.findall(r"\\tag\{(\d+)\}", SOURCE.read_text(encoding="utf-8"))}
    assert printed == {f"({n})" for n in range(1, 7)}
    assert printed <= {e.equation.split()[0] for e in ledger_of("younes_ashour").entries}
