"""Interval arithmetic for SymPy expressions of one variable: bounds over many intervals at once.

The natural interval extension: every operation is replaced by its exact range, so that the result contains the range of
the expression, and tends to it as the intervals shrink. Rounding is not directed outward: the bounds serve searches
with tolerances, not proofs to the last digit.
"""

from collections.abc import Callable
from functools import reduce

import numpy as np
import sympy as sp
from scipy.special import erf

Bounds = tuple[np.ndarray, np.ndarray]

_RISING: dict[type, Callable[[np.ndarray], np.ndarray]] = {
    sp.exp: np.exp,
    sp.log: np.log,
    sp.tanh: np.tanh,
    sp.sinh: np.sinh,
    sp.atan: np.arctan,
    sp.asinh: np.arcsinh,
    sp.erf: erf,
    sp.sign: np.sign,
    sp.Heaviside: lambda x: np.heaviside(x, 0.5),
}


class Unbounded(Exception):
    """Raised if an expression contains a function without an interval extension here."""


def enclosure(expr: sp.Expr, variable: sp.Symbol) -> Callable[[np.ndarray, np.ndarray], Bounds]:
    """Return a function that bounds an expression over intervals.

    Parameters
    ----------
    expr : Expr
        Of the variable and numbers.
    variable : Symbol

    Returns
    -------
    callable
        ``(low, high) -> (low, high)``, arrays of shape (n,); infinite or NaN where the expression is not defined.

    Raises
    ------
    Unbounded
        From the call, if a function is unknown.
    """

    def bounds(low: np.ndarray, high: np.ndarray) -> Bounds:
        known: dict[sp.Expr, Bounds] = {variable: (low, high)}

        def of(node: sp.Expr) -> Bounds:
            if node not in known:
                known[node] = _of(node, of, low.shape)
            return known[node]

        with np.errstate(all="ignore"):
            return of(expr)

    return bounds


def _of(node: sp.Expr, of: Callable[[sp.Expr], Bounds], shape: tuple[int, ...]) -> Bounds:
    if node.is_number:
        value = np.full(shape, float(node))
        return value, value
    if node.is_Add:
        terms = [of(e) for e in node.args]
        return reduce(np.add, (t[0] for t in terms)), reduce(np.add, (t[1] for t in terms))
    if node.is_Mul:
        product = of(node.args[0])
        for e in node.args[1:]:
            product = _times(product, of(e))
        return product
    if node.is_Pow:
        return _power(of(node.base), of(node.exp), node.exp)
    parts = [of(e) for e in node.args]
    return _function(node, parts)


def _function(node: sp.Expr, parts: list[Bounds]) -> Bounds:
    kind = node.func
    if kind in _RISING:
        return _RISING[kind](parts[0][0]), _RISING[kind](parts[0][1])
    low, high = parts[0]
    if kind is sp.DiracDelta:  # the slope of a jump, and its derivatives
        peak = np.where((low <= 0) & (high >= 0), np.inf, 0.0)
        return -peak if len(parts) > 1 else np.zeros(low.shape), peak
    if kind is sp.Abs:
        return _away(low, high), np.maximum(np.abs(low), np.abs(high))
    if kind is sp.cosh:
        return np.cosh(_away(low, high)), np.cosh(np.maximum(np.abs(low), np.abs(high)))
    if kind in (sp.sin, sp.cos):
        shift = 0.0 if kind is sp.cos else -0.5 * np.pi
        return _cosine(low + shift, high + shift)
    if kind is sp.Max:
        return np.maximum.reduce([p[0] for p in parts]), np.maximum.reduce([p[1] for p in parts])
    if kind is sp.Min:
        return np.minimum.reduce([p[0] for p in parts]), np.minimum.reduce([p[1] for p in parts])
    raise Unbounded(f"no bounds are known for {kind.__name__}")


def _away(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the least absolute value on an interval."""
    return np.where((low <= 0) & (high >= 0), 0.0, np.minimum(np.abs(low), np.abs(high)))


def _times(a: Bounds, b: Bounds) -> Bounds:
    products = np.array([x * y for x in a for y in b])
    products[np.isnan(products)] = 0.0  # zero times infinity: the zero is exact
    return products.min(axis=0), products.max(axis=0)


def _power(base: Bounds, exponent: Bounds, expr: sp.Expr) -> Bounds:
    low, high = base
    if expr.is_Integer:
        n = int(expr)
        if n < 0:
            return _inverse(_power(base, exponent, -expr))
        if n % 2:
            return low**n, high**n
        return _away(low, high) ** n, np.maximum(np.abs(low), np.abs(high)) ** n
    logs = np.log(np.maximum(low, 0.0)), np.log(high)
    product = _times(logs, exponent)
    return np.exp(product[0]), np.exp(product[1])


def _inverse(a: Bounds) -> Bounds:
    low, high = a
    through = (low <= 0) & (high >= 0)
    least = np.where(through, np.where(low == 0, 1 / high, -np.inf), 1 / high)
    most = np.where(through, np.where(high == 0, 1 / low, np.inf), 1 / low)
    return least, most


def _cosine(low: np.ndarray, high: np.ndarray) -> Bounds:
    ends = np.cos(low), np.cos(high)
    top = np.floor(high / (2 * np.pi)) >= np.ceil(low / (2 * np.pi))
    bottom = np.floor((high - np.pi) / (2 * np.pi)) >= np.ceil((low - np.pi) / (2 * np.pi))
    return np.where(bottom, -1.0, np.minimum(*ends)), np.where(top, 1.0, np.maximum(*ends))
