"""Operations that mean the same for numbers in Python, for numbers in compiled code, and for `Lanes`.

Functions written with these, with arithmetic and with comparisons serve all three: see
`symfric.solve.loop.statements`. This module does without numba, which takes half a second to import;
`symfric.codegen.numba_types` says what its code makes of them.
"""

from typing import Any

import numpy as np

from symfric.codegen.lane_values import Lanes, Value


def _code(*values: Value) -> Any:
    """Return what writes the code of the first value in lanes; None for numbers alone."""
    return next((v.g for v in values if isinstance(v, Lanes)), None)


def larger(a: Value, b: Value) -> Value:
    """Return the larger of two numbers, the first if one is NaN."""
    g = _code(a, b)
    return max(a, b) if g is None else g.max(b, a)


def smaller(a: Value, b: Value) -> Value:
    """Return the smaller of two numbers, the first if one is NaN."""
    g = _code(a, b)
    return min(a, b) if g is None else g.min(b, a)


def choose(condition: Value, a: Value, b: Value) -> Value:
    """Return a where a condition holds, elsewhere b; both are computed."""
    g = _code(condition, a, b)
    return (a if condition else b) if g is None else g.select(condition, a, b)


def bits_of(x: Value) -> Value:
    """Return the bits of a floating-point number as a whole number."""
    return x.g.bits(x) if isinstance(x, Lanes) else np.float64(x).view(np.int64)


def of_bits(n: Value) -> Value:
    """Return the floating-point number of some bits."""
    return n.g.from_bits(n) if isinstance(n, Lanes) else np.int64(n).view(np.float64)
