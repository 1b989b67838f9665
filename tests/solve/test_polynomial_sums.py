"""Sums of Taylor polynomials in vectors have the bits of those for one number."""

import ctypes

import numpy as np
import pytest

from symfric.codegen.functions import compile_functions
from symfric.codegen.polynomial_sums import polynomial_sums
from symfric.solve.loop.stepping.series import reach


@pytest.mark.one_in(9)
@pytest.mark.parametrize("order", [3, 4, 5, 6, 7, 17, 20, 28, 60])
@pytest.mark.parametrize(("states", "guards"), [(2, 2), (1, 0), (5, 3)])
def test_same_bits_as_for_one_number(states, guards, order):
    rng = np.random.default_rng(order)
    rows = states + guards
    code = compile_functions([reach(states, guards, order), polynomial_sums("sums", states, guards, order)])
    for scale in (1.0, 1e-4, 1e3):
        step = scale * np.array([0.7, 0.9])
        c = rng.normal(size=(rows, order + 1)) / scale ** np.arange(order + 1)
        found = []
        for address in (code.addresses["reach"], code.addresses["sums"]):
            out = np.full(rows + 1, np.nan)
            ctypes.CFUNCTYPE(None, *(3 * [ctypes.c_void_p]))(address)(step.ctypes.data, c.ctypes.data, out.ctypes.data)
            found.append(out)
        assert np.array_equal(*found, equal_nan=True)
        assert np.isnan(found[1][-1]), "nothing is written behind the rows"
        powers = step[0] ** np.arange(1, order + 1), step[1] ** np.arange(1, order + 1)
        exact = [*(c[:states, 1:] @ powers[0]), *(np.abs(c[states:, 1:]) @ powers[1])]
        assert found[1][:-1] == pytest.approx(exact, rel=1e-12, abs=1e-12)
