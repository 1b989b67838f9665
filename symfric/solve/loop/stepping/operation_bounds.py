"""Interval bounds of the elementary operations, with the variation that a check at a few points may miss."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from symfric.errors import SceneError
from symfric.scalars import Scalar, binary, fabs, fmax, if_else, logic_and, logic_not, logic_or, scalar, unary

_EXPONENT = 4.0  # largest change of an exponent over a tame interval
_RATIO = 16.0  # largest ratio of the argument of a quotient, root or logarithm over a tame interval
_ANGLE = 4.0  # largest span of the argument of a sine over a step, rad
_FLAT = 700.0  # exponents beyond this overflow, or below its negative underflow


@dataclass(frozen=True)
class Range:
    """Values of one operation: ``middle +- radius``; `unseen` bounds what a check at a few points may miss."""

    middle: Scalar
    radius: Scalar | None = None  # None: exactly zero
    unseen: Scalar | None = None

    @cached_property
    def spread(self) -> Scalar:
        return scalar(0) if self.radius is None else self.radius

    @cached_property
    def low(self) -> Scalar:
        return self.middle - self.spread

    @cached_property
    def high(self) -> Scalar:
        return self.middle + self.spread

    @cached_property
    def smallest(self) -> Scalar:
        """Return the smallest magnitude."""
        return _at_least(fabs(self.middle) - self.spread, 0)

    @cached_property
    def largest(self) -> Scalar:
        return fabs(self.middle) + self.spread


# An undefined value, such as the logarithm of an interval with zero, must stay NaN, which `fmin` and `fmax` discard.


def _at_least(e: Scalar, least: float) -> Scalar:
    return if_else(e < least, least, e)


def _at_most(e: Scalar, most: Scalar | float) -> Scalar:
    return if_else(e > most, most, e)


def operation(op: int, a: list[Range]) -> Range:
    """Return the values of an operation, given those of its arguments.

    Raises
    ------
    SceneError
        If there is no rule for it.
    """
    if op in (ca.OP_ADD, ca.OP_SUB):
        middle = binary(op, a[0].middle, a[1].middle)
        return Range(middle, _plus(a[0].radius, a[1].radius), _plus(a[0].unseen, a[1].unseen))
    if op == ca.OP_NEG:
        return Range(-a[0].middle, a[0].radius, a[0].unseen)
    if op == ca.OP_TWICE:
        return Range(2 * a[0].middle, _times(2, a[0].radius), _times(2, a[0].unseen))
    if op in (ca.OP_ASSIGN, ca.OP_LIFT):
        return a[0]
    if op == ca.OP_IF_ELSE_ZERO:
        return _chosen(*a)
    if op in (ca.OP_LT, ca.OP_LE):
        return _decided(a[0].high < a[1].low, a[0].low > a[1].high)
    if op in (ca.OP_EQ, ca.OP_NE):
        known = a[0].spread + a[1].spread == 0
        apart = logic_or(a[0].high < a[1].low, a[0].low > a[1].high)
        same = _decided(logic_and(known, logic_not(apart)), apart)
        return same if op == ca.OP_EQ else _opposite(same)
    if op == ca.OP_NOT:
        return _opposite(a[0])
    if op == ca.OP_OR:
        return _opposite(_product(_opposite(a[0]), _opposite(a[1])))
    if op in (ca.OP_MUL, ca.OP_AND):
        return _product(*a)
    if op == ca.OP_SQ:
        return _between(a[0].smallest ** 2, a[0].largest ** 2, _times(2 * a[0].largest, a[0].unseen))
    if op == ca.OP_DIV:
        return _product(a[0], _inverse(a[1]))
    if op == ca.OP_ATAN2:
        return _angle(*a)
    if op in (ca.OP_POW, ca.OP_CONSTPOW):
        return _power(a[0], a[1].middle)
    if op not in _FUNCTIONS:
        raise SceneError(f"CasADi operation number {op} has no bound over an interval; use route='integrators'")
    return _FUNCTIONS[op](a[0])


def _opposite(condition: Range) -> Range:
    return Range(1 - condition.middle, condition.radius, condition.unseen)


def _decided(true: Scalar, false: Scalar) -> Range:
    """Return the values of a condition, 1 or 0; one that is undecided over the interval may change unseen."""
    undecided = logic_not(logic_or(true, false))
    return Range(if_else(undecided, 0.5, true), 0.5 * undecided, undecided)


def _chosen(condition: Range, values: Range) -> Range:
    """Return the values where a condition holds, zero elsewhere."""
    if condition.radius is None:
        chosen = lambda e: None if e is None else if_else(condition.middle, e, 0)  # noqa: E731
        return Range(if_else(condition.middle, values.middle, 0), chosen(values.radius), chosen(values.unseen))
    either = _product(condition, values)
    holds, fails = condition.low > 0, condition.high < 1

    def pick(known: Scalar | None, otherwise: Scalar | None) -> Scalar:
        known, otherwise = (scalar(0) if e is None else e for e in (known, otherwise))
        return if_else(fails, 0, if_else(holds, known, otherwise))

    return Range(
        pick(values.middle, either.middle), pick(values.radius, either.radius), pick(values.unseen, either.unseen)
    )


def _plus(a: Scalar | None, b: Scalar | None) -> Scalar | None:
    return b if a is None else a if b is None else a + b


def _times(factor, a: Scalar | None) -> Scalar | None:
    return None if a is None else factor * a


def _product(a: Range, b: Range) -> Range:
    for number, other in ((a, b), (b, a)):
        if number.radius is None and number.unseen is None and number.middle.is_constant():
            factor = float(number.middle)
            size = abs(factor)
            return Range(factor * other.middle, _times(size, other.radius), _times(size, other.unseen))
    radius = _plus(_times(fabs(a.middle), b.radius), _times(b.largest, a.radius))
    return Range(a.middle * b.middle, radius, _plus(_times(a.largest, b.unseen), _times(b.largest, a.unseen)))


def _between(low: Scalar, high: Scalar, inherited: Scalar | None) -> Range:
    return Range(0.5 * (low + high), if_else(low == high, 0, 0.5 * (high - low)), inherited)


def judged(values: Range, tame: Scalar, inherited: Scalar | None) -> Range:
    """Return values whose whole variation may be unseen unless they are tame; then only that of their arguments."""
    width = 2 * values.spread
    passed_on = scalar(0) if inherited is None else _at_most(inherited, width)
    return Range(values.middle, values.radius, if_else(tame, passed_on, width))


def within(small: Scalar, large: Scalar) -> Scalar:
    """Whether a positive quantity changes by at most a moderate factor."""
    return logic_and(small > 0, large <= _RATIO * small)


def _rising(function: Callable, tame: Callable, slope: Callable) -> Callable[[Range], Range]:
    """Return the rule of a monotone increasing function."""

    def rule(a: Range) -> Range:
        values = _between(function(a.low), function(a.high), None)
        return judged(values, tame(a), None if a.unseen is None else slope(a) * a.unseen)

    return rule


def _inverse(a: Range) -> Range:
    first, second = 1 / a.low, 1 / a.high
    away = a.smallest > 0
    radius = if_else(away, 0.5 * fabs(second - first), ca.inf)
    values = Range(0.5 * (first + second), radius)
    return judged(values, within(a.smallest, a.largest), _times(1 / a.smallest**2, a.unseen))


def _power(a: Range, exponent: Scalar) -> Range:
    low = _at_least(a.low, 0)  # keeps its sign in spite of rounding
    first, second = low**exponent, a.high**exponent
    rises = first < second
    values = _between(if_else(rises, first, second), if_else(rises, second, first), None)
    slope = fabs(exponent) * if_else(low > 0, fmax(first / low, second / a.high), ca.inf)
    moderate = within(low, a.high) * (fabs(exponent) * (a.high - low) <= _EXPONENT * a.high)
    return judged(values, moderate, _times(slope, a.unseen))


def _angle(y: Range, x: Range) -> Range:
    """Return atan2(y, x); its slope is at most one over the distance from the origin."""
    near = fmax(x.smallest, y.smallest)
    far = x.largest + y.largest
    reach = _plus(x.radius, y.radius)
    radius = scalar(0) if reach is None else _at_most(reach / near, 2 * ca.pi)
    values = Range(binary(ca.OP_ATAN2, y.middle, x.middle), if_else(near > 0, radius, 2 * ca.pi))
    return judged(values, within(near, far), _times(1 / near, _plus(x.unseen, y.unseen)))


def _cosh(a: Range) -> Range:
    values = _between(_flat(ca.cosh)(a.smallest), _flat(ca.cosh)(a.largest), None)
    return judged(values, _exponential(a), _times(_flat(ca.sinh)(a.largest), a.unseen))


def _wave(function: Callable) -> Callable[[Range], Range]:
    def rule(a: Range) -> Range:
        wide = a.spread > 1.5
        values = Range(if_else(wide, 0, function(a.middle)), if_else(wide, 1, a.spread))
        return judged(values, 2 * a.spread <= _ANGLE, a.unseen)

    return rule


def _tan(a: Range) -> Range:
    branch = lambda e: ca.floor(e / ca.pi + 0.5)  # noqa: E731
    low, high = unary(ca.OP_TAN, a.low), unary(ca.OP_TAN, a.high)
    same = logic_and(branch(a.low) == branch(a.high), a.spread < 0.5 * ca.pi)
    values = _between(low, high, None)
    values = Range(values.middle, if_else(same, values.spread, ca.inf))
    return judged(values, same * _of_square(values), _times(1 + values.largest**2, a.unseen))


def _exponential(a: Range) -> Scalar:
    return 2 * a.spread <= _EXPONENT


def _of_square(a: Range) -> Scalar:
    """Whether 1 + a^2 changes by at most a moderate factor."""
    return within(1 + a.smallest**2, 1 + a.largest**2)


def _inside(a: Range) -> Scalar:
    """Whether 1 - a^2 changes by at most a moderate factor."""
    return within(1 - a.largest**2, 1 - a.smallest**2)


def _clipped(function: Callable) -> Callable:
    return lambda e: function(_at_most(_at_least(e, -1), 1))


def _flat(function: Callable) -> Callable:
    return lambda e: function(_at_most(_at_least(e, -_FLAT), _FLAT))


def _log(a: Range) -> Range:
    return _rising(ca.log, lambda e: within(e.low, e.high), lambda e: 1 / e.low)(a)


def _falling(rule: Callable[[Range], Range], whole: float) -> Callable[[Range], Range]:
    """Return the rule of ``whole - f``."""

    def negated(a: Range) -> Range:
        values = rule(a)
        return Range(whole - values.middle, values.radius, values.unseen)

    return negated


def _shifted(rule: Callable[[Range], Range], before: float, after: float) -> Callable[[Range], Range]:
    """Return the rule of ``f(before + a) + after``."""

    def moved(a: Range) -> Range:
        values = rule(Range(a.middle + before, a.radius, a.unseen))
        return Range(values.middle + after, values.radius, values.unseen)

    return moved


def _exp(a: Range) -> Range:
    """Return the rule of the exponential; ``(1 - x/4)^4 <= exp(-x)`` saves a second, expensive, exponential."""
    high = _flat(lambda e: e)(a.high)
    change = high - _flat(lambda e: e)(a.low)
    most = ca.exp(high)
    least = most * _at_least(1 - change / _EXPONENT, 0) ** 4
    values = _between(least, most, None)
    return judged(values, _exponential(a), None if a.unseen is None else most * a.unseen)


_asin = _rising(_clipped(ca.asin), _inside, lambda a: 1 / ca.sqrt(1 - a.largest**2))

_FUNCTIONS: dict[int, Callable[[Range], Range]] = {
    ca.OP_INV: _inverse,
    ca.OP_SQRT: lambda a: _power(a, scalar(0.5)),
    ca.OP_EXP: _exp,
    ca.OP_EXPM1: _shifted(_exp, 0.0, -1.0),
    ca.OP_LOG: _log,
    ca.OP_LOG1P: _shifted(_log, 1.0, 0.0),
    ca.OP_FLOOR: lambda a: _between(unary(ca.OP_FLOOR, a.low), unary(ca.OP_FLOOR, a.high), None),
    ca.OP_SIN: _wave(ca.sin),
    ca.OP_COS: _wave(ca.cos),
    ca.OP_TAN: _tan,
    ca.OP_SINH: _rising(_flat(ca.sinh), _exponential, lambda a: _flat(ca.cosh)(a.largest)),
    ca.OP_COSH: _cosh,
    ca.OP_TANH: _rising(ca.tanh, lambda a: a.spread <= 0.25 * _EXPONENT, lambda a: 1 - ca.tanh(a.smallest) ** 2),
    ca.OP_ERF: _rising(
        ca.erf,
        lambda a: 2 * a.spread * a.largest <= _EXPONENT,
        lambda a: 2 / ca.sqrt(ca.pi) * ca.exp(-(a.smallest**2)),
    ),
    ca.OP_ATAN: _rising(ca.atan, _of_square, lambda a: 1 / (1 + a.smallest**2)),
    ca.OP_ASINH: _rising(ca.asinh, _of_square, lambda a: 1 / ca.sqrt(1 + a.smallest**2)),
    ca.OP_ASIN: _asin,
    ca.OP_ACOS: _falling(_asin, ca.pi / 2),
    ca.OP_ATANH: _rising(_clipped(ca.atanh), _inside, lambda a: 1 / (1 - a.largest**2)),
    ca.OP_ACOSH: _rising(
        lambda e: ca.acosh(_at_least(e, 1)),
        lambda a: within(a.low - 1, a.high - 1),
        lambda a: 1 / ca.sqrt(a.low**2 - 1),
    ),
}
