"""Taylor coefficients of the elementary operations.

The recurrences are those of Moore and of Griewank and Walther, Evaluating Derivatives (2008), chapter 13.
"""

from collections.abc import Callable
from typing import Any

import casadi as ca

from symfric.codegen.instructions import GROWING
from symfric.errors import SceneError
from symfric.scalars import applied, binary, if_else

Value = Any  # SX, or None, a structural zero
Jet = list[Value]  # coefficients by order
Rule = Callable[[int, Jet, list[Jet], Jet], Value]
_MOST = 1e150  # largest value of an exponential, so that products of two are finite
_NO_EXPONENTIAL, _NO_RECIPROCAL = 1e-290, 2e-150  # below them, a value that saturates is constant


def at(jet: Jet, k: int) -> Value:
    return jet[k] if k < len(jet) else None


def times(a: Value, b: Value) -> Value:
    return None if a is None or b is None else binary(ca.OP_MUL, a, b)


def plus(a: Value, b: Value) -> Value:
    if a is None:
        return b
    return a if b is None else binary(ca.OP_ADD, a, b)


def minus(a: Value, b: Value) -> Value:
    if b is None:
        return a
    return -b if a is None else binary(ca.OP_SUB, a, b)


def _newest_last(k: int) -> list[int]:
    """Return 1 .. k - 1, ordered by the larger of j and k - j, so that the newest coefficients come last."""
    return sorted(range(1, k), key=lambda j: max(j, k - j))


def _convolution(a: Jet, b: Jet, k: int) -> Value:
    """Sum of a[j] b[k-j] for j = 1 .. k - 1, newest coefficients last, so that earlier terms are summed in advance."""
    total = None
    for j in _newest_last(k):
        total = plus(total, times(at(a, j), at(b, k - j)))
    return total


def _derivative(a: Jet) -> Jet:
    """Return j a[j] for every j, the coefficients of the derivative."""
    return [scaled(e, j) for j, e in enumerate(a)]


def _product(a: Jet, b: Jet, k: int, last: int = 0) -> Value:
    """Sum of a[j] b[k-j] for j = 0 .. k - last.

    The terms with the newest coefficients are added last: the others are ready long before, and the recurrence from one
    order to the next, which sets the time of a call, becomes one multiplication and one addition.
    """
    if k == 0:
        return times(at(a, 0), at(b, 0))
    rest = _convolution(a, b, k)
    if last == 0:
        rest = plus(rest, times(at(a, k), at(b, 0)))
    return plus(rest, times(at(a, 0), at(b, k)))


