"""Long sums of multiples, such as the rows of a matrix times the states, taken at once instead of term by term."""

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca

from symfric.codegen.instructions import Node

_LEAST = 5  # terms of a sum that is worth it


class Term(NamedTuple):
    """One term ``sign * factor * atom`` of a sum; `factor` is a node that does not move, None for 1."""

    sign: int
    factor: int | None
    atom: int


def long_sums(nodes: Sequence[Node], targets: set[int]) -> dict[int, list[Term]]:
    """Return the terms of every long sum of moving quantities by its node.

    Parts of a sum that are used elsewhere, or targets, are terms themselves.
    """
    uses = [0] * len(nodes)
    for node in nodes:
        for a in node.args:
            uses[a] += 1
    inner: set[int] = set()
    sums: dict[int, list[Term]] = {}
    for i in range(len(nodes) - 1, -1, -1):
        if nodes[i].op in (ca.OP_ADD, ca.OP_SUB) and nodes[i].moves and i not in inner:
            terms, inside = _terms(nodes, i, uses, targets)
            if len(terms) >= _LEAST:
                sums[i] = terms
                inner |= inside
    return sums


def _terms(nodes: Sequence[Node], i: int, uses: list[int], targets: set[int]) -> tuple[list[Term], set[int]]:
    """Return the terms of a sum, and the sums within it that are no terms of their own."""
    terms: list[Term] = []
    inside: set[int] = set()
    todo = [(i, 1)]
    while todo:
        k, sign = todo.pop()
        node = nodes[k]
        own = k == i or (uses[k] == 1 and k not in targets)
        if own and node.moves and node.op in (ca.OP_ADD, ca.OP_SUB):
            inside.add(k)
            todo += [(node.args[0], sign), (node.args[1], sign if node.op == ca.OP_ADD else -sign)]
        elif own and node.moves and node.op == ca.OP_NEG:
            inside.add(k)
            todo.append((node.args[0], -sign))
        elif own and node.moves and node.op == ca.OP_MUL and not all(nodes[a].moves for a in node.args):
            moving, fixed = node.args if nodes[node.args[0]].moves else node.args[::-1]
            terms.append(Term(sign, fixed, moving))
        else:
            terms.append(Term(sign, None, k))
    return terms, inside
