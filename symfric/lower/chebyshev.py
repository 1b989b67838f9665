"""Smooth functions on an interval as Chebyshev series, in variables that straighten singularities at its ends.

The mean of a friction law over a fast vibration behaves like sqrt(q - v) where the sliding speed meets the fast one;
in ``asin(v/q)`` it is as smooth as the law itself. A law with a square root leaves (q - v) log|q - v|, which is smooth
enough in a fourth root.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp
from numpy.polynomial.chebyshev import chebval

DEGREES = (8, 12, 16, 20)
MOST_PIECES = 8
RESOLVED = 2e-14  # size of the last coefficients, and of those omitted, relative to the largest value
ACCURACY = 1e-12  # error between the interpolation points, relative to the largest value

Samples = Callable[[np.ndarray, np.ndarray], np.ndarray]


class ChebyshevSeries(sp.Function):
    """``sum of c_k T_k(x)``; the arguments are x, between -1 and 1, then c_0, c_1, ..."""


@dataclass(frozen=True)
class Variable:
    """A transformed variable on low <= v <= high.

    Attributes
    ----------
    expr : Expr
        The variable in terms of v.
    start, stop : float
        Its range.
    distances : callable
        ``x -> (v - low, high - v)``, both without cancellation.
    odd : bool
        Whether the function is odd in it; then `start` is 0.
    """

    expr: sp.Expr
    start: float
    stop: float
    distances: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
    odd: bool = False


@dataclass(frozen=True, eq=False)
class Piece:
    """Coefficients of the series on ``start <= variable <= stop``."""

    start: float
    stop: float
    coefficients: np.ndarray


def variables(v: sp.Symbol, low: float, high: float) -> tuple[Variable, ...]:
    """Return the candidate variables, the likeliest first; for low = 0 all are regular there."""
    width, half = high - low, (high - low) / 2
    # in x with v - low ~ x^4, square and fourth roots at an end of the range are analytic
    root = lambda e: (e / width) ** sp.Rational(1, 4)  # noqa: E731
    to_high = Variable(root(high - v), 0.0, 1.0, lambda x: (width * (1 - x**4), width * x**4))
    if low == 0:
        angle = sp.asin(v / high)
        turned = lambda x: (high * np.sin(x), 2 * high * np.sin(np.pi / 4 - x / 2) ** 2)  # noqa: E731
        return Variable(angle, 0, np.pi / 2, turned, odd=True), Variable(angle, 0, np.pi / 2, turned), to_high
    return (
        Variable(v, low, high, lambda x: (x - low, high - x)),
        Variable(
            sp.asin((v - low - half) / half),
            -np.pi / 2,
            np.pi / 2,
            lambda x: (width * np.sin(np.pi / 4 + x / 2) ** 2, width * np.sin(np.pi / 4 - x / 2) ** 2),
        ),
        Variable(root(v - low), 0.0, 1.0, lambda x: (width * x**4, width * (1 - x**4))),
        to_high,
    )


def chebyshev(sample: Samples, v: sp.Symbol, low: float, high: float) -> sp.Expr | None:
    """Return the series of a function on low <= v <= high, or None if it is not short in any variable.

    Parameters
    ----------
    sample : callable
        ``(v - low, high - v) -> values``, elementwise; NaN where it is inaccurate.
    v : Symbol
    low, high : float

    Returns
    -------
    Expr or None
        Several pieces share one series, whose coefficients are Piecewise in v: where the branch is data, as in the
        event-driven solvers, only one is evaluated.
    """
    best = None
    for variable in variables(v, low, high):
        pieces = _pieces(sample, variable)
        if pieces is not None and (best is None or len(pieces) < len(best[1])):
            best = variable, pieces
        if best is not None and len(best[1]) == 1:
            break
    return None if best is None else _expression(*best, v, low)


def _pieces(sample: Samples, variable: Variable) -> list[Piece] | None:
    """Return series on parts of the range, halved until each is resolved."""
    scale = np.max(np.abs(sample(*variable.distances(_lobatto(64, variable.start, variable.stop)))))
    if not np.isfinite(scale):
        return None
    if variable.odd:
        odd = _odd_piece(sample, variable, scale)
        return None if odd is None else [odd]
    waiting, done = [(variable.start, variable.stop)], []
    while waiting:
        start, stop = waiting.pop()
        piece = _piece(sample, variable, start, stop, scale)
        if piece is not None:
            done.append(piece)
        else:
            waiting += [((start + stop) / 2, stop), (start, (start + stop) / 2)]
        if len(waiting) + len(done) > MOST_PIECES:
            return None
    return done


def _lobatto(n: int, start: float, stop: float) -> np.ndarray:
    """Return the n + 1 extrema of T_n, from `stop` down to `start`, both exact."""
    # sines instead of cosines: the points are symmetric to the last bit
    x = (start + stop) / 2 + (stop - start) / 2 * np.sin(np.pi / 2 * np.arange(n, -n - 1, -2) / n)
    x[0], x[-1] = stop, start
    return x


def _coefficients(values: np.ndarray) -> np.ndarray:
    """Return the coefficients of the interpolant through values at the extrema of T_n."""
    # see Trefethen, Approximation Theory and Approximation Practice, chapter 3
    c = np.fft.rfft(np.concatenate([values, values[-2:0:-1]])).real / (values.size - 1)  # a cosine transform
    c[[0, -1]] /= 2
    return c


def _piece(sample: Samples, variable: Variable, start: float, stop: float, scale: float) -> Piece | None:
    middles = start + (stop - start) * (np.arange(61) + 0.5) / 61
    for n in DEGREES:
        c = _coefficients(sample(*variable.distances(_lobatto(n, start, stop))))
        # the last two, since one of them may vanish by parity
        if np.max(np.abs(c[-2:])) <= RESOLVED * scale:
            c = _shortened(c, scale)
            error = chebval((2 * middles - start - stop) / (stop - start), c) - sample(*variable.distances(middles))
            if np.max(np.abs(error)) <= ACCURACY * scale:
                return Piece(start, stop, c)
    return None


def _odd_piece(sample: Samples, variable: Variable, scale: float) -> Piece | None:
    """Return the series d of ``x sum of d_k T_k(2 x^2 - 1)``, x = variable/stop, for an odd function."""
    stop = variable.stop
    middles = stop * (np.arange(61) + 0.5) / 61
    for m in DEGREES:
        x = _lobatto(2 * m + 1, -stop, stop)[: m + 1]
        half = sample(*variable.distances(x))
        c = _coefficients(np.concatenate([half, -half[::-1]]))[1::2]
        if np.max(np.abs(c[-2:])) <= RESOLVED * scale:
            c = _shortened(c, scale)
            d = np.zeros(c.size)
            for k in reversed(range(c.size)):  # T_{2k+1} = 2 x T_{2k} - T_{2k-1}
                d[k] = 2 * c[k] - (d[k + 1] if k + 1 < c.size else 0.0)
            d[0] /= 2
            y = middles / stop
            error = y * chebval(2 * y * y - 1, d) - sample(*variable.distances(middles))
            if np.max(np.abs(error)) <= ACCURACY * scale:
                return Piece(0.0, stop, d)
    return None


def _shortened(c: np.ndarray, scale: float) -> np.ndarray:
    """Remove the last coefficients as long as their sum is negligible."""
    left = np.cumsum(np.abs(c[::-1]))[::-1] > RESOLVED * scale
    return c[: max(1, int(np.sum(left)))]


def _expression(variable: Variable, pieces: Sequence[Piece], v: sp.Symbol, low: float) -> sp.Expr:
    if variable.odd:
        x = variable.expr / variable.stop
        return x * ChebyshevSeries(2 * x**2 - 1, *map(sp.Float, pieces[0].coefficients))
    ends = [low + variable.distances(np.array([p.start, p.stop]))[0] for p in pieces]
    order = np.argsort([e.max() for e in ends])
    pieces, joints = [pieces[i] for i in order], [ends[i].max() for i in order[:-1]]

    def chosen(numbers: Iterable[float]) -> sp.Expr:
        *first, last = map(sp.Float, numbers)
        return sp.Piecewise(*((e, v < sp.Float(joint)) for e, joint in zip(first, joints, strict=True)), (last, True))

    rows = np.zeros((len(pieces), max(p.coefficients.size for p in pieces)))
    for row, p in zip(rows, pieces, strict=True):
        row[: p.coefficients.size] = p.coefficients
    slope = chosen([2 / (p.stop - p.start) for p in pieces])
    shift = chosen([-(p.start + p.stop) / (p.stop - p.start) for p in pieces])
    return ChebyshevSeries(slope * variable.expr + shift, *(chosen(column) for column in rows.T))
