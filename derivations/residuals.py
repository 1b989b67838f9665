"""What checks return: differences of expressions, and of numbers that need not be exact."""

from collections.abc import Iterable
from itertools import pairwise

import mpmath
import sympy as sp


def less(found: Iterable, claims: Iterable) -> list[sp.Expr]:
    """Return what was found less what is claimed, one by one."""
    return [f - c for f, c in zip(found, claims, strict=True)]


def rounded(number: sp.Expr, places: int) -> sp.Rational:
    """Round to as many places behind the point as are printed."""
    return sp.Rational(round(sp.N(number, 30) * 10**places), 10**places)


def agree(derived, claim, digits: int = 12) -> sp.Expr:
    """Return zero if two numbers agree to so many digits, otherwise their difference."""
    derived, claim = sp.N(derived, 34), sp.N(claim, 34)
    close = abs(derived - claim) <= sp.Float(10) ** -digits * abs(derived)
    return sp.Integer(0) if close else derived - claim


def trend(values: Iterable) -> int:
    """Return 1 for a rising sequence, -1 for a falling one, otherwise 0."""
    steps = {int(mpmath.sign(b - a)) for a, b in pairwise(values)}
    return steps.pop() if len(steps) == 1 else 0
