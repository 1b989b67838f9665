"""Where the mass of Example 19.5 stays, and after how many half cycles."""

from fractions import Fraction

import sympy as sp

from derivations.handbook.decay import LEFT, RIGHT, _next_rest
from derivations.handbook.models import Delta, V, omega
from derivations.ledger import Ledger
from symfric.theory import transient

PART = Ledger("handbook", "Example 19.5: the stop")

# Each half cycle turns the distance a into 2 Delta - a on the other side: a_n = |x0| - 2 n Delta, position
# (-1)^n sgn(x0) a_n. The mass stays where |a_n| <= Delta_s for the first time. It moved from
# a_(n-1) > Delta_s >= Delta, so a_n > Delta_s - 2 Delta >= -Delta_s: the absolute value never matters, and N is the
# least n >= 0 with |x0| - 2 n Delta <= Delta_s, that is N = max(0, ceil((|x0| - Delta_s)/(2 Delta))). Equality is a
# stop: static friction carries up to f_s, included. With Delta_s > 2 Delta the mass can even stay on the side from
# which it came.
#
# The claim is compared with the motion itself, half cycle by half cycle in exact numbers: ties, points 1e-30 to both
# sides of ties, starts on both sides, Delta_s = Delta and above.
_TINY = Fraction(1, 10**30)
_DATA = tuple(
    (delta, ratio * delta, sign * (ratio * delta + (2 * n + shift) * delta))
    for delta in (Fraction(1, 10), Fraction(3, 7))
    for ratio in (1, Fraction(3, 2), 2, 4)
    for n in (0, 1, 2, 5)
    for shift in (0, _TINY, -_TINY, Fraction(1, 3))
    for sign in (1, -1)
)


def _walk(delta, delta_s, start):
    """Count half cycles and return where the mass stays."""
    n, position = 0, start
    while abs(position) > delta_s:
        side = LEFT if position > 0 else RIGHT
        n, position = n + 1, -2 * side * delta - position
    return n, position


@PART.verified(
    "Example 19.5 one half cycle",
    "turning point after a start at X, to the left and to the right",
    2 * Delta - V,
    -2 * Delta + V,
)
def _(left, right):
    # the map used by _walk, from the solved equation; V > 0 is the distance from which it starts
    force = Delta * omega**2
    return _next_rest(force, V)[1] - left, _next_rest(-force, -V)[1] - right


def _misfit(claim, expected):
    """Sum of |claim - expected(half cycles, rest)| over the data."""
    total = 0
    for data in _DATA:
        numbers = dict(zip(transient.SYMBOLS, map(_exact, data), strict=False))  # omega_n stays a symbol
        total += abs(claim.xreplace(numbers) - expected(*_walk(*data)))
    return total


def _exact(number):
    return sp.Rational(*number.as_integer_ratio())


@PART.verified(
    "Example 19.5 half cycles",
    "N until it stays at rest, Delta_s >= Delta",
    transient.half_cycles(symbolic=True),
    numbers=f"against the motion in exact numbers, {len(_DATA)} starts",
)
def _(claim):
    return _misfit(claim, lambda n, rest: n)


@PART.verified(
    "Example 19.5 rest",
    "where it stays, within Delta_s",
    transient.stop_position(symbolic=True),
    note="2 N Delta takes the sign of x0",
    numbers=f"against the motion in exact numbers, {len(_DATA)} starts",
)
def _(claim):
    return _misfit(claim, lambda n, rest: _exact(rest))


@PART.verified(
    "Example 19.5 time",
    "when it stays, all half cycles being equal",
    transient.stop_time(symbolic=True),
    numbers=f"against the motion in exact numbers, {len(_DATA)} starts",
)
def _(claim):
    each = _next_rest(Delta * omega**2, V)[0]
    return _misfit(claim, lambda n, rest: n * each)


NUMBERS = (
    (sp.Rational(3, 100), 17, sp.Rational(1, 50)),
    (sp.Rational(1, 10), 5, 0),
    (sp.Rational(1, 3), 1, -sp.Rational(1, 3)),
)
for _delta, _n, _rest in NUMBERS:

    @PART.verified(f"Example 19.5 Delta = {_delta}", "N and rest from x0 = 1, Delta_s = Delta", _n, _rest)
    def _(halves, rest, delta=_delta):
        n, position = _walk(*(Fraction(e.p, e.q) for e in (delta, delta, sp.Integer(1))))
        found = transient.half_cycles(delta), transient.stop_position(delta)
        return n - halves, _exact(position) - rest, found[0] - halves, _exact(found[1]) - rest
