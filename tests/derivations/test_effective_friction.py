"""No law of the package is without a proof of its mean under fast vibration."""

import inspect

import pytest

from derivations.sources import ledger_of
from symfric.model import laws
from symfric.model.laws import dry

# laws with memory have no coefficient at a speed alone, so none that shaking would make effective
NAMES = [n for n, f in vars(laws).items() if inspect.isfunction(f) and inspect.unwrap(f).__module__ == dry.__name__]


@pytest.mark.parametrize("name", [n for n in NAMES if not n.startswith("_")])
def test_every_law_has_a_row(name):
    words = name.replace("_", " ")
    assert any(words in entry.title.lower() for entry in ledger_of("effective_friction").entries)


@pytest.mark.parametrize("shape", laws.SHAPES)
def test_every_regularisation_has_a_row(shape):
    assert any(shape in entry.title for entry in ledger_of("effective_friction").entries)
