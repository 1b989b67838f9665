"""Cases that a run of the tests leaves out unless it is asked for the long ones."""

from collections.abc import Collection, Iterable

import pytest


def longer(cases: Iterable, of: Collection) -> list:
    """Return the cases, those named in `of` marked as long: others cover what they test, with less of it."""
    cases = list(cases)
    missing = [case for case in of if case not in cases]
    assert not missing, f"{missing} are not among the cases"
    return [pytest.param(case, marks=pytest.mark.long) if case in of else case for case in cases]
