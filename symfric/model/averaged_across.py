"""The effective coefficient of friction under fast vibration across the sliding direction.

With the sliding speed v and the fast velocity ``q cos theta`` across it, the slip is
``S = sqrt(v^2 + q^2 cos^2 theta)``, and friction points against the slip vector: along the sliding direction remains
``<mu(S) v/S>``.
"""

import itertools

import sympy as sp

from symfric.errors import SceneError
from symfric.model.averaged_law import Averaged, pieces_between
from symfric.model.elliptic import APART, LEAST, geometric_mean
from symfric.model.symbols import SPEED

_S = sp.Symbol("s", positive=True)  # quadrature variable on [0, 1]


def coefficient_across(kinetic: sp.Expr, breaks: tuple[sp.Expr, ...], q: sp.Expr) -> Averaged:
    """Return the kinetic coefficient of the law averaged over vibration across, and its breaks.

    Up to ``LEAST q`` it is a straight line: its slope rises there like ``ln(4 q/v)`` beyond all bounds.
    """
    pieces: tuple[sp.Expr, ...]
    edges: tuple[sp.Expr, ...] = ()
    if not breaks and kinetic.is_polynomial(SPEED):
        pieces = (_polynomial(sp.Poly(kinetic, SPEED), q),)
    elif q.is_number and all(b.is_number for b in breaks):
        pieces, edges = _quadratures(kinetic, breaks, q)
    else:
        raise SceneError(
            "the average across of a law that is no polynomial of the speed needs numbers for its breaks and for q; "
            "use law.where(...)"
        )
    low = LEAST * q
    line = pieces[0].subs(SPEED, low) * SPEED / low
    conditions = [edge > SPEED for edge in edges]
    above = zip(pieces, [*conditions, sp.true], strict=True)
    return sp.Piecewise((line, low > SPEED), *above), (low, *edges)


def _polynomial(mu: sp.Poly, q: sp.Expr) -> sp.Expr:
    """Return ``v sum c_n <S^(n - 1)>`` in closed form: powers of S^2, or elliptic integrals.

    With ``A^2 = v^2 + q^2`` odd powers follow from <1/S> and <S> by ``(p + 4) <S^(p+4)> = (p + 3)(A^2 + v^2) <S^(p+2)>
    - (p + 2) A^2 v^2 <S^p>``.
    """
    total = sp.sqrt(SPEED**2 + q**2)
    share = q**2 / (SPEED**2 + q**2) + APART
    m = geometric_mean(SPEED / total, share)
    means = {-1: 1 / (m.mean * total)}
    if mu.degree() >= 2:
        means[1] = total * (1 - share / 2 - share**2 * m.squares) / m.mean
    for p in range(3, mu.degree(), 2):
        before = (p - 1) * (2 * SPEED**2 + q**2) * means[p - 2]
        means[p] = (before - (p - 2) * (SPEED**2 + q**2) * SPEED**2 * means[p - 4]) / p
    result = sp.Integer(0)
    for (n,), coefficient in mu.terms():
        mean = _even_power(n - 1, q) if n % 2 else means[n - 1]
        result += coefficient * SPEED * mean
    return result


def _even_power(p: int, q: sp.Expr) -> sp.Expr:
    """Return ``<(v^2 + q^2 cos^2)^(p/2)>`` for even p, by ``<cos^(2k)> = binomial(2k, k)/4^k``."""
    half = p // 2
    return sp.Add(
        *(
            sp.binomial(half, k) * SPEED ** (p - 2 * k) * q ** (2 * k) * sp.binomial(2 * k, k) / 4**k
            for k in range(half + 1)
        )
    )


def _quadratures(
    kinetic: sp.Expr, breaks: tuple[sp.Expr, ...], q: sp.Expr
) -> tuple[tuple[sp.Expr, ...], tuple[sp.Expr, ...]]:
    """Return the average between its breaks: the coefficient at rest in closed form, an integral over the rest."""
    pieces = pieces_between(kinetic, breaks)
    rest = pieces[0].subs(SPEED, 0)
    if not rest.is_finite:
        raise SceneError(f"the law {kinetic} has no finite coefficient at rest, whose average could be taken")
    coulomb = _polynomial(sp.Poly(rest, SPEED), q)
    edges = {q, *breaks, *(sp.sqrt(b**2 - q**2) for b in breaks if b > q)}
    ordered = tuple(sorted(e for e in edges if e > LEAST * q))
    results = []
    for low, high in itertools.pairwise([sp.Integer(0), *ordered, 2 * ordered[-1]]):
        middle = (low + high) / 2
        inside = [b for b in breaks if middle**2 < b**2 < middle**2 + q**2]
        splits = [sp.asin(sp.sqrt(b**2 - SPEED**2) / q) for b in inside]
        first = sum(1 for b in breaks if b <= middle)
        whole = not splits and high > q
        bounds = [sp.Integer(0), *splits, sp.pi if whole else sp.pi / 2]
        parts = (
            _part(pieces[first + k] - rest, q, begin, end, bounds[-1])
            for k, (begin, end) in enumerate(itertools.pairwise(bounds))
        )
        results.append(coulomb + sp.Add(*parts))
    return tuple(results), ordered


def _part(excess: sp.Expr, q: sp.Expr, low: sp.Expr, high: sp.Expr, whole: sp.Expr) -> sp.Expr:
    """Integrate ``excess(S) v/S`` over one arc, mapped to s in [0, 1] so that nodes cluster at both ends."""
    clustered = _S**2 * (3 - 2 * _S)
    slip = sp.sqrt(SPEED**2 + q**2 * sp.sin(low + (high - low) * clustered) ** 2)
    body = excess.subs(SPEED, slip) * SPEED / slip * (high - low) * clustered.diff(_S) / whole
    return sp.Integral(body, (_S, 0, 1))
