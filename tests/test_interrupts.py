"""An interrupt ends the command with 130 and one line, wherever it comes: while modules are loaded, at work, at the end."""

import os
import subprocess
import sys

import pytest

from symfric.scenefile.starters import starter

# Imported by Python before anything else: sends an interrupt when a module is looked for, or when the process ends.
SITE = """
import atexit, os, signal, sys
target = os.environ["INTERRUPTED_AT"]
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == os.environ["INTERRUPTED_AT"]:
            sys.meta_path.remove(self)
            signal.raise_signal(signal.SIGINT)
        return None
signal.signal(signal.SIGINT, signal.default_int_handler)
if target == "the end":
    atexit.register(signal.raise_signal, signal.SIGINT)
else:
    sys.meta_path.insert(0, Finder())
"""
EARLY = ["lazy_loader", "click", "symfric.cli", "symfric.cli.console"]
MODULES = [
    *("sympy", "numpy", "symfric.model.symbols", "symfric.scenefile", "symfric.scenefile.read", "pydantic", "casadi"),
    *("sympy.core.cache", "mpmath", "symfric.solve.routes", "scipy", "numpy.linalg", "symfric.model.scene"),
    *(
        "symfric.report.study",
        "symfric.report.study.page",
        "matplotlib",
        "matplotlib.figure",
        "jinja2",
        "llvmlite.binding",
    ),
    *("symfric.solve.taylor.route", "scipy.optimize", "symfric.report.study.data", "symfric.codegen.loop_loader"),
]


@pytest.mark.one_in(3)
@pytest.mark.skipif(os.name != "posix", reason="interrupts of POSIX")
@pytest.mark.parametrize(
    "place",
    [
        "symfric.model.public_names",
        "sympy",
        "the end",
        *(pytest.param(m, marks=pytest.mark.long) for m in EARLY + MODULES),
    ],
)
def test_an_interrupt_ends_with_130_wherever_it_comes(place, tmp_path):
    (tmp_path / "sitecustomize.py").write_text(SITE)
    (tmp_path / "s.toml").write_text(starter("coulomb_oscillator"))
    words = ["explain", "s.toml"] if place in ("sympy", "the end") else ["study", "s.toml", "-o", "out", "-q"]
    done = subprocess.run(
        [sys.executable, "-m", "symfric", *words],
        cwd=tmp_path,
        env={**os.environ, "INTERRUPTED_AT": place, "PYTHONPATH": f"{tmp_path}{os.pathsep}{os.getcwd()}"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 130, done.stderr
    assert done.stderr == "interrupted\n"
    assert not [p.name for p in tmp_path.rglob("*.part")]


def test_a_program_that_imports_the_package_keeps_its_own_interrupts():
    code = "import signal, symfric, symfric.cli; print(signal.getsignal(signal.SIGINT) is signal.default_int_handler)"
    code = f"import signal; signal.signal(signal.SIGINT, signal.default_int_handler); {code}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"
