"""Every numbered equation of the handbook's section has a row."""

import re
from pathlib import Path

import pytest

from derivations.sources import ledger_of

SOURCE = Path(__file__).parents[3] / "shared" / "sources" / "handbook_19_5_interface_damping.txt"


@pytest.mark.skipif(not SOURCE.exists(), reason=f"no {SOURCE.name} beside the project")
def test_every_numbered_equation_has_a_row():
    text = SOURCE.read_text(encoding="utf-8")
    printed = {f"(19.{n})" for n in re.findall(r"ð19:(\d+)Þ", text)} | {
        f"({n})" for n in re.findall(r"ð([ivx]+)Þ", text)
    }
    assert len(printed) == 6 + 15
    assert printed <= {e.equation.split()[0] for e in ledger_of("handbook").entries}
