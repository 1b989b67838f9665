"""Speeds at which friction falls: where steady sliding of an undamped body is unstable."""

import itertools

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import instance
from symfric.model.averaged_law import pieces_between
from symfric.model.laws import Law
from symfric.model.numeric import numeric_function
from symfric.model.symbols import SPEED
from symfric.search import zero

_DECADES, _PER_DECADE = 9, 200  # of the speeds that are searched, around 1 and around the breaks of the law


@alone(SYMBOLIC)
def falling_speeds(law: Law) -> tuple[tuple[float, float], ...]:
    """Return the intervals of the sliding speed in which the kinetic coefficient falls.

    Parameters
    ----------
    law : Law
        In numbers.

    Returns
    -------
    tuple of (float, float)
        Open intervals in increasing order, in the unit of the slip velocity; the first may begin at 0, the last may end
        at infinity. Empty for a law that falls nowhere.

    Raises
    ------
    SceneError
        If the law still has symbols.

    Notes
    -----
    A mass on a spring that slides steadily at a speed v obeys ``m y'' + N mu'(v) y' + k y = 0``, handbook (19.109), and
    is unstable exactly where the slope is negative; a damper shifts the limit to ``-c/N``. The slope is followed over
    18 decades of the speed on either side of 1, piece by piece, and its zeros polished. Closed forms of single laws,
    which prove these numbers, are in derivations/handbook.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.falling_speeds(sf.laws.coulomb(0.3))
    ()
    >>> [(low, high)] = sf.theory.falling_speeds(sf.laws.lorentz(0.8, 0.3, b=0.35))
    >>> f"{low:.5f} {high:.5f}"
    '0.01986 0.65510'
    """
    if instance(law, Law, "law").free_symbols:
        names = ", ".join(sorted(s.name for s in law.free_symbols))
        raise SceneError(f"the law has no number for {names}; use law.where({{...}}) first")
    breaks = [float(b) for b in law.breaks]
    intervals: list[tuple[float, float]] = []
    pieces = pieces_between(law.kinetic, law.breaks)
    for piece, (low, high) in zip(pieces, itertools.pairwise([0.0, *breaks, np.inf]), strict=True):
        intervals += _falling(piece.diff(SPEED), low, high)
    return tuple(_joined(intervals))


def _falling(slope: sp.Expr, low: float, high: float) -> list[tuple[float, float]]:
    """Return where a slope is negative between two speeds."""
    at = numeric_function((SPEED,), slope)
    ends = 10.0 ** np.linspace(-_DECADES, _DECADES, 2 * _DECADES * _PER_DECADE + 1)
    width = (high - low) if np.isfinite(high) else 1.0
    v = np.concatenate([low + ends, low + width * np.linspace(0.0, 1.0, 1001)[1:-1]])
    v = np.unique(v[(v > low) & (v < high)])
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        y = at(v) * np.ones_like(v)
    negative = y < 0
    last = np.flatnonzero(y)[-1] if np.any(y) else -1
    negative[last + 1 :] = last >= 0 and negative[last]  # a tail that has underflown keeps its sign
    turns = np.flatnonzero(negative[1:] != negative[:-1])
    roots = [zero(lambda s: float(at(np.float64(s))), v[k], v[k + 1]) for k in turns]
    edges = [low, *roots, high]
    first = 0 if negative[0] else 1
    return [(a, b) for a, b in itertools.islice(itertools.pairwise(edges), first, None, 2)]


def _joined(intervals: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Join neighbours that share an end."""
    joined: list[tuple[float, float]] = []
    for low, high in intervals:
        if joined and joined[-1][1] == low:
            low = joined.pop()[0]
        joined.append((low, high))
    return joined
