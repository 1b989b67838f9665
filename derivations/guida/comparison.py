"""Numbers against claims."""

from itertools import pairwise

import mpmath
import sympy as sp


def agree(derived, claim, digits=12):
    """Return zero if two numbers agree to so many digits, otherwise their difference."""
    difference = sp.Float(derived, 30) - claim
    return sp.Integer(0) if abs(difference) <= sp.Float(10) ** -digits * abs(sp.Float(derived)) else difference


def trend(values):
    """Return 1 for a rising sequence, -1 for a falling one, otherwise 0."""
    steps = {int(mpmath.sign(b - a)) for a, b in pairwise(values)}
    return steps.pop() if len(steps) == 1 else 0
