"""Constants of a Taylor series: values that depend on parameters and mode alone."""

import casadi as ca

from symfric.codegen.instructions import Node
from symfric.scalars import applied


class Fixed:
    """Values that depend on parameters and mode alone, as numbers or as entries of the vector aux."""

    def __init__(self, nodes: list[Node], p: ca.SX, m: ca.SX) -> None:
        self._nodes, self._sources = nodes, {2: p, 3: m}
        self._expr: dict[int, ca.SX] = {}
        self._place: dict[int, int] = {}
        self._symbols: list[ca.SX] = []
        self._wanted: list[ca.SX] = []

    def _expression(self, i: int) -> ca.SX:
        waiting = [] if i in self._expr else [i]
        while waiting:  # not recursive, since the cells of a floor are a long chain of conditions
            node = self._nodes[waiting[-1]]
            missing = [a for a in node.args if a not in self._expr]
            if missing:
                waiting += missing
                continue
            self._expr[waiting.pop()] = self._made(node)
        return self._expr[i]

    def _made(self, node: Node) -> ca.SX:
        if node.number is not None:
            return ca.SX(node.number)
        if node.place is not None:
            return self._sources[node.place[0]][node.place[1]]
        return applied(node.op, [self._expr[a] for a in node.args])

    def value(self, i: int) -> ca.SX | None:
        """Return node i as a number or an entry of aux; None if it is exactly zero."""
        expression = self._expression(i)
        if expression.is_constant():
            return None if expression.is_zero() else expression
        return self._symbols[self.index(i)]

    def index(self, i: int) -> int:
        """Return the index of node i in aux, also for a number."""
        if i not in self._place:
            self._place[i] = len(self._wanted)
            self._symbols.append(ca.SX.sym(f"aux_{len(self._wanted)}"))
            self._wanted.append(self._expression(i))
        return self._place[i]

    @property
    def count(self) -> int:
        """Number of entries of aux so far."""
        return len(self._wanted)

    def symbols(self) -> ca.SX:
        """Return aux."""
        return ca.vertcat(*self._symbols) if self._symbols else ca.SX(0, 1)

    def expressions(self) -> ca.SX:
        """Return the entries of aux as functions of parameters and mode."""
        return ca.densify(ca.vertcat(*self._wanted)) if self._wanted else ca.SX(0, 1)
