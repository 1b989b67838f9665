"""Bound features of functions later in a step that its Taylor coefficients cannot show.

All derivatives of ``exp(-((t - 3)/w)^2)`` are zero to rounding at t = 0, so the coefficients of a step say nothing of
the pulse that it leaps over. Here every operation gets an interval ``middle +- radius`` that holds its values while the
states and time stay within given intervals, and a bound of the part of its variation that may be *unseen*. Functions
that change by no more than a moderate factor over their interval hide nothing from a check at a few points; any other
one may hide all of its range. Sums and products pass on what their arguments hide, times their slopes.

References
----------
Moore, Kearfott and Cloud, Introduction to Interval Analysis (2009), chapters 5 and 6, for the intervals.
"""

from collections.abc import Callable, Iterable

import casadi as ca

from symfric.codegen.instructions import ENTIRE, Node, read
from symfric.scalars import Scalar, applied, fabs, fmax, if_else, scalar
from symfric.solve.loop.stepping.operation_bounds import Range, judged, operation, within
from symfric.solve.loop.stepping.trend_bounds import Trend, narrowed, squared_under_roots, trend_of

_PASSING = {ca.OP_ADD, ca.OP_SUB, ca.OP_MUL, ca.OP_SQ, ca.OP_DIV, ca.OP_IF_ELSE_ZERO, ca.OP_NEG, ca.OP_TWICE}
_PASSING |= {ca.OP_ASSIGN, ca.OP_LIFT, ca.OP_SQRT, ca.OP_INV}
_SUMS = (ca.OP_ADD, ca.OP_SUB)


def degrees(nodes: list[Node]) -> list[int]:
    """Return the degree of every node as a polynomial of states, time and functions."""
    of_nodes: list[int] = []
    for node in nodes:
        if not node.moves:
            of_nodes.append(0)
        elif node.op == ca.OP_SQ:
            of_nodes.append(2 * of_nodes[node.args[0]])
        elif node.op == ca.OP_MUL:
            of_nodes.append(sum(of_nodes[a] for a in node.args))
        elif node.op in ENTIRE and node.op not in (ca.OP_SIN, ca.OP_COS):
            of_nodes.append(max((of_nodes[a] for a in node.args), default=1))
        else:
            of_nodes.append(1)
    return of_nodes


def _degree(node: Node, values: Range, degree: dict[int, Scalar]) -> Scalar:
    """Return the degree over the intervals: the relative change of what keeps its sign and size, at most 1.

    Factors and terms that a mode sets to zero, and coefficients that hardly change, add nothing to a degree.
    """
    if not node.moves:
        return scalar(0)
    own = scalar(1)
    if node.op in (ca.OP_MUL, ca.OP_SQ):
        own = (2 if node.op == ca.OP_SQ else 1) * sum((degree[a] for a in node.args), scalar(0))
    elif node.op in ENTIRE and node.op not in (ca.OP_SIN, ca.OP_COS):
        for a in node.args:
            own = fmax(own, degree[a])
    change = 2 * values.spread / values.smallest
    own = if_else(within(values.smallest, values.largest), if_else(change < 1, change, 1), own)
    return if_else(values.spread > 0, own, 0)


