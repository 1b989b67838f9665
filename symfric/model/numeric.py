"""SymPy expressions as NumPy functions; the quadrature nodes of a definite integral are an array axis."""

import math
from collections.abc import Callable, Sequence
from functools import cache, lru_cache, partial
from typing import TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from symfric.locks import SYMBOLIC, alone
from symfric.model.tree import parts_of

NODES = 48  # quadrature nodes; exact to rounding for the integrands of an averaged law
LARGEST = 1 << 20  # most array entries at once in nested quadrature
Rule = tuple[np.ndarray, np.ndarray]
ArrayFunction: TypeAlias = Callable[..., np.ndarray]
ArrayFunctions: TypeAlias = Callable[..., list[np.ndarray]]
_Elementwise = Callable[[np.ndarray], np.ndarray]
Floats: TypeAlias = Sequence[float] | np.ndarray  # one-dimensional numbers as a user may give them
_IN_NUMPY = (
    *(sp.exp, sp.log, sp.sin, sp.cos, sp.tan, sp.asin, sp.acos, sp.atan, sp.sinh, sp.cosh, sp.tanh, sp.Abs),
    *(sp.Max, sp.Min, sp.Piecewise, sp.sign),
)


@lru_cache(maxsize=16)
def gauss_legendre(n: int = NODES) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(n)
    return 0.5 * (x + 1), 0.5 * w


@alone(SYMBOLIC)
def numeric(symbols: Sequence[sp.Symbol], entries: Sequence[sp.Expr], rule: Rule | int = NODES) -> ArrayFunctions:
    """Return ``f(*arrays) -> list of arrays`` that evaluates several expressions elementwise.

    Parameters
    ----------
    symbols : sequence of Symbol
    entries : sequence of Expr
        May hold definite integrals, also nested ones, with limits in the symbols; each becomes a sum.
    rule : pair of arrays or int
        Nodes on [0, 1] and weights of each sum; a number of nodes stands for those of Gauss and Legendre.

    Returns
    -------
    callable
        Takes one array or number per symbol, which broadcast.
    """
    rule = gauss_legendre(rule) if isinstance(rule, int) else rule
    return partial(_compiled(tuple(symbols), tuple(entries)), rule)


def numeric_function(symbols: Sequence[sp.Symbol], expr: sp.Expr, rule: Rule | int = NODES) -> ArrayFunction:
    """Return ``f(*arrays) -> array`` that evaluates one expression; see `numeric`."""
    evaluate = numeric(symbols, (expr,), rule)
    return lambda *arguments: evaluate(*arguments)[0]


@lru_cache(maxsize=256)
def _compiled(symbols: tuple[sp.Symbol, ...], entries: tuple[sp.Expr, ...]) -> Callable[..., list[np.ndarray]]:
    """Return ``f(rule, *arrays)``; one compiled function serves all quadrature rules."""
    integrals: dict[sp.Integral, sp.Symbol] = {}
    for e in entries:
        _collect(e, integrals)
    outer = [e.xreplace(integrals) for e in entries]
    modules = [_EDGES, "numpy"]
    if any(not isinstance(f, _IN_NUMPY) for e in outer for f in parts_of(e, sp.Function)):
        modules.append("scipy")  # slow to load
    plain = sp.lambdify((*symbols, *integrals.values()), outer, modules=modules, cse=True)
    sums = [_quadrature(symbols, integral) for integral in integrals]
    depth = max((_depth(e) for e in entries), default=0)

    def evaluate(rule: Rule, *arguments: ArrayLike) -> list[np.ndarray]:
        given = [np.asarray(a, dtype=float) for a in arguments]
        shape = _shape(given)
        size, nodes = math.prod(shape), rule[0].size
        if size > 1 and size * nodes**depth > LARGEST:
            rows = max(1, LARGEST // nodes**depth)
            flat = [np.broadcast_to(a, shape).ravel() for a in given]
            parts = [evaluate(rule, *(a[k : k + rows] for a in flat)) for k in range(0, size, rows)]
            return [np.concatenate(column).reshape(shape) for column in zip(*parts, strict=True)]
        with np.errstate(all="ignore"):
            values = plain(*given, *(s(rule, *given) for s in sums))
        values = [np.asarray(v, dtype=float) for v in values]
        return [v if v.shape == shape else np.broadcast_to(v, shape) for v in values]

    return evaluate


def _shape(arguments: Sequence[np.ndarray]) -> tuple[int, ...]:
    """Return the common shape of some arrays; faster than `numpy.broadcast_shapes`."""
    shapes = {a.shape for a in arguments}
    return shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)


def _at_the_edge(inverse: _Elementwise) -> _Elementwise:
    """Return asin or acos with its argument clipped to [-1, 1], which rounding may exceed."""

    def evaluate(x: np.ndarray) -> np.ndarray:
        return inverse(np.where(np.abs(x) < 1 + 1e-12, np.clip(x, -1.0, 1.0), x))

    return evaluate


_EDGES = {"arcsin": _at_the_edge(np.arcsin), "arccos": _at_the_edge(np.arccos)}


def _collect(expr: sp.Expr, integrals: dict[sp.Integral, sp.Symbol]) -> None:
    """Replace the outermost integrals of an expression by symbols, and collect them."""
    if isinstance(expr, sp.Integral):
        integrals.setdefault(expr, sp.Dummy(f"integral_{len(integrals)}"))
    elif expr.has(sp.Integral):
        for argument in expr.args:
            _collect(argument, integrals)


def _depth(expr: sp.Expr) -> int:
    if isinstance(expr, sp.Integral):
        return 1 + _depth(expr.function)
    return max((_depth(a) for a in expr.args), default=0) if expr.has(sp.Integral) else 0


@cache
def _node(depth: int) -> sp.Symbol:
    return sp.Dummy(f"node_{depth}")


def _quadrature(symbols: tuple[sp.Symbol, ...], integral: sp.Integral) -> ArrayFunction:
    ((variable, low, high),) = integral.limits
    inner = _node(len(symbols))
    limits = _compiled(symbols, (low, high))
    body = _compiled((*symbols, inner), (integral.function.xreplace({variable: inner}),))

    def evaluate(rule: Rule, *arguments: np.ndarray) -> np.ndarray:
        places, weights = rule
        start, stop = limits(rule, *arguments)
        start, width = start[..., None], (stop - start)[..., None]
        (values,) = body(rule, *(a[..., None] for a in arguments), start + width * places)
        total: np.ndarray = np.sum(values * weights * width, axis=-1)
        return total

    return evaluate
