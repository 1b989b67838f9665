"""A closed form that returns a wrong number makes a derivation fail, not only a test of the package."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SPOILED = {  # what is multiplied, by how much, the ledger that must notice
    "averaged decay time": ("symfric.theory.transient", "_decay_time", 1.02, "numbers"),
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
RUN = """
import dataclasses, importlib, sys
import sympy as sp
module, name, factor, source = importlib.import_module(sys.argv[1]), sys.argv[2], float(sys.argv[3]), sys.argv[4]
right = getattr(module, name)

def spoiled(*given, **named):
    found = right(*given, **named)
    if named.get("symbolic"):
        return found
    if hasattr(found, "_replace"):
        return found._replace(damping=found.damping * factor)
    if dataclasses.is_dataclass(found):
        return dataclasses.replace(found, value=found.value * factor)
    return found * factor

setattr(module, name, spoiled)
from derivations.ledger import evaluate
from derivations.sources import ledger_of
rows = [e for e in ledger_of(source).entries if e.check is not None and any(c.has(sp.Float) for c in e.right)]
print(sum(not evaluate(e).sound for e in rows))
"""


@pytest.mark.parametrize("name", SPOILED)
def test_a_wrong_number_fails_a_derivation(name):
    module, function, factor, source = SPOILED[name]
    command = [sys.executable, "-c", RUN, module, function, str(factor), source]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=300)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) >= 1


def test_right_numbers_pass():
    command = [sys.executable, "-c", RUN, "symfric.theory.transient", "_decay_time", "1.0", "numbers"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=300)
    assert done.stdout.strip() == "0", done.stderr
