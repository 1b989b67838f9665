"""Scalar expressions whose operators build their node at once.

CasADi's own operators try the overloads of all its types one after the other, which takes ten times as long as the node
itself. `SX.unary` and `SX.binary` take one type only and make the same expression, down to the order of its nodes.
"""

from collections.abc import Sequence
from typing import Any

import casadi as ca

_unary, _binary = ca.SX.unary, ca.SX.binary
Entry = ca.SX | float


class Scalar(ca.SX):
    """An SX of one entry, to be mixed with any other; what is made of it by these operators is one again."""

    def __add__(self, other: Any) -> "Scalar":
        return binary(ca.OP_ADD, self, other)

    def __radd__(self, other: Any) -> "Scalar":
        return binary(ca.OP_ADD, other, self)

    def __sub__(self, other: Any) -> "Scalar":
        return binary(ca.OP_SUB, self, other)

    def __rsub__(self, other: Any) -> "Scalar":
        return binary(ca.OP_SUB, other, self)

    def __mul__(self, other: Any) -> "Scalar":
        return binary(ca.OP_MUL, self, other)

    def __rmul__(self, other: Any) -> "Scalar":
        return binary(ca.OP_MUL, other, self)

    def __truediv__(self, other: Any) -> "Scalar":
        return binary(ca.OP_DIV, self, other)

    def __rtruediv__(self, other: Any) -> "Scalar":
        return binary(ca.OP_DIV, other, self)

    def __pow__(self, other: Any, modulus: Any = None) -> "Scalar":
        return binary(ca.OP_POW, self, other)

    def __neg__(self) -> "Scalar":
        return unary(ca.OP_NEG, self)

    def __lt__(self, other: Any) -> "Scalar":
        return binary(ca.OP_LT, self, other)

    def __le__(self, other: Any) -> "Scalar":
        return binary(ca.OP_LE, self, other)

    def __gt__(self, other: Any) -> "Scalar":
        return binary(ca.OP_LT, other, self)

    def __ge__(self, other: Any) -> "Scalar":
        return binary(ca.OP_LE, other, self)


def scalar(e: Entry) -> Scalar:
    """Return a number or an expression of one entry as a scalar."""
    return Scalar(e)


def binary(op: int, a: Entry, b: Entry) -> Scalar:
    """Return an operation on two numbers or expressions."""
    made: Any = _binary(op, a if isinstance(a, ca.SX) else ca.SX(a), b if isinstance(b, ca.SX) else ca.SX(b))
    made.__class__ = Scalar
    return made


def unary(op: int, a: ca.SX) -> Scalar:
    """Return an operation on an expression."""
    made: Any = _unary(op, a)
    made.__class__ = Scalar
    return made


def applied(op: int, values: Sequence[ca.SX]) -> Scalar:
    """Return an operation on one expression or two."""
    return unary(op, *values) if len(values) == 1 else binary(op, *values)


def fabs(e: ca.SX) -> Scalar:
    return unary(ca.OP_FABS, e)


def fmax(a: Entry, b: Entry) -> Scalar:
    return binary(ca.OP_FMAX, a, b)


def logic_and(a: Entry, b: Entry) -> Scalar:
    return binary(ca.OP_AND, a, b)


def logic_or(a: Entry, b: Entry) -> Scalar:
    return binary(ca.OP_OR, a, b)


def logic_not(e: ca.SX) -> Scalar:
    return unary(ca.OP_NOT, e)


def if_else(condition: ca.SX, then: Entry, otherwise: Entry) -> Scalar:
    """Return one of two values; where a condition does not hold its value counts as zero, infinite ones too."""
    return binary(
        ca.OP_ADD,
        binary(ca.OP_IF_ELSE_ZERO, condition, then),
        binary(ca.OP_IF_ELSE_ZERO, unary(ca.OP_NOT, condition), otherwise),
    )
