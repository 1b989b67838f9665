"""Random designs: none has a better neighbour, none violates its requirement, none depends on the units."""

import pytest

from tests.design.random_designs import KINDS, Row, examine, printed, table
from tests.longer import longer


@pytest.mark.parametrize("kind", longer(KINDS, [kind for kind in KINDS if kind not in ("absorber", "settling")]))
def test_a_random_design_holds(kind):
    row = Row(kind)
    examine(kind, 0, row)
    assert row.number == 1
    assert row.better == row.violated == row.changed == row.none == 0, printed([row])


@pytest.mark.long(beside="test_a_random_design_holds")
def test_random_designs_hold():
    rows = table(200)
    for row in rows:
        assert row.better == row.violated == row.changed == 0, printed(rows)
        assert row.none < max(2, 0.6 * row.number), printed(rows)