def hiding(nodes: list[Node], order: int) -> list[bool]:
    """Return for every node whether features later in a step may be unseen in its coefficients up to `order`.

    Powers of more than half the order may begin with coefficients that are all zero.
    """
    degree = degrees(nodes)
    of_nodes: list[bool] = []
    for node, n in zip(nodes, degree, strict=True):
        own = node.moves and (node.op not in ENTIRE or (n > order // 2 and node.op in (ca.OP_MUL, ca.OP_SQ)))
        of_nodes.append(own or any(of_nodes[a] for a in node.args))
    return of_nodes


def unseen(
    nodes: list[Node],
    wanted: list[int],
    n_x: int,
    order: int,
    fixed: Callable[[int], ca.SX | None],
    powers_of: list[int] | None = None,
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return the box ``[middles; radii; slopes]`` of states and time, and bounds for the nodes `wanted`.

    Slopes are half of what they change by over the box as straight lines, a part of their radii. The bounds are those
    of unseen features, and of the sums of magnitudes of terms, the scale of rounding.

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
    powers_of : list of int, optional
        Nodes whose high powers may be unseen, by default those wanted. Rows of derivatives need no look at theirs: they
        are powers of the motion's rows, of one degree less, times derivatives.
    """
    box = ca.SX.sym("box", 3 * (n_x + 1))
    given = [scalar(e) for e in ca.vertsplit(box)]
    needed = _ancestors(nodes, wanted)
    small = squared_under_roots(nodes) & needed
    trending = _ancestors(nodes, small)
    trends: dict[int, Trend] = {}
    high = [n > order // 2 and node.op in (ca.OP_MUL, ca.OP_SQ) for n, node in zip(degrees(nodes), nodes, strict=True)]
    judging = needed if powers_of is None else needed & _ancestors(nodes, powers_of)
    rated = _ancestors(nodes, [i for i in judging if high[i]])
    ranges: dict[int, Range] = {}
    degree: dict[int, Scalar] = {}
    for i in sorted(needed):
        node = nodes[i]
        if not node.moves:
            value = fixed(i)
            ranges[i] = Range(scalar(0 if value is None else value))
        elif node.place is not None:
            k = node.place[1] if node.place[0] == 0 else n_x
            ranges[i] = Range(given[k], given[n_x + 1 + k])
            if i in trending:
                slope = given[2 * (n_x + 1) + k]
                trends[i] = Trend(slope, fmax(ranges[i].spread - fabs(slope), 0))
        else:
            of_args = [ranges[a] for a in node.args]
            ranges[i] = operation(node.op, of_args)
            if i in trending:
                trends[i] = trend_of(node.op, of_args, [trends.get(a) for a in node.args], ranges[i])
            if i in small:
                ranges[i] = narrowed(ranges[i], trends[i])
        if i in rated:
            degree[i] = _degree(node, ranges[i], degree)
        if high[i] and i in judging:
            ranges[i] = judged(ranges[i], degree[i] <= order // 2, ranges[i].unseen)
    bounds = [ranges[i].unseen for i in wanted]
    sizes = _magnitudes(nodes, sorted(needed), ranges)
    return box, ca.vertcat(*(ca.SX(0) if e is None else e for e in bounds)), ca.vertcat(*(sizes[i] for i in wanted))


def _magnitudes(nodes: list[Node], needed: list[int], ranges: dict[int, Range]) -> dict[int, Scalar]:
    """Return of every node the scale of its rounding: its largest magnitude, and what cancelled in it.

    What cancelled in the arguments reaches a product, quotient or root by its slopes.
    """
    cancelled: dict[int, Scalar] = {}  # not there: nothing
    sizes: dict[int, Scalar] = {}
    for i in needed:
        op, a, largest = nodes[i].op, nodes[i].args, ranges[i].largest
        lost = [cancelled.get(k) for k in a]
        if not nodes[i].moves or op not in _PASSING or (op not in _SUMS and not any(e is not None for e in lost)):
            sizes[i] = largest
            continue
        passed = lambda k, slope: scalar(0) if lost[k] is None else lost[k] * slope  # noqa: B023, E731
        if op in _SUMS:
            cancelled[i] = sizes[a[0]] + sizes[a[1]] - largest
        elif op == ca.OP_MUL:
            cancelled[i] = passed(0, ranges[a[1]].largest) + passed(1, ranges[a[0]].largest)
        elif op == ca.OP_SQ:
            cancelled[i] = passed(0, 2 * ranges[a[0]].largest)
        elif op == ca.OP_DIV:
            below = ranges[a[1]].smallest
            cancelled[i] = (passed(0, 1) + passed(1, ranges[a[0]].largest / below)) / below
        elif op == ca.OP_INV:
            cancelled[i] = passed(0, 1 / ranges[a[0]].smallest ** 2)
        elif op == ca.OP_SQRT:
            root = ranges[i].smallest
            cancelled[i] = passed(0, if_else(root > 0, 0.5 / root, 0))
        elif op == ca.OP_IF_ELSE_ZERO:
            cancelled[i] = if_else(ranges[a[0]].middle, passed(1, 1), 0)
        else:
            cancelled[i] = passed(0, 2 if op == ca.OP_TWICE else 1)
        sizes[i] = largest + cancelled[i]
    return sizes


def unseen_by(field: ca.Function, order: int) -> ca.Function | None:
    """Return ``(box, p, m) -> bounds`` of unseen features for every row of a field, None if there can be none.

    Parameters
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``.
    order : int
        Order of the method.
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
            values[i] = applied(node.op, [values[j] for j in node.args])
    box, bounds, _ = unseen(nodes, wanted, field.nnz_in(0), order, values.__getitem__)
    return ca.Function("unseen", [box, given[2], given[3]], [ca.densify(bounds)], {"cse": True})


def _ancestors(nodes: list[Node], wanted: Iterable[int]) -> set[int]:
    ancestors, todo = set(), list(wanted)
    while todo:
        i = todo.pop()
        if i not in ancestors:
            ancestors.add(i)
            if nodes[i].moves:
                todo += nodes[i].args
    return ancestors
