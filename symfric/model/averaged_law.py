"""The effective coefficient of friction under fast vibration: ``mubar(v) = <mu(v - q cos theta)>``, Thomsen (41)."""

import itertools
from typing import TypeAlias

import sympy as sp

from symfric.errors import SceneError
from symfric.model.symbols import SPEED

Averaged: TypeAlias = tuple[sp.Expr, tuple[sp.Expr, ...]]  # kinetic coefficient and breaks
_S = sp.Symbol("s", positive=True)  # quadrature variable on [0, 1]


def effective_coefficient(kinetic: sp.Expr, breaks: tuple[sp.Expr, ...], q: sp.Expr) -> Averaged:
    """Return the kinetic coefficient of the averaged law and its breaks.

    Below v = q the relative velocity changes its sign at ``theta = acos(v/q)``, Thomsen (45), (46); above it does not.
    """
    if not breaks and kinetic.is_polynomial(SPEED):
        below, above = _polynomial(sp.Poly(kinetic, SPEED), q)
        return sp.Piecewise((below, q > SPEED), (above, True)), (q,)
    if not breaks:
        below = _mean(kinetic, q, [sp.acos(SPEED / q)], [-1, 1])
        return sp.Piecewise((below, q > SPEED), (_mean(kinetic, q, [], [1]), True)), (q,)
    return _branched(kinetic, breaks, q)


def _polynomial(mu: sp.Poly, q: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Average a polynomial law in closed form; odd powers are smooth, even ones carry the sign.

    ``<sgn(w) w^n>`` for even n follows by integrating the expanded power over the two arcs divided by acos(v/q).
    """
    split, theta = sp.acos(SPEED / q), sp.Symbol("theta", positive=True)
    below = above = sp.Integer(0)
    for (n,), coefficient in mu.terms():
        power = sp.expand((SPEED - q * sp.cos(theta)) ** n)
        primitive = sum(
            (_cosine_primitive(power.coeff(sp.cos(theta), k), k, theta) for k in range(n + 1)), sp.Integer(0)
        )
        whole = sp.expand(primitive.subs(theta, sp.pi) - primitive.subs(theta, 0)) / sp.pi
        above += coefficient * whole
        if n % 2:
            below += coefficient * whole
        else:
            arc = primitive.subs(theta, sp.pi) - 2 * primitive.subs(theta, split) + primitive.subs(theta, 0)
            below += coefficient * arc / sp.pi
    below = below.subs(sp.acos(SPEED / q), sp.pi / 2 - sp.asin(SPEED / q))
    return sp.expand(below), sp.expand(above)


def _cosine_primitive(factor: sp.Expr, k: int, theta: sp.Symbol) -> sp.Expr:
    """Return ``factor * integral of cos(theta)^k`` by the reduction formula."""
    if k == 0:
        return factor * theta
    if k == 1:
        return factor * sp.sin(theta)
    rest = _cosine_primitive(sp.Integer(1), k - 2, theta)
    return factor * (sp.cos(theta) ** (k - 1) * sp.sin(theta) / k + sp.Rational(k - 1, k) * rest)


def _mean(kinetic: sp.Expr, q: sp.Expr, splits: list[sp.Expr], signs: list[int]) -> sp.Expr:
    """Return the mean over theta in [0, pi] of sign * kinetic(sign * w), w = v - q cos(theta), split at `splits`."""
    edges = [sp.Integer(0), *splits, sp.pi]
    pieces = zip(itertools.pairwise(edges), signs, strict=True)
    return sp.Add(*(_mean_piece(kinetic, q, low, high, sign) for (low, high), sign in pieces))


def _branched(kinetic: sp.Expr, breaks: tuple[sp.Expr, ...], q: sp.Expr) -> Averaged:
    """Average a law with branches; needs numbers, because the order of the integration limits depends on them."""
    if not q.is_number or not all(b.is_number for b in breaks):
        raise SceneError("the average of a law with breaks needs numbers for its breaks and for q; use law.where(...)")
    pieces = pieces_between(kinetic, breaks)
    odd = sp.expand(pieces[0] + pieces[0].subs(SPEED, -SPEED)) == 0  # an odd law has no break where w changes its sign
    # values of w at which the integrand changes its branch
    levels = sorted({-b for b in breaks} | set(breaks) | (set() if odd else {sp.Integer(0)}))
    edges = sorted({abs(level + side * q) for level in levels for side in (-1, 1)} - {0})
    results = []
    for low, high in itertools.pairwise([sp.Integer(0), *edges, edges[-1] + 2]):
        middle = (low + high) / 2
        inside = [level for level in levels if middle - q < level < middle + q]
        splits = [sp.acos((SPEED - level) / q) for level in inside]
        marks = [middle - q, *inside, middle + q]
        total = sp.Integer(0)
        bounds = [sp.Integer(0), *splits, sp.pi]
        for k, (start, stop) in enumerate(itertools.pairwise(bounds)):
            w = (marks[k] + marks[k + 1]) / 2
            branch = sum(1 for b in breaks if abs(w) > b)
            total += _mean_piece(pieces[branch], q, start, stop, 1 if w > 0 else -1)
        results.append((total, high > SPEED))
    results[-1] = (results[-1][0], True)
    return sp.Piecewise(*results), tuple(edges)


def pieces_between(kinetic: sp.Expr, breaks: tuple[sp.Expr, ...]) -> tuple[sp.Expr, ...]:
    """Return the expression of a law on each interval between its breaks, which are numbers.

    Notes
    -----
    SymPy merges neighbouring branches that are equal, so that they cannot be counted.
    """
    if not breaks:
        return (kinetic,)
    speeds = [(low + high) / 2 for low, high in itertools.pairwise([sp.Integer(0), *breaks])]

    def at(speed: sp.Expr) -> sp.Expr:
        def held(piecewise: sp.Piecewise) -> sp.Expr:
            for e, condition in piecewise.args:
                decided = condition.subs(SPEED, speed)
                if decided == True:  # noqa: E712
                    return e
                if decided != False:  # noqa: E712
                    raise SceneError(f"the branches of the law {kinetic} depend on more than numbers and the speed")
            raise SceneError(f"the law {kinetic} has no branch for the speed {float(speed):g}")

        return kinetic.replace(lambda e: isinstance(e, sp.Piecewise), held)

    return tuple(at(speed) for speed in (*speeds, breaks[-1] + 1))


def _mean_piece(kinetic: sp.Expr, q: sp.Expr, low: sp.Expr, high: sp.Expr, sign: int) -> sp.Expr:
    """Integrate one arc, mapped to s in [0, 1] so that nodes cluster at both ends, where the law varies most."""
    clustered = _S**2 * (3 - 2 * _S)
    speed = sign * (SPEED - q * sp.cos(low + (high - low) * clustered))
    body = sign * kinetic.subs(SPEED, speed) * (high - low) * clustered.diff(_S) / sp.pi
    return sp.Integral(body, (_S, 0, 1))
