"""Every numbered equation of the rolling-friction paper has a row, and its tables are copied as printed."""

import re
from pathlib import Path

import pytest

from derivations.sources import ledger_of

SOURCE = Path(__file__).parents[3] / "shared" / "sources" / "rolling_friction_scaling.txt"
pytestmark = pytest.mark.skipif(not SOURCE.exists(), reason=f"no {SOURCE.name} beside the project")


def cells(n):
    """Return the cells of each data row of a printed table, below its two lines of headings."""
    block = SOURCE.read_text(encoding="utf-8").split(f"TABLE {n}:")[1].split("\n\n")[1]
    return [line.split("\t") for line in block.splitlines()[2:]]


def test_every_numbered_equation_has_a_row():
    printed = {f"({n})" for n in re.findall(r"\\quad \((\d+)\)\$\$", SOURCE.read_text(encoding="utf-8"))}
    assert printed == {"(1)"}
    assert printed <= {e.equation.split()[0] for e in ledger_of("rolling_isolation").entries}


@pytest.mark.parametrize("n", [1, 2])
def test_scale_factors_are_copied_as_printed(n):
    from derivations.rolling_isolation.factors import TABLE_1, TABLE_2

    table = (TABLE_1, TABLE_2)[n - 1]
    assert [row[3:] for row in cells(n)] == [entries.split() for entries in table.values()]


def test_ranges_are_copied_as_printed():
    from derivations.rolling_isolation.similarity import RANGES

    printed = [[c for c in row if "~" in c] for row in cells(3)]
    assert printed == [[c.replace(" ", "~") for c in row] for row in RANGES.values()]
