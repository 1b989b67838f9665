"""Cases that a run of the tests leaves out unless it is asked for the long ones.

``python -m pytest -m long`` runs them. A test keeps at least one case in the default run; one whose every case is long names
the test of its file that covers its subject by default: ``@pytest.mark.long(beside="test_of_a_smaller_one")``.
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from random import Random
from typing import NamedTuple

import pytest


class Case(NamedTuple):
    """A collected case: its file, its test, whether it is long, and the default test that its mark names."""

    file: str
    test: str
    long: bool
    beside: str | None = None


ALL = pytest.StashKey[list[Case]]()  # every collected case, before the long ones are deselected


def longer(cases: Iterable, of: Collection) -> list:
    """Return the cases, those named in `of` marked as long: others cover what they test, with less of it."""
    cases = list(cases)
    missing = [case for case in of if case not in cases]
    assert not missing, f"{missing} are not among the cases"
    return [pytest.param(case, marks=pytest.mark.long) if case in of else case for case in cases]


def drawn(values: Sequence[Mapping[str, object]], number: int, rng: Random) -> list[int]:
    """Return the places of `number` cases, drawn so that as many values of each parameter as possible occur.

    Parameters
    ----------
    values : sequence of mappings
        Parameters of each case by name.
    number : int
        Number of cases, at most ``len(values)``.
    rng : Random
        Source of the order in which the cases are considered.
    """
    order = rng.sample(range(len(values)), len(values))
    seen: set[tuple[str, object]] = set()
    taken: list[int] = []
    for fresh in range(max(map(len, values)), -1, -1):  # first the cases of which most values are new
        for k in order:
            new = values[k].items() - seen
            if len(taken) < number and k not in taken and len(new) >= fresh:
                taken.append(k)
                seen |= new
    return taken


def uncovered(cases: Iterable[Case]) -> list[str]:
    """Return a line for each test that the default run leaves out although nothing else covers its subject."""
    default: dict[tuple[str, str], bool] = defaultdict(bool)
    named: dict[tuple[str, str], str | None] = {}
    for case in cases:
        test = case.file, case.test
        default[test] |= not case.long
        named[test] = named.get(test) or case.beside
    wrong = []
    for (file, test), runs in default.items():
        beside = named[file, test]
        if runs and beside:
            wrong.append(f"{file}::{test} runs by default and needs no {beside} beside it")
        elif not runs and not beside:
            wrong.append(f"{file}::{test} has long cases alone; keep one, or name the test beside it: long(beside=...)")
        elif not runs and not default.get((file, beside), False):
            wrong.append(f"{file}::{test} names {beside}, which does not run by default in that file")
    return wrong
