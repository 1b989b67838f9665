"""The instruction list of a CasADi SX function as nodes in single-assignment form."""

from dataclasses import dataclass

import casadi as ca

# operations with a singularity at a finite argument, near which Taylor series converge in short steps only
BRANCHING = {
    ca.OP_SQRT,
    ca.OP_LOG,
    ca.OP_LOG1P,
    ca.OP_POW,
    ca.OP_CONSTPOW,
    ca.OP_ASIN,
    ca.OP_ACOS,
    ca.OP_ACOSH,
    ca.OP_ATANH,
}
# operations that cannot overflow, and cannot be flat at one time and steep within a step
ENTIRE = {
    ca.OP_INPUT,
    ca.OP_ADD,
    ca.OP_SUB,
    ca.OP_MUL,
    ca.OP_NEG,
    ca.OP_TWICE,
    ca.OP_SQ,
    ca.OP_IF_ELSE_ZERO,
    ca.OP_ASSIGN,
    ca.OP_SIN,
    ca.OP_COS,
    ca.OP_FLOOR,  # does not change along a step
}
# operations that overflow at moderate arguments
GROWING = {ca.OP_EXP, ca.OP_EXPM1, ca.OP_SINH, ca.OP_COSH}
_SATURATING = {ca.OP_EXP, ca.OP_INV, ca.OP_DIV}


@dataclass
class Node:
    """A node: one instruction in single-assignment form."""

    op: int
    args: tuple[int, ...]
    number: float | None = None
    moves: bool = False
    place: tuple[int, int] | None = None  # (argument, element) of an input
    grows: bool = False  # may overflow at moderate arguments of what moves
    saturates: bool = False  # has a limit where its argument, or its denominator, overflows
    sign: int = 0  # 1: never negative, -1: never positive, 0: not known


def _sign(op: int, signs: list[int]) -> int:
    """Return the sign of an operation from the signs of its arguments; zero if unknown."""
    if op in (ca.OP_SQ, ca.OP_EXP, ca.OP_COSH, ca.OP_SQRT, ca.OP_FABS):
        return 1
    if op in (ca.OP_MUL, ca.OP_DIV):
        return signs[0] * signs[1]
    if op == ca.OP_SUB:
        signs = [signs[0], -signs[1]]
    if op in (ca.OP_ADD, ca.OP_SUB):
        return signs[0] if signs[0] == signs[1] else 0
    if op == ca.OP_NEG:
        return -signs[0]
    return signs[0] if op in (ca.OP_TWICE, ca.OP_INV, ca.OP_ASSIGN, ca.OP_LIFT) else 0


def read(field: ca.Function) -> tuple[list[Node], list[list[int]]]:
    """Return the instructions in single-assignment form and the node of every output element."""
    nodes: list[Node] = []
    slot: dict[int, int] = {}
    outputs = [[-1] * field.nnz_out(i) for i in range(field.n_out())]
    for k in range(field.n_instructions()):
        op = field.instruction_id(k)
        into, args = field.instruction_output(k), field.instruction_input(k)
        if op == ca.OP_OUTPUT:
            outputs[into[0]][into[1]] = slot[args[0]]
            continue
        if op == ca.OP_INPUT:
            node = Node(op, (), moves=args[0] < 2, place=(args[0], args[1]))
        elif op == ca.OP_CONST:
            number = field.instruction_constant(k)
            node = Node(op, (), number=number, sign=(number > 0) - (number < 0))
        else:
            sources = tuple(slot[a] for a in args)
            moves = any(nodes[a].moves for a in sources)
            bounded = op in (ca.OP_EXP, ca.OP_EXPM1) and nodes[sources[0]].sign < 0
            grows = moves and ((op in GROWING and not bounded) or any(nodes[a].grows for a in sources))
            quotient = op == ca.OP_DIV and nodes[sources[0]].grows
            saturates = op in _SATURATING and nodes[sources[-1]].grows and not quotient
            node = Node(op, sources, None, moves, None, grows, saturates, _sign(op, [nodes[a].sign for a in sources]))
        nodes.append(node)
        slot[into[0]] = len(nodes) - 1
    return nodes, outputs
