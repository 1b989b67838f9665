"""The default run leaves no subject to the long tests alone."""

from random import Random

import pytest

from tests.longer import ALL, Case, drawn, uncovered

FILE = "tests/test_something.py"


def test_every_subject_runs_by_default(request):
    """Of all files that this run collects; the whole package in the default run."""
    if any("::" in argument for argument in request.config.args) or request.config.getoption("lf", False):
        pytest.skip("only some cases of a file were collected")
    wrong = uncovered(request.config.stash[ALL])
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("cases", "said"),
    [
        ([("a", False), ("a", True)], None),
        ([("a", True), ("a", True)], "keep one"),
        ([("a", True, "b"), ("b", False)], None),
        ([("a", True, "b"), ("b", True), ("b", False)], None),
        ([("a", True, "b"), ("b", True, "c"), ("c", False)], "names b, which does not run"),
        ([("a", True, "gone")], "names gone"),
        ([("a", False), ("a", True, "b"), ("b", False)], "needs no b"),
    ],
)
def test_what_is_left_to_long_tests_is_named(cases, said):
    found = uncovered(Case(FILE, *case) for case in cases)
    assert len(found) == (said is not None)
    assert all(line.startswith(f"{FILE}::a") and said in line for line in found)


def test_a_test_of_another_file_covers_nothing():
    (line,) = uncovered([Case(FILE, "a", True, "b"), Case("tests/test_other.py", "b", False)])
    assert "does not run by default in that file" in line


@pytest.mark.parametrize("seed", range(5))
def test_members_drawn_differ_in_every_parameter(seed):
    grid = [{"law": law, "width": width} for law in "abcdef" for width in range(4)]
    for number in range(1, 25):
        places = drawn(grid, number, Random(seed))
        assert len(set(places)) == number
        assert len({grid[k]["law"] for k in places}) == min(number, 6)
        assert len({grid[k]["width"] for k in places}) == min(number, 4)
    assert drawn(grid, 6, Random(seed)) != drawn(grid, 6, Random(seed + 1))


def test_members_without_parameters_of_their_own_are_drawn_too():
    assert sorted(drawn([{}] * 5, 5, Random(0))) == [0, 1, 2, 3, 4]
    assert len(set(drawn([{}] * 5, 2, Random(0)))) == 2