def _square(a: Jet, k: int, first: int = 0) -> Value:
    """Coefficient k of a^2 (from index `first` on both sides), each pair once, the newest last."""
    pairs = None
    for j in range((k - 1) // 2, 1, -1):
        pairs = plus(pairs, times(at(a, j), at(a, k - j)))
    middle = times(at(a, k // 2), at(a, k // 2)) if k % 2 == 0 and k // 2 >= first else None
    rest = plus(scaled(pairs, 2), middle)
    for j in range(min(1, (k - 1) // 2), first - 1, -1):
        rest = plus(rest, times(scaled(at(a, j), 2), at(a, k - j)))
    return rest


def scaled(a: Value, factor: float) -> Value:
    return None if a is None else binary(ca.OP_MUL, a, factor)


def _moment(a: Jet, b: Jet, k: int, last: int = 0) -> Value:
    """1/k times the sum of j a[j] b[k-j], j = 1 .. k - last: coefficient k of the integral of a' b; the newest last."""
    rest = scaled(_convolution(_derivative(a[: k + 1]), b, k), 1 / k)
    return rest if last else plus(rest, times(at(a, k), at(b, 0)))


def coefficient(
    op: int, k: int, out: Jet, args: list[Jet], partner: Jet, saturates: bool = False, grows: bool = False
) -> Value:
    """Return coefficient k of an operation, given its coefficients below k and those of its arguments up to k.

    `partner` holds the coefficients of a second quantity that some operations carry along; it is appended to. Where an
    operation that `saturates` has reached its limit to all digits, as 1/cosh(1000), later coefficients are zero: those
    of its argument may be infinite. One that `grows` beyond all numbers is kept finite, so that it may be multiplied by
    what vanishes as fast.

    Raises
    ------
    SceneError
        If the operation has no recurrence; named.
    """
    a = args[0]
    if op == ca.OP_ADD:
        return plus(at(a, k), at(args[1], k))
    if op == ca.OP_SUB:
        return minus(at(a, k), at(args[1], k))
    if op == ca.OP_MUL:
        return _product(a, args[1], k)
    if op == ca.OP_NEG:
        return minus(None, at(a, k))
    if op == ca.OP_TWICE:
        return scaled(at(a, k), 2)
    if op == ca.OP_SQ:
        return _square(a, k)
    if op == ca.OP_IF_ELSE_ZERO:
        if len(a) > 1:
            raise SceneError("a condition depends on the state outside a switch; write it as a Piecewise")
        chosen = at(args[1], k)
        return None if chosen is None or a[0] is None else if_else(a[0], chosen, 0)
    if op in (ca.OP_ASSIGN, ca.OP_LIFT):
        return at(a, k)
    if k == 0:
        return _first(op, args, partner, grows and op in GROWING)
    rule = _RULES.get(op)
    if rule is None:
        raise SceneError(f"the operation {_name(op)} has no Taylor recurrence; use route='integrators'")
    new = rule(k, out, args, partner)
    if new is None or not saturates:
        return new
    value, least = (out[0], _NO_EXPONENTIAL) if op == ca.OP_EXP else (ca.fabs(partner[0]), _NO_RECIPROCAL)
    return ca.if_else(value < least, 0, new)


def _first(op: int, args: list[Jet], partner: Jet, grows: bool) -> Value:
    values = [ca.SX(0) if j[0] is None else j[0] for j in args]
    out = applied(op, values)
    if op in _PARTNERS:
        partner.append(_PARTNERS[op](values, out))
    if not grows:
        return out
    if partner:
        partner[0] = _capped(partner[0])
    return _capped(out)


def _capped(e: ca.SX) -> ca.SX:
    return ca.if_else(e > _MOST, _MOST, ca.if_else(e < -_MOST, -_MOST, e))


def _name(op: int) -> str:
    names = [n for n in dir(ca) if n.startswith("OP_") and getattr(ca, n) == op]
    return names[0] if names else f"number {op}"


def _divide(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
    a, b = args
    # out b = a
    return times(minus(at(a, k), _product(out, b, k, last=1)), partner[0])


def _invert(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
    return times(minus(None, _product(out, args[0], k, last=1)), partner[0])


def _sqrt(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
    return times(minus(at(args[0], k), _square(out, k, first=1)), partner[0])  # out^2 = a


def _exp(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
    return _moment(args[0], out, k)  # out' = out a'


def _expm1(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
    return plus(_moment(args[0], out, k), at(args[0], k))  # out' = (out + 1) a'


def _log(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
    return times(minus(at(args[0], k), _moment(out, args[0], k, last=1)), partner[0])  # out' a = a'


def _pow(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
    """``out a' e = a out'`` for a constant exponent e."""
    a, e = args[0], args[1][0]
    total = None
    for j in (*_newest_last(k), 0):
        total = plus(total, times(times(at(a, k - j), at(out, j)), e * ((k - j) / k) - j / k))
    return times(total, partner[0])


def _with_cofactor(outer: float, inner: float) -> Rule:
    """Pairs such as (sin, cos): out' = outer * partner * a', partner' = inner * out * a'."""

    def rule(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
        new = scaled(_moment(args[0], partner, k), outer)
        other = scaled(_moment(args[0], out, k), inner)
        partner.append(other)
        return new

    return rule


def _from_square(sign: float) -> Rule:
    """tan (+) and tanh (-): out' = (1 +- out^2) a'; the partner is 1 +- out^2."""

    def rule(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
        new = _moment(args[0], partner, k)
        partner.append(scaled(_square([*out, new], k), sign))
        return new

    return rule


def _from_root(root_of: float, outer: float) -> Rule:
    """asin, acos, asinh, acosh: out' root = outer a', root^2 = root_of(a); the partner is the root."""

    def rule(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
        a = args[0]
        root = scaled(_square(a, k), root_of)
        partner.append(times(minus(root, _square([*partner, None], k, first=1)), 0.5 / partner[0]))
        rest = _moment(out, partner, k, last=1)
        return times(minus(scaled(at(a, k), outer), rest), 1 / partner[0])

    return rule


def _from_rational(sign: float) -> Rule:
    """atan (+) and atanh (-): out' (1 +- a^2) = a'; the partner is 1 +- a^2."""

    def rule(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
        a = args[0]
        partner.append(scaled(_square(a, k), sign))
        rest = _moment(out, partner, k, last=1)
        return times(minus(at(a, k), rest), 1 / partner[0])

    return rule


def _erf(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
    """out' = 2/sqrt(pi) exp(-a^2) a'; the partner is that exponential's jet."""
    a = args[0]
    new = _moment(a, partner, k)
    partner.append(_moment([scaled(_square(a, j), -1.0) for j in range(k + 1)], partner, k))
    return new


def _floor(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
    """What a floor counts are whole periods before the step; the guards within it are those of the next instant."""
    return None


def _atan2(k: int, out: Jet, args: list[Jet], partner: Jet) -> Value:
    """out' (x^2 + y^2) = x y' - y x'; the partner is x^2 + y^2."""
    y, x = args
    partner.append(plus(_square(x, k), _square(y, k)))
    turn = minus(_moment(y, x, k), _moment(x, y, k))
    rest = _moment(out, partner, k, last=1)
    return times(minus(turn, rest), 1 / partner[0])


_RULES = {
    ca.OP_DIV: _divide,
    ca.OP_INV: _invert,
    ca.OP_SQRT: _sqrt,
    ca.OP_EXP: _exp,
    ca.OP_EXPM1: _expm1,
    ca.OP_LOG: _log,
    ca.OP_LOG1P: lambda k, out, args, partner: _log(k, out, [[1 + args[0][0], *args[0][1:]]], partner),
    ca.OP_POW: _pow,
    ca.OP_CONSTPOW: _pow,
    ca.OP_SIN: _with_cofactor(1.0, -1.0),
    ca.OP_COS: _with_cofactor(-1.0, 1.0),
    ca.OP_SINH: _with_cofactor(1.0, 1.0),
    ca.OP_COSH: _with_cofactor(1.0, 1.0),
    ca.OP_TAN: _from_square(1.0),
    ca.OP_TANH: _from_square(-1.0),
    ca.OP_ASIN: _from_root(-1.0, 1.0),
    ca.OP_ACOS: _from_root(-1.0, -1.0),
    ca.OP_ASINH: _from_root(1.0, 1.0),
    ca.OP_ACOSH: _from_root(1.0, 1.0),
    ca.OP_ATAN: _from_rational(1.0),
    ca.OP_ATANH: _from_rational(-1.0),
    ca.OP_ERF: _erf,
    ca.OP_ATAN2: _atan2,
    ca.OP_FLOOR: _floor,
}

# coefficient 0 of the companion that a recurrence carries along, from the argument values and the result
_PARTNERS = {
    ca.OP_DIV: lambda v, out: 1 / v[1],
    ca.OP_INV: lambda v, out: out,
    ca.OP_SQRT: lambda v, out: 0.5 / out,
    ca.OP_LOG: lambda v, out: 1 / v[0],
    ca.OP_LOG1P: lambda v, out: 1 / (1 + v[0]),
    ca.OP_POW: lambda v, out: 1 / v[0],
    ca.OP_CONSTPOW: lambda v, out: 1 / v[0],
    ca.OP_SIN: lambda v, out: ca.cos(v[0]),
    ca.OP_COS: lambda v, out: ca.sin(v[0]),
    ca.OP_SINH: lambda v, out: ca.cosh(v[0]),
    ca.OP_COSH: lambda v, out: ca.sinh(v[0]),
    ca.OP_TAN: lambda v, out: 1 + out * out,
    ca.OP_TANH: lambda v, out: 1 - out * out,
    ca.OP_ASIN: lambda v, out: ca.sqrt(1 - v[0] * v[0]),
    ca.OP_ACOS: lambda v, out: ca.sqrt(1 - v[0] * v[0]),
    ca.OP_ASINH: lambda v, out: ca.sqrt(1 + v[0] * v[0]),
    ca.OP_ACOSH: lambda v, out: ca.sqrt(v[0] * v[0] - 1),
    ca.OP_ATAN: lambda v, out: 1 + v[0] * v[0],
    ca.OP_ATANH: lambda v, out: 1 - v[0] * v[0],
    ca.OP_ERF: lambda v, out: 2 / ca.sqrt(ca.pi) * ca.exp(-v[0] * v[0]),
    ca.OP_ATAN2: lambda v, out: v[0] * v[0] + v[1] * v[1],
}
