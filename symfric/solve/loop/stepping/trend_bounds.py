"""Intervals of what is squared under a root, a speed in the plane, with the terms that cancel in it.

A small slip is the difference of large velocities. Their intervals add in the interval of the slip, although what they
have in common cancels, and steps would be cut into parts over which all of them change less than the slip itself. Here
a node is ``middle + slope s + rest`` over ``|s| <= 1``, where s is the time in the box, from -1 to 1, and rest a
radius: slopes cancel in a sum as the values do. These are Taylor models of the first order.

References
----------
Makino and Berz, Taylor models and other validated functional inclusion methods, International Journal of Pure and
Applied Mathematics 6 (2003) 239.
"""

from dataclasses import dataclass

import casadi as ca

from symfric.codegen.instructions import Node
from symfric.scalars import Scalar, binary, fabs, if_else, scalar, unary
from symfric.solve.loop.stepping.operation_bounds import Range

_LINEAR = {ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE, ca.OP_ASSIGN, ca.OP_LIFT}
_RULES = _LINEAR | {ca.OP_MUL, ca.OP_SIN, ca.OP_COS}
_THROUGH = {ca.OP_ADD, ca.OP_ASSIGN, ca.OP_LIFT}  # between a root and the squares below it


@dataclass(frozen=True)
class Trend:
    """What a node does over a box, beside its middle."""

    slope: Scalar
    rest: Scalar

    @property
    def radius(self) -> Scalar:
        """Radius of its interval."""
        return fabs(self.slope) + self.rest


_STILL = Trend(scalar(0), scalar(0))


def squared_under_roots(nodes: list[Node]) -> set[int]:
    """Return the nodes that move whose squares are added up under a square root, two or more of them."""
    found: set[int] = set()
    for node in nodes:
        if node.op != ca.OP_SQRT:
            continue
        squares, todo = set(), list(node.args)
        while todo:
            below = nodes[todo.pop()]
            if below.op == ca.OP_SQ:
                squares.add(below.args[0])
            elif below.op in _THROUGH:
                todo += below.args
            elif below.op == ca.OP_IF_ELSE_ZERO:
                todo.append(below.args[1])
        squares = {i for i in squares if nodes[i].moves}
        if len(squares) > 1:
            found |= squares
    return found


def trend_of(op: int, ranges: list[Range], trends: list[Trend | None], own: Range) -> Trend:
    """Return the trend of an operation, given the values and the trends of its arguments, and its own values."""
    if op not in _RULES:
        return Trend(scalar(0), own.spread)
    a = [t or _STILL for t in trends]
    if op in (ca.OP_ADD, ca.OP_SUB):
        return Trend(binary(op, a[0].slope, a[1].slope), a[0].rest + a[1].rest)
    if op == ca.OP_NEG:
        return Trend(-a[0].slope, a[0].rest)
    if op == ca.OP_TWICE:
        return Trend(2 * a[0].slope, 2 * a[0].rest)
    if op in (ca.OP_ASSIGN, ca.OP_LIFT):
        return a[0]
    first = ranges[0].middle
    if op == ca.OP_MUL:
        second = ranges[1].middle
        slope = first * a[1].slope + second * a[0].slope
        rest = fabs(first) * a[1].rest + fabs(second) * a[0].rest
        return Trend(slope, rest + a[0].radius * a[1].radius)
    slope = (unary(ca.OP_COS, first) if op == ca.OP_SIN else -unary(ca.OP_SIN, first)) * a[0].slope
    rest = a[0].rest + 0.5 * a[0].radius ** 2
    narrow = ranges[0].spread < 1  # otherwise the middle of the values is another one
    return Trend(if_else(narrow, slope, 0), if_else(narrow, rest, own.spread))


def narrowed(values: Range, trend: Trend) -> Range:
    """Return values with the smaller one of both radii."""
    radius = trend.radius
    return Range(values.middle, if_else(radius < values.spread, radius, values.spread), values.unseen)
