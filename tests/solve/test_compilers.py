"""numba and llvmlite: what the package takes from inside them, in the versions that it declares."""

import importlib
import inspect
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from numba.core.registry import cpu_target
from numba.np.arrayobj import make_array, populate_array
from packaging.requirements import Requirement

from symfric.codegen import loop_loader, numba_types
from symfric.codegen.array_table import Table

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LOOP = """
from dataclasses import dataclass

from symfric.codegen.array_table import ArraySet, Integers, Reals
from symfric.codegen.numba_types import compiled, opener, part


@dataclass(frozen=True, eq=False, kw_only=True)
class Work(ArraySet):
    x: Reals
    k: Integers


_at_address = opener(Work)


@compiled(inline=True, fused=True)
def _added(w):
    return w.x[0] + w.x[1]


@part
def _grow(w):
    w.x[0] = _added(w)


@compiled
def launch(address, fresh):
    w = _at_address(address)
    if fresh:
        w.x[0] = 0.0
    _grow(w)
    return w.k[0] // w.k[1]
"""


@pytest.mark.parametrize("name", ["numba", "llvmlite"])
def test_the_installed_version_lies_within_the_declared_bounds(name):
    (declared,) = (r for r in map(Requirement, PROJECT["dependencies"]) if r.name == name)
    assert sorted(s.operator for s in declared.specifier) == ["<", ">="]
    assert version(name) in declared.specifier


@pytest.mark.parametrize(
    ("function", "names"),
    [
        (make_array, ["array_type"]),
        (populate_array, ["array", "data", "shape", "strides", "itemsize", "meminfo"]),
    ],
)
def test_arrays_are_made_of_the_same_parts(function, names):
    taken = inspect.signature(function).parameters
    assert list(taken)[: len(names)] == names
    assert all(p.default is not p.empty for p in list(taken.values())[len(names) :])


def test_every_option_of_the_decorator_exists(monkeypatch):
    used = {}
    monkeypatch.setattr(numba_types, "njit", lambda **options: used.update(options) or (lambda function: function))
    numba_types.compiled(inline=True, fused=True, ieee_division=True)(lambda: None)
    numba_types.part(lambda: None)
    assert {"_nrt", "forceinline", "no_cpython_wrapper", "fastmath", "error_model", "inline"} <= set(used)
    assert [name for name in used if not hasattr(cpu_target.options, name)] == []


def test_a_loop_is_compiled_kept_and_called_from_the_disk(tmp_path, monkeypatch):
    (tmp_path / "loop_of_a_test.py").write_text(LOOP)
    monkeypatch.setenv("SYMFRIC_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(loop_loader, "_opened", {})
    work = importlib.import_module("loop_of_a_test").Work(x=np.array([5.0, 0.25]), k=np.array([7, 2]))
    table = Table(work)
    launch = loop_loader.load_loop("loop_of_a_test", "a test").launch
    assert (launch(table, True), launch(table, False), work.x[0]) == (3, 3, 0.5)

    monkeypatch.setattr(loop_loader, "_opened", {})
    monkeypatch.setattr(loop_loader, "_compiled", None)  # what is on the disk is enough
    again = loop_loader.load_loop("loop_of_a_test", "a test").launch
    assert (again(table, False), work.x[0]) == (3, 0.75)
    work.k[1] = 0
    with pytest.raises(ArithmeticError, match="inside a test"):
        again(table, False)
    sys.modules.pop("loop_of_a_test", None)
