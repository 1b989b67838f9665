"""The formulas of ``symfric.theory`` are the single copy, and the derivations test every one of them."""

import ast
import inspect
import re
from functools import cache
from pathlib import Path

import pytest

import derivations.sources
import symfric
from symfric.theory import (
    absorber,
    belt,
    decay_record,
    drive,
    foundation,
    plane,
    presliding,
    scaling,
    transient,
    waviness,
)

FOLDER = Path(derivations.sources.__file__).parent
PACKAGE = Path(symfric.__file__).parent


@cache
def used():
    """Return every name and attribute that stands in a derivation."""
    own = [path for path in FOLDER.rglob("*.py") if FOLDER / "evidence" not in path.parents]
    nodes = [node for path in own for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))]
    return {n.attr for n in nodes if isinstance(n, ast.Attribute)} | {n.id for n in nodes if isinstance(n, ast.Name)}


CLOSED_FORMS = [
    *(f"{module.__name__}.{name}" for module in (belt, drive, plane) for name in module.__all__ if name != "SYMBOLS"),
    *(
        f"{module.__name__}.{name}"
        for module in (absorber, decay_record, foundation, plane, presliding, scaling, transient, waviness)
        for name, f in vars(module).items()
        if inspect.isfunction(f) and inspect.unwrap(f).__module__ == module.__name__ and not name.startswith("_")
    ),
]
METHODS = ["average", "separate", "hopf", "expansion", "routh_hurwitz", "characteristic_coefficients", "arc_mean"]
CLASSES = {"SlopeLimits", "PositioningError", "SlidesCycle"}  # what functions return
CLASSES |= {"BallRolls", "DiscStop", "InclineState", "QuenchComparison", "VibrationComparison"}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", [*CLOSED_FORMS, *METHODS])
def test_every_closed_form_is_derived(name):
    last = name.rpartition(".")[2]
    assert last in used() | CLASSES


def test_files_of_derivations_that_the_package_names_exist():
    named = {
        path
        for file in PACKAGE.rglob("*.py")
        for path in re.findall(r"derivations/(\w+(?:\.py)?)", file.read_text(encoding="utf-8"))
    }
    assert named
    assert [path for path in sorted(named) if not (FOLDER / path).exists()] == []
