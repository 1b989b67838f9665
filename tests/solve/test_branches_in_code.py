"""Comparisons, logical operations and choices in machine code: CasADi's values but for fused products, in parts too."""

import ctypes

import casadi as ca
import numpy as np
import pytest

from symfric.codegen import llvm_ir
from symfric.codegen.functions import compile_functions
from symfric.codegen.llvm_ir import Instructions

SPECIAL = [0.0, -0.0, 1.0, np.inf, -np.inf, np.nan]


def drawn(seed, n):
    """Return a function of random tests and choices, of which numbers are added and multiplied too."""
    rng = np.random.default_rng(seed)
    x = ca.SX.sym("x", 6)
    numbers, tests = list(ca.vertsplit(x)), [x[0] < x[1]]
    pick = lambda of: of[rng.integers(max(0, len(of) - 30), len(of))]  # noqa: E731  # mostly of the newest
    for _ in range(n):
        a, b, c, d = pick(numbers), pick(numbers), pick(tests), pick(tests)
        kind = rng.integers(0, 9)
        if kind < 4:
            tests.append([a < b, a <= b, a == b, a != b][kind])
        elif kind < 7:
            tests.append([ca.logic_and(c, d), ca.logic_or(c, d), ca.logic_not(c)][kind - 4])
        numbers.append([ca.if_else(c, a, b), ca.if_else(a, b, 0), c * a, a + d, ca.fmax(a, b) - c][rng.integers(0, 5)])
    return ca.Function("branches", [x], [ca.vertcat(*numbers, *tests)])


def value_of(function, code, x):
    out = np.empty(function.nnz_out(0))
    ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(code.addresses["branches"])(x.ctypes.data, out.ctypes.data)
    return out


@pytest.mark.one_in(12)
@pytest.mark.parametrize("part", [None, 7, 40])
@pytest.mark.parametrize("seed", range(4))
def test_branches_have_the_values_of_casadi(seed, part, monkeypatch):
    if part:
        monkeypatch.setattr(llvm_ir, "WHOLE", 0)
        monkeypatch.setattr(llvm_ir, "PART", part)
    function, rng = drawn(seed, 150), np.random.default_rng(100 + seed)
    code = compile_functions([function])
    for k in range(60):
        x = np.where(rng.random(6) < 0.3, rng.choice(SPECIAL, 6), rng.uniform(-2, 2, 6)) if k else np.zeros(6)
        right = np.array(function(x)).ravel()
        assert value_of(function, code, np.ascontiguousarray(x)) == pytest.approx(right, rel=1e-13, abs=0, nan_ok=True)


def test_a_function_of_many_tests_is_cut():
    """They are the longest to compile, in a time that grows with the square of their number."""
    few, many = drawn(1, 150), drawn(1, 3 * llvm_ir.TESTS)
    assert Instructions.of(few).part == few.n_instructions()
    assert Instructions.of(many).part == llvm_ir.PART < many.n_instructions() < llvm_ir.WHOLE
