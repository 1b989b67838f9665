"""Means over one period of powers of sine and cosine times friction, whose sign may change within the period."""

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

import sympy as sp

from symfric.errors import SceneError
from symfric.model.averaged_law import pieces_between
from symfric.model.symbols import SPEED

_S = sp.Dummy("s", positive=True)  # quadrature variable on [0, 1]


class Arc(NamedTuple):
    """A part of 0 <= theta <= pi on which friction is smooth: ``sign * kinetic(sign * w)``."""

    low: sp.Expr
    high: sp.Expr
    kinetic: sp.Expr
    sign: int


class HarmonicRange(NamedTuple):
    """The arcs that make up half a period for swings V of the slip velocity below `top`."""

    top: sp.Expr
    arcs: tuple[Arc, ...]


def ranges(kinetic: sp.Expr, breaks: tuple[sp.Expr, ...], W: sp.Expr, V: sp.Expr) -> tuple[HarmonicRange, ...]:
    """Split half a period of the slip ``w = W + V cos theta``, W >= 0, V > 0, at zeros of w and breaks of the law.

    Parameters
    ----------
    kinetic : Expr
        mu(SPEED).
    breaks : tuple of Expr
        Speeds at which it changes its branch; with any, W and they must be numbers.
    W, V : Expr

    Returns
    -------
    tuple of Range
        By increasing V; the last has ``top = oo``.
    """
    if not breaks:
        split = sp.acos(-W / V)
        both = HarmonicRange(sp.oo, (Arc(sp.Integer(0), split, kinetic, 1), Arc(split, sp.pi, kinetic, -1)))
        return (both,) if W.is_zero else (HarmonicRange(W, (Arc(sp.Integer(0), sp.pi, kinetic, 1),)), both)
    if not W.is_number or not all(b.is_number for b in breaks):
        raise SceneError("the average of a law with breaks needs numbers for its breaks and for the sliding speed")
    pieces = pieces_between(kinetic, breaks)
    levels = sorted({sp.Integer(0), *breaks, *(-b for b in breaks)}, reverse=True)
    tops = [*sorted({abs(level - W) for level in levels} - {0}), sp.oo]
    result = []
    for low, top in itertools.pairwise([sp.Integer(0), *tops]):
        middle = (low + top) / 2 if top != sp.oo else low + 1
        inside = [level for level in levels if W - middle < level < W + middle]
        marks = [W + middle, *inside, W - middle]
        edges = [sp.Integer(0), *(sp.acos((level - W) / V) for level in inside), sp.pi]
        arcs = []
        for (start, stop), (upper, lower) in zip(itertools.pairwise(edges), itertools.pairwise(marks), strict=True):
            w = (upper + lower) / 2
            branch = pieces[sum(1 for b in breaks if abs(w) > b)]
            arcs.append(Arc(start, stop, branch, 1 if w > 0 else -1))
        result.append(HarmonicRange(top, tuple(arcs)))
    return tuple(result)


def arc_mean(body: Callable[..., Any], arc: Arc, W: sp.Expr, V: sp.Expr) -> sp.Expr:
    """Return the part of the mean over a period that the arc and its mirror image -theta contribute.

    Parameters
    ----------
    body : callable ``(law, sine, cosine) -> Expr``
        The integrand, with the value of the law and the sine and cosine of theta.
    arc : Arc
    W, V : Expr
        Slip velocity ``W + V cos theta``.
    """
    s, c = sp.Symbol("sine"), sp.Symbol("cosine")
    integrand = body(arc.sign * arc.kinetic.subs(SPEED, arc.sign * (W + V * c)), s, c)
    if integrand.is_polynomial(s, c):
        return _polynomial_mean(sp.Poly(integrand, s, c), arc.low, arc.high)
    clustered = _S**2 * (3 - 2 * _S)  # nodes cluster at both ends, where the friction varies most
    theta = arc.low + (arc.high - arc.low) * clustered
    both = sp.Add(*(integrand.subs({s: side * sp.sin(theta), c: sp.cos(theta)}) for side in (1, -1)))
    return sp.Integral(both * (arc.high - arc.low) * clustered.diff(_S) / (2 * sp.pi), (_S, 0, 1))


def _polynomial_mean(polynomial: sp.Poly, low: sp.Expr, high: sp.Expr) -> sp.Expr:
    """Integrate in closed form; odd powers of the sine cancel between theta and -theta."""
    c = polynomial.gens[1]
    reduced = sp.Integer(0)
    for (m, n), coefficient in polynomial.terms():
        if m % 2 == 0:
            reduced += coefficient * (1 - c**2) ** (m // 2) * c**n
    total = sp.Integer(0)
    for (n,), coefficient in sp.Poly(reduced, c).terms():
        total += coefficient * (_primitive(n, high) - _primitive(n, low))
    return total / sp.pi


def _primitive(n: int, theta: sp.Expr) -> sp.Expr:
    """Return the integral of cos(theta)^n by the reduction formula."""
    if n == 0:
        return theta
    if n == 1:
        return sp.sin(theta)
    return sp.cos(theta) ** (n - 1) * sp.sin(theta) / n + sp.Rational(n - 1, n) * _primitive(n - 2, theta)
