"""Bound what the Taylor series of a step cannot know: features of functions that begin later in the step.

All derivatives of ``exp(-((t - 3)/w)^2)`` are zero to rounding at t = 0, so the coefficients of a step say nothing of
the pulse that it leaps over. Here every operation gets an interval ``middle +- radius`` that holds its values while the
states and time stay within given intervals, and a bound of the part of its variation that may be *unseen*. Functions
that change by no more than a moderate factor over their interval hide nothing from a check at a few points; any other
one may hide all of its range. Sums and products pass on what their arguments hide, times their slopes.

References
----------
Moore, Kearfott and Cloud, Introduction to Interval Analysis (2009), chapters 5 and 6, for the intervals.
"""

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from symfric.errors import SceneError
from symfric.solve.taylor.instructions import ENTIRE, Node, read

_EXPONENT = 4.0  # an exponent may change by so much over a tame interval
_RATIO = 16.0  # and what a quotient, root or logarithm is taken of by this factor
_ANGLE = 4.0  # rad; no step spans more of a sine
_FLAT = 700.0  # exponentials of more are as good as infinite, of less than its negative as zero
_PASSING = {ca.OP_ADD, ca.OP_SUB, ca.OP_MUL, ca.OP_SQ, ca.OP_DIV, ca.OP_IF_ELSE_ZERO, ca.OP_NEG, ca.OP_TWICE}
_PASSING |= {ca.OP_ASSIGN, ca.OP_LIFT}


@dataclass(frozen=True)
class _Range:
    """Values of one operation: ``middle +- radius``; `unseen` bounds what a check at a few points may miss."""

    middle: ca.SX
    radius: ca.SX | None = None  # None: exactly zero
    unseen: ca.SX | None = None

    @property
    def spread(self) -> ca.SX:
        return ca.SX(0) if self.radius is None else self.radius

    @property
    def low(self) -> ca.SX:
        return self.middle - self.spread

    @property
    def high(self) -> ca.SX:
        return self.middle + self.spread

    @property
    def smallest(self) -> ca.SX:
        """Return the smallest magnitude."""
        return _at_least(ca.fabs(self.middle) - self.spread, 0)

    @property
    def largest(self) -> ca.SX:
        return ca.fabs(self.middle) + self.spread


# What has no value in an interval, as the logarithm of one that holds zero, must stay NaN: `fmin` and `fmax` lose it.


def _at_least(e: ca.SX, least: float) -> ca.SX:
    return ca.if_else(e < least, least, e)


def _at_most(e: ca.SX, most: ca.SX | float) -> ca.SX:
    return ca.if_else(e > most, most, e)


def degrees(nodes: list[Node]) -> list[int]:
    """Return how many factors that move every node has, as a polynomial of states, time and functions."""
    found: list[int] = []
    for node in nodes:
        if not node.moves:
            found.append(0)
        elif node.op == ca.OP_SQ:
            found.append(2 * found[node.args[0]])
        elif node.op == ca.OP_MUL:
            found.append(sum(found[a] for a in node.args))
        elif node.op in ENTIRE and node.op not in (ca.OP_SIN, ca.OP_COS):
            found.append(max((found[a] for a in node.args), default=1))
        else:
            found.append(1)
    return found


