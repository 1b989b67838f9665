"""Tables: a Piecewise whose conditions compare one quantity with increasing numbers."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import sympy as sp

_ORDERS = (sp.StrictLessThan, sp.LessThan, sp.StrictGreaterThan, sp.GreaterThan)
Line = tuple[sp.Expr, sp.Expr]  # value at zero and slope


@dataclass(frozen=True)
class Table:
    """A Piecewise as a table.

    Attributes
    ----------
    argument : Expr
        The quantity that the conditions compare.
    breaks : tuple of Expr
        Numbers, increasing.
    pieces : tuple of Expr
        One more than breaks: below the first break, between them, and above the last.
    """

    argument: sp.Expr
    breaks: tuple[sp.Expr, ...]
    pieces: tuple[sp.Expr, ...]

    @cached_property
    def lines(self) -> tuple[Line, ...] | None:
        """Value at zero and slope of every piece, if all are linear in the argument, a symbol."""
        if not isinstance(self.argument, sp.Symbol):
            return None
        lines = []
        for piece in self.pieces:
            line = _line(piece, self.argument)
            if line is None:
                return None
            lines.append(line)
        return tuple(lines)


@lru_cache(maxsize=256)
def table_of(piecewise: sp.Piecewise) -> Table | None:
    """Return a Piecewise as a table, None if it is none.

    Examples
    --------
    >>> import sympy as sp
    >>> from symfric.model.tables import table_of
    >>> x = sp.Symbol("x", real=True)
    >>> table_of(sp.Piecewise((x, x < 1), (2 - x, 3 > x), (0, True))).breaks
    (1, 3)
    >>> table_of(sp.Piecewise((1, x > 3), (x, x > 1), (0, True))).pieces
    (0, x, 1)
    """
    *first, last = piecewise.args
    if last.cond != sp.true or not first:
        return None
    argument, rising, breaks = None, True, []
    for _, condition in first:
        bounds = [_bound(c) for c in condition.args] if isinstance(condition, sp.Or) else [_bound(condition)]
        for bound in bounds:
            if bound is None:
                return None
            if argument is None:
                argument, rising = bound[0], bound[2]
            if (bound[0], bound[2]) != (argument, rising):
                return None
        breaks.append((max if rising else min)(bound[1] for bound in bounds if bound))
    assert argument is not None
    pieces = [piece.expr for piece in piecewise.args]
    if not rising:
        breaks.reverse()
        pieces.reverse()
    if any(float(a) >= float(b) for a, b in itertools.pairwise(breaks)):
        return None
    return Table(argument, tuple(breaks), tuple(pieces))


def _bound(condition: sp.Basic) -> tuple[sp.Expr, sp.Expr, bool] | None:
    """Return x, b and whether ``x < b`` rather than ``x > b``, of a comparison of a quantity x with a number b."""
    if not isinstance(condition, _ORDERS):
        return None
    low, high = condition.lts, condition.gts
    upper = bool(high.is_number)
    x, b = (low, high) if upper else (high, low)
    return None if x.is_number or not (b.is_number and b.is_real) else (x, b, upper)


def broken_line(x: sp.Expr, breaks: Sequence[sp.Expr], lines: Sequence[sp.Expr]) -> sp.Expr:
    """Return the lines below, between and above some increasing values of a positive symbol as a Piecewise.

    Comparisons with numbers are written down as they are: SymPy takes milliseconds to find that it cannot decide them.
    """
    numbers = [sp.sympify(b) for b in breaks]
    apart = [(line, b) for line, after, b in zip(lines[:-1], lines[1:], numbers, strict=True) if line != after]
    if not apart:
        return lines[-1]
    if not all(b.is_number and b > 0 for _, b in apart):
        return sp.Piecewise(*((line, b > x) for line, b in apart), (lines[-1], True))
    pieces = [(line, sp.StrictLessThan(x, b, evaluate=False)) for line, b in apart]
    return sp.Piecewise(*pieces, (lines[-1], True), evaluate=False)


def _line(e: sp.Expr, x: sp.Symbol) -> Line | None:
    """Return value at zero and slope of an expression that is linear in a symbol, else None."""
    if e == x:
        return sp.S.Zero, sp.S.One
    if x not in e.free_symbols:
        return e, sp.S.Zero
    if e.is_Add:
        parts = [_line(a, x) for a in e.args]
        if any(part is None for part in parts):
            return None
        known = [part for part in parts if part is not None]
        return sp.Add(*(value for value, _ in known)), sp.Add(*(slope for _, slope in known))
    if e.is_Mul:
        others = [a for a in e.args if x not in a.free_symbols]
        inner = [a for a in e.args if x in a.free_symbols]
        part = _line(inner[0], x) if len(inner) == 1 else None
        return None if part is None else (sp.Mul(part[0], *others), sp.Mul(part[1], *others))
    return None
