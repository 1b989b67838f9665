"""A closed form that returns a wrong number makes a derivation fail, not only a test of the package."""

import dataclasses
import importlib
import sys

import pytest
import sympy as sp

from derivations.ledger import evaluate
from tests.longer import longer

SPOILED = {  # what is multiplied, by how much, the ledger that must notice
    "averaged decay time": ("symfric.theory.transient.averaged", "_decay_time", 1.02, "numbers"),
    "mean friction": ("symfric.theory.transient", "mean_friction", 1.001, "numbers"),
    "damping of the least peak": ("symfric.theory.absorber", "least_peak", 1.001, "numbers"),
    "damping of the least variance": ("symfric.theory.absorber", "least_variance", 1.001, "numbers"),
    "damping of the fixed points": ("symfric.theory.absorber", "fixed_points", 1.001, "numbers"),
    "damping of the fastest decay": ("symfric.theory.absorber", "fastest_decay", 1.001, "numbers"),
    "damping of the widest stability": ("symfric.theory.absorber", "widest_stability", 1.001, "numbers"),
    "damping of a sprung foundation": ("symfric.theory.foundation", "at_stiffness", 1.001, "foundation"),
    "power of the excitation": ("symfric.theory.belt", "mean_power", 1.001, "numbers"),
    "sticking on the belt": ("symfric.theory.belt", "stick_slip_amplitude", 1.0001, "numbers"),
    "stop of a drive": ("symfric.theory.drive", "positioning_error", 1.001, "guida"),
    "threshold of a drawn slide": ("symfric.theory.drive", "threshold", 1.001, "guida"),
}


def rows_of(monkeypatch, source, about):
    """Return the rows with decimal numbers of a ledger that is written anew, those about something first."""
    name = f"derivations.{source}"
    for module in [m for m in sys.modules if m == name or m.startswith(f"{name}.")]:
        monkeypatch.delitem(sys.modules, module)
    rows = importlib.import_module(name).LEDGER.entries
    numeric = [e for e in rows if e.check is not None and any(c.has(sp.Float) for c in e.right)]
    return sorted(numeric, key=lambda e: about not in e.equation)


@pytest.fixture(autouse=True)
def forgotten():
    """A ledger that the test was the first to load is loaded anew by others: it may hold wrong numbers."""
    before = set(sys.modules)
    yield
    sources = {f"derivations.{source}" for *_, source in SPOILED.values()}
    for module in [m for m in sys.modules if ".".join(m.split(".")[:2]) in sources and m not in before]:
        del sys.modules[module]


def multiplied(right, factor):
    """Return a function whose number is wrong by a factor."""

    def spoiled(*given, **named):
        found = right(*given, **named)
        if named.get("symbolic"):
            return found
        if hasattr(found, "_replace"):
            return found._replace(damping=found.damping * factor)
        if dataclasses.is_dataclass(found):
            return dataclasses.replace(found, value=found.value * factor)
        return found * factor

    return spoiled


@pytest.mark.one_in(12)
@pytest.mark.parametrize(
    "name", longer(SPOILED, [n for n in SPOILED if n.startswith("damping of") and "peak" not in n])
)
def test_a_wrong_number_fails_a_derivation(name, monkeypatch):
    module, function, factor, source = SPOILED[name]
    right = getattr(importlib.import_module(module), function)
    monkeypatch.setattr(importlib.import_module(module), function, multiplied(right, factor))
    assert not all(evaluate(e).sound for e in rows_of(monkeypatch, source, function.strip("_")))


@pytest.mark.long(beside="test_a_wrong_number_fails_a_derivation")
@pytest.mark.parametrize("source", ["numbers", "guida"])
def test_right_numbers_pass(source, monkeypatch):
    assert all(evaluate(e).sound for e in rows_of(monkeypatch, source, ""))
