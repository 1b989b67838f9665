"""SymPy expressions as vectorised NumPy functions, integrals by Gauss-Legendre quadrature included."""

from functools import lru_cache

import numpy as np
import sympy as sp

NODES = 48  # of the quadrature; exact to rounding for the clustered integrands of `effective`


@lru_cache(maxsize=8)
def gauss_legendre(n: int = NODES) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(n)
    return 0.5 * (x + 1), 0.5 * w


def expand_integrals(expr: sp.Expr) -> sp.Expr:
    """Replace every definite integral by its Gauss-Legendre sum of `NODES` terms."""
    nodes, weights = gauss_legendre()

    def as_sum(integral):
        (variable, low, high) = integral.limits[0]
        body = integral.function
        terms = [
            float(w) * body.xreplace({variable: low + (high - low) * float(x)})
            for x, w in zip(nodes, weights, strict=True)
        ]
        return (high - low) * sp.Add(*terms)

    return expr.replace(lambda e: isinstance(e, sp.Integral), as_sum)


def _at_the_edge(inverse):
    """Return asin or acos that takes an argument which rounding has pushed beyond 1 for 1."""

    def evaluate(x):
        return inverse(np.where(np.abs(x) < 1 + 1e-12, np.clip(x, -1.0, 1.0), x))

    return evaluate


@lru_cache(maxsize=256)
def numeric_function(symbols: tuple[sp.Symbol, ...], expr: sp.Expr):
    """Return ``f(*arrays) -> array`` that evaluates `expr` elementwise and broadcasts constants."""
    edges = {"arcsin": _at_the_edge(np.arcsin), "arccos": _at_the_edge(np.arccos)}
    compiled = sp.lambdify(symbols, expand_integrals(expr), modules=[edges, "numpy", "scipy"], cse=True)

    def evaluate(*arguments):
        arrays = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in arguments)) if arguments else []
        with np.errstate(all="ignore"):
            result = np.asarray(compiled(*arrays), dtype=float)
        return np.broadcast_to(result, arrays[0].shape) if arrays else result

    return evaluate