def hiding(nodes: list[Node], order: int) -> list[bool]:
    """Return for every node whether something later in a step may be unseen in its coefficients up to `order`.

    Powers of more than half the order may begin with coefficients that are all zero.
    """
    degree = degrees(nodes)
    found: list[bool] = []
    for node, n in zip(nodes, degree, strict=True):
        own = node.moves and (node.op not in ENTIRE or (n > order // 2 and node.op in (ca.OP_MUL, ca.OP_SQ)))
        found.append(own or any(found[a] for a in node.args))
    return found


def unseen(
    nodes: list[Node], wanted: list[int], n_x: int, order: int, fixed: Callable[[int], ca.SX | None]
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return the box ``[middles; radii]`` of states and time, and what it implies for the nodes `wanted`.

    That is what may be unseen in them, and how large they were if no term cancelled another, the scale of rounding.

    Parameters
    ----------
    nodes : list of Node
    wanted : list of int
    n_x : int
        Number of states.
    order : int
        Of the series.
    fixed : callable
        Value of a node that does not move, None if it is zero.
    """
    box = ca.SX.sym("box", 2 * (n_x + 1))
    needed = _ancestors(nodes, wanted)
    degree = degrees(nodes)
    ranges: dict[int, _Range] = {}
    for i in sorted(needed):
        node = nodes[i]
        if not node.moves:
            value = fixed(i)
            ranges[i] = _Range(ca.SX(0) if value is None else ca.SX(value))
        elif node.place is not None:
            k = node.place[1] if node.place[0] == 0 else n_x
            ranges[i] = _Range(box[k], box[n_x + 1 + k])
        else:
            ranges[i] = _operation(node.op, [ranges[a] for a in node.args])
            if node.op in (ca.OP_MUL, ca.OP_SQ) and degree[i] > order // 2:
                ranges[i] = _judged(ranges[i], _within(ranges[i].smallest, ranges[i].largest), ranges[i].unseen)
    bounds = [ranges[i].unseen for i in wanted]
    sizes = _magnitudes(nodes, sorted(needed), ranges)
    return box, ca.vertcat(*(ca.SX(0) if e is None else e for e in bounds)), ca.vertcat(*(sizes[i] for i in wanted))


def _magnitudes(nodes: list[Node], needed: list[int], ranges: dict[int, _Range]) -> dict[int, ca.SX]:
    found: dict[int, ca.SX] = {}
    for i in needed:
        op, a = nodes[i].op, nodes[i].args
        if not nodes[i].moves or op not in _PASSING:
            found[i] = ranges[i].largest
        elif op in (ca.OP_ADD, ca.OP_SUB):
            found[i] = found[a[0]] + found[a[1]]
        elif op in (ca.OP_MUL, ca.OP_SQ):
            found[i] = found[a[0]] * found[a[-1]]
        elif op == ca.OP_DIV:
            found[i] = found[a[0]] / ranges[a[1]].smallest
        elif op == ca.OP_IF_ELSE_ZERO:
            found[i] = ca.if_else(ranges[a[0]].middle, found[a[1]], 0)
        else:
            found[i] = 2 * found[a[0]] if op == ca.OP_TWICE else found[a[0]]
    return found


def unseen_by(field: ca.Function, order: int) -> ca.Function | None:
    """Return ``(box, p, m) -> bounds`` for every row of a field, None if nothing can be unseen in any.

    Parameters
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``.
    order : int
        Of the method that follows the motion.
    """
    nodes, outputs = read(field)
    wanted = [i for row in outputs for i in row]
    if not any(hiding(nodes, order)[i] for i in wanted):
        return None
    given = {k: ca.SX.sym(field.name_in(k), field.nnz_in(k)) for k in (2, 3)}
    values: dict[int, ca.SX] = {}
    for i, node in enumerate(nodes):
        if node.number is not None:
            values[i] = ca.SX(node.number)
        elif node.place is not None and not node.moves:
            values[i] = given[node.place[0]][node.place[1]]
        elif not node.moves:
            a = [values[j] for j in node.args]
            values[i] = ca.SX.unary(node.op, *a) if len(a) == 1 else ca.SX.binary(node.op, *a)
    box, bounds, _ = unseen(nodes, wanted, field.nnz_in(0), order, values.__getitem__)
    return ca.Function("unseen", [box, given[2], given[3]], [ca.densify(bounds)], {"cse": True})


def _ancestors(nodes: list[Node], wanted: list[int]) -> set[int]:
    found, todo = set(), list(wanted)
    while todo:
        i = todo.pop()
        if i not in found:
            found.add(i)
            if nodes[i].moves:
                todo += nodes[i].args
    return found


def _operation(op: int, a: list[_Range]) -> _Range:
    if op in (ca.OP_ADD, ca.OP_SUB):
        middle = ca.SX.binary(op, a[0].middle, a[1].middle)
        return _Range(middle, _plus(a[0].radius, a[1].radius), _plus(a[0].unseen, a[1].unseen))
    if op == ca.OP_NEG:
        return _Range(-a[0].middle, a[0].radius, a[0].unseen)
    if op == ca.OP_TWICE:
        return _Range(2 * a[0].middle, _times(2, a[0].radius), _times(2, a[0].unseen))
    if op in (ca.OP_ASSIGN, ca.OP_LIFT):
        return a[0]
    if op == ca.OP_IF_ELSE_ZERO:
        chosen = lambda e: None if e is None else ca.if_else(a[0].middle, e, 0)  # noqa: E731
        return _Range(ca.if_else(a[0].middle, a[1].middle, 0), chosen(a[1].radius), chosen(a[1].unseen))
    if op == ca.OP_MUL:
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


def _plus(a: ca.SX | None, b: ca.SX | None) -> ca.SX | None:
    return b if a is None else a if b is None else a + b


def _times(factor, a: ca.SX | None) -> ca.SX | None:
    return None if a is None else factor * a


def _product(a: _Range, b: _Range) -> _Range:
    radius = _plus(_times(ca.fabs(a.middle), b.radius), _times(b.largest, a.radius))
    return _Range(a.middle * b.middle, radius, _plus(_times(a.largest, b.unseen), _times(b.largest, a.unseen)))


def _between(low: ca.SX, high: ca.SX, inherited: ca.SX | None) -> _Range:
    return _Range(0.5 * (low + high), ca.if_else(low == high, 0, 0.5 * (high - low)), inherited)


def _judged(values: _Range, tame: ca.SX, inherited: ca.SX | None) -> _Range:
    """Return values of which all may be unseen unless they are tame; then only what their arguments hide."""
    width = 2 * values.spread
    passed_on = ca.SX(0) if inherited is None else _at_most(inherited, width)
    return _Range(values.middle, values.radius, ca.if_else(tame, passed_on, width))


def _within(small: ca.SX, large: ca.SX) -> ca.SX:
    """Return whether a positive quantity changes by no more than a moderate factor."""
    return ca.logic_and(small > 0, large <= _RATIO * small)


def _rising(function: Callable, tame: Callable, slope: Callable) -> Callable[[_Range], _Range]:
    """Return the rule of a function that rises throughout."""

    def rule(a: _Range) -> _Range:
        values = _between(function(a.low), function(a.high), None)
        return _judged(values, tame(a), None if a.unseen is None else slope(a) * a.unseen)

    return rule


def _inverse(a: _Range) -> _Range:
    first, second = 1 / a.low, 1 / a.high
    away = a.smallest > 0
    radius = ca.if_else(away, 0.5 * ca.fabs(second - first), ca.inf)
    values = _Range(0.5 * (first + second), radius)
    return _judged(values, _within(a.smallest, a.largest), _times(1 / a.smallest**2, a.unseen))


def _power(a: _Range, exponent: ca.SX) -> _Range:
    low = _at_least(a.low, 0)  # what moves stays on its side of zero, whatever is lost by rounding
    first, second = low**exponent, a.high**exponent
    rises = first < second
    values = _between(ca.if_else(rises, first, second), ca.if_else(rises, second, first), None)
    slope = ca.fabs(exponent) * ca.if_else(low > 0, ca.fmax(first / low, second / a.high), ca.inf)
    moderate = _within(low, a.high) * (ca.fabs(exponent) * (a.high - low) <= _EXPONENT * a.high)
    return _judged(values, moderate, _times(slope, a.unseen))


def _angle(y: _Range, x: _Range) -> _Range:
    """Return atan2(y, x); its slope is at most one over the distance from the origin."""
    near = ca.fmax(x.smallest, y.smallest)
    far = x.largest + y.largest
    reach = _plus(x.radius, y.radius)
    radius = ca.SX(0) if reach is None else _at_most(reach / near, 2 * ca.pi)
    values = _Range(ca.atan2(y.middle, x.middle), ca.if_else(near > 0, radius, 2 * ca.pi))
    return _judged(values, _within(near, far), _times(1 / near, _plus(x.unseen, y.unseen)))


def _cosh(a: _Range) -> _Range:
    values = _between(_flat(ca.cosh)(a.smallest), _flat(ca.cosh)(a.largest), None)
    return _judged(values, _exponential(a), _times(_flat(ca.sinh)(a.largest), a.unseen))


def _wave(function: Callable) -> Callable[[_Range], _Range]:
    def rule(a: _Range) -> _Range:
        wide = a.spread > 1.5
        values = _Range(ca.if_else(wide, 0, function(a.middle)), ca.if_else(wide, 1, a.spread))
        return _judged(values, 2 * a.spread <= _ANGLE, a.unseen)

    return rule


def _tan(a: _Range) -> _Range:
    branch = lambda e: ca.floor(e / ca.pi + 0.5)  # noqa: E731
    low, high = ca.tan(a.low), ca.tan(a.high)
    same = ca.logic_and(branch(a.low) == branch(a.high), a.spread < 0.5 * ca.pi)
    values = _between(low, high, None)
    values = _Range(values.middle, ca.if_else(same, values.spread, ca.inf))
    return _judged(values, same * _of_square(values), _times(1 + values.largest**2, a.unseen))


def _exponential(a: _Range) -> ca.SX:
    return 2 * a.spread <= _EXPONENT


def _of_square(a: _Range) -> ca.SX:
    """Return whether 1 + a^2 changes by no more than a moderate factor."""
    return _within(1 + a.smallest**2, 1 + a.largest**2)


def _inside(a: _Range) -> ca.SX:
    """Return whether 1 - a^2 changes by no more than a moderate factor."""
    return _within(1 - a.largest**2, 1 - a.smallest**2)


def _clipped(function: Callable) -> Callable:
    return lambda e: function(_at_most(_at_least(e, -1), 1))


def _flat(function: Callable) -> Callable:
    return lambda e: function(_at_most(_at_least(e, -_FLAT), _FLAT))


def _log(a: _Range) -> _Range:
    return _rising(ca.log, lambda e: _within(e.low, e.high), lambda e: 1 / e.low)(a)


def _falling(rule: Callable[[_Range], _Range], whole: float) -> Callable[[_Range], _Range]:
    """Return the rule of ``whole - f``."""

    def negated(a: _Range) -> _Range:
        values = rule(a)
        return _Range(whole - values.middle, values.radius, values.unseen)

    return negated


def _shifted(rule: Callable[[_Range], _Range], before: float, after: float) -> Callable[[_Range], _Range]:
    """Return the rule of ``f(before + a) + after``."""

    def moved(a: _Range) -> _Range:
        values = rule(_Range(a.middle + before, a.radius, a.unseen))
        return _Range(values.middle + after, values.radius, values.unseen)

    return moved


def _exp(a: _Range) -> _Range:
    """Return the rule of the exponential; with ``(1 - x/4)^4 <= exp(-x)`` it takes one, which costs most here."""
    high = _flat(lambda e: e)(a.high)
    change = high - _flat(lambda e: e)(a.low)
    most = ca.exp(high)
    least = most * _at_least(1 - change / _EXPONENT, 0) ** 4
    values = _between(least, most, None)
    return _judged(values, _exponential(a), None if a.unseen is None else most * a.unseen)


_asin = _rising(_clipped(ca.asin), _inside, lambda a: 1 / ca.sqrt(1 - a.largest**2))

_FUNCTIONS: dict[int, Callable[[_Range], _Range]] = {
    ca.OP_INV: _inverse,
    ca.OP_SQRT: lambda a: _power(a, ca.SX(0.5)),
    ca.OP_EXP: _exp,
    ca.OP_EXPM1: _shifted(_exp, 0.0, -1.0),
    ca.OP_LOG: _log,
    ca.OP_LOG1P: _shifted(_log, 1.0, 0.0),
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
        lambda a: _within(a.low - 1, a.high - 1),
        lambda a: 1 / ca.sqrt(a.low**2 - 1),
    ),
}
