"""Random designs: none has a better neighbour, none violates its requirement, none depends on the units."""

import pytest

from tests.design.random_designs import printed, table
from tests.longer import longer


@pytest.mark.parametrize("count", longer([2, 200], [200]))
def test_random_designs_hold(count):
    rows = table(count)
    for row in rows:
        assert row.better == row.violated == row.changed == 0, printed(rows)
        assert row.none < max(2, 0.6 * row.number), printed(rows)
