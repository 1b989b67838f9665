"""Taylor recurrences over the instruction list of a CasADi SX function.

Every instruction becomes the list of its Taylor coefficients in time; coefficient k of the right-hand side gives
coefficient k + 1 of the state. What depends on parameters and mode alone is split off into a prelude, computed once
per mode. The recurrences are those of Moore and of Griewank and Walther, Evaluating Derivatives (2008), chapter 13.
"""

from dataclasses import dataclass

import casadi as ca

from symfric.errors import SceneError

Jet = list  # of SX or None (structural zero), by order


@dataclass(frozen=True)
class Series:
    """Functions that give Taylor coefficients.

    Attributes
    ----------
    prelude : casadi.Function
        ``(p, m) -> aux``: everything that depends on parameters and mode alone.
    series : casadi.Function
        ``([y; t], aux) -> coefficients``, row by row (states, guards, wanted rows), each of order 0 to `order`.
    probe : casadi.Function
        The same up to order 2.
    order : int
    entire : bool
        Whether only sums, products, sines and cosines of moving quantities occur. Such right-hand sides hide nothing
        from the last coefficients; an exponential or a quotient can be flat here and steep within the step.
    """

    prelude: ca.Function
    series: ca.Function
    probe: ca.Function
    order: int
    entire: bool


# most states of a system whose newest coefficients are taken out of the chain of operations, see `_split_rates`; the
# dense product with the slopes costs more than it saves in a larger one
_SPLIT = 4


@dataclass
class _Node:
    """One instruction in single-assignment form."""

    op: int
    args: tuple[int, ...]
    number: float | None = None
    moves: bool = False
    place: tuple[int, int] | None = None  # (argument, element) of an input


def expand(field: ca.Function, order: int, suffix: str = "") -> Series:
    """Return the Taylor series of ``y' = rate`` and of every guard and row along it.

    Parameters
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``.
    order : int
        Highest order of the coefficients.
    suffix : str
        Of the names of the functions.

    Raises
    ------
    SceneError
        If an operation has no recurrence; named.
    """
    nodes, outputs = _read(field)
    n_x = field.nnz_in(0)
    state, p, m = ca.SX.sym("y", n_x + 1), ca.SX.sym("p", field.nnz_in(2)), ca.SX.sym("m", field.nnz_in(3))
    fixed = _Fixed(nodes, p, m)
    sweep = _Sweep(nodes, fixed)
    x: list[Jet] = [[state[i]] for i in range(n_x)]
    clock = [state[n_x], ca.SX(1)]
    slopes: list[list] = []
    for k in range(order + 1):
        sweep.extend([_at(row, k) for row in x], _at(clock, k))
        if k == 0 and n_x <= _SPLIT:
            slopes = [
                sweep.trial(1, [ca.SX(1) if j == i else None for j in range(n_x)], None, outputs[0]) for i in range(n_x)
            ]
        if k == 0 or not slopes:
            rates = [_scaled(sweep.at(out, k), 1 / (k + 1)) for out in outputs[0]]
        else:
            rates = _split_rates(sweep.trial(k, [None] * n_x, _at(clock, k), outputs[0]), slopes, x, k)
        for row, rate in zip(x, rates, strict=True):
            row.append(rate)
    jets = sweep.jets
    rows = x + [jets[o] if nodes[o].moves else [fixed.value(o)] for o in (*outputs[1], *outputs[2])]
    return Series(
        prelude=ca.Function("prelude" + suffix, [p, m], [fixed.expressions()], {"cse": True}),
        series=_flat("series" + suffix, state, fixed, rows, order),
        probe=_flat("probe" + suffix, state, fixed, rows, min(order, 2)),
        order=order,
        entire=all(node.op in _ENTIRE or _divides_by_fixed(nodes, node) for node in nodes if node.moves),
    )


def reach(n_x: int, n_g: int, order: int) -> ca.Function:
    """Return ``(h, coefficients) -> (gain, size)``: what h adds to the states, and by how much guards can change.

    Both are sums of the terms 1 to `order`, of their magnitudes for the guards; rows as in `Series`.
    """
    h = ca.SX.sym("h")
    c = ca.SX.sym("c", (n_x + n_g) * (order + 1))
    square = h * h
    out = []
    for r in range(n_x + n_g):
        row = ca.vertsplit(c[r * (order + 1) : (r + 1) * (order + 1)])
        row = row if r < n_x else [ca.fabs(e) for e in row]
        odd, even = row[order - 1 + order % 2], row[order - order % 2]
        for k in range(order - 3 + order % 2, 0, -2):
            odd = odd * square + row[k]
        for k in range(order - 2 - order % 2, 1, -2):
            even = even * square + row[k]
        out.append(h * (odd + h * even))
    return ca.Function("reach", [h, c], [ca.vertcat(*out)])


_ENTIRE = {
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
}


def _divides_by_fixed(nodes: list, node) -> bool:
    return node.op == ca.OP_DIV and not nodes[node.args[1]].moves


class _Sweep:
    """The jets of all nodes, extended by one order at a time."""

    def __init__(self, nodes: list[_Node], fixed: "_Fixed"):
        self._nodes, self._fixed = nodes, fixed
        self._moving = [i for i, node in enumerate(nodes) if node.moves]
        self.jets: list[Jet | None] = [[] if node.moves else None for node in nodes]
        self._partners: list[Jet] = [[] for _ in nodes]

    def at(self, i: int, k: int):
        """Return coefficient k of node i."""
        return _at(self.jets[i] if self._nodes[i].moves else [self._fixed.value(i)], k)

    def extend(self, newest: list, clock) -> None:
        """Append to every jet the coefficient that follows from the newest ones of the states and of time."""
        for i in self._moving:
            node, jet = self._nodes[i], self.jets[i]
            if node.place is not None:
                jet.append(newest[node.place[1]] if node.place[0] == 0 else clock)
                continue
            args = [self.jets[a] if self._nodes[a].moves else [self._fixed.value(a)] for a in node.args]
            jet.append(_coefficient(node.op, len(jet), jet, args, self._partners[i], self._fixed, node.args))

    def trial(self, k: int, newest: list, clock, wanted: list[int]) -> list:
        """Return coefficients k of the nodes `wanted` if the newest ones of states and time were others."""
        tried: dict[int, object] = {}
        for i in self._moving:
            node = self._nodes[i]
            if node.place is not None:
                tried[i] = newest[node.place[1]] if node.place[0] == 0 else clock
                continue
            args = [
                [*self.jets[a][:k], tried[a]] if self._nodes[a].moves else [self._fixed.value(a)] for a in node.args
            ]
            partner = self._partners[i][:k]
            tried[i] = _coefficient(node.op, k, self.jets[i][:k], args, partner, self._fixed, node.args)
        return [tried[o] if self._nodes[o].moves else None for o in wanted]


def _split_rates(rest: list, slopes: list[list], x: list[Jet], k: int) -> list:
    """Return coefficients k + 1 of the states from what the older ones make of the rates, and slopes times the newest.

    The rates are linear in the newest coefficients. Taken out, these pass through one multiplication and addition from
    order to order instead of through every operation of the equations; that chain sets the time of a call.
    """
    rates = []
    for i, old in enumerate(rest):
        rate = _scaled(old, 1 / (k + 1))
        for j, row in enumerate(x):
            rate = _plus(rate, _times(_scaled(slopes[j][i], 1 / (k + 1)), row[k]))
        rates.append(rate)
    return rates


def _flat(name: str, state: ca.SX, fixed: "_Fixed", rows: list[Jet], order: int) -> ca.Function:
    entries = [_at(row, k) for row in rows for k in range(order + 1)]
    out = ca.vertcat(*(ca.SX(0) if e is None else e for e in entries))
    return ca.Function(name, [state, fixed.symbols()], [ca.densify(out)], {"cse": True})


def _read(field: ca.Function) -> tuple[list[_Node], list[list[int]]]:
    """Return the instructions in single-assignment form and the node of every output element."""
    nodes, slot = [], {}
    outputs = [[-1] * field.nnz_out(i) for i in range(field.n_out())]
    for k in range(field.n_instructions()):
        op = field.instruction_id(k)
        into, args = field.instruction_output(k), field.instruction_input(k)
        if op == ca.OP_OUTPUT:
            outputs[into[0]][into[1]] = slot[args[0]]
            continue
        if op == ca.OP_INPUT:
            node = _Node(op, (), moves=args[0] < 2, place=(args[0], args[1]))
        elif op == ca.OP_CONST:
            node = _Node(op, (), number=field.instruction_constant(k))
        else:
            sources = tuple(slot[a] for a in args)
            node = _Node(op, sources, moves=any(nodes[a].moves for a in sources))
        nodes.append(node)
        slot[into[0]] = len(nodes) - 1
    return nodes, outputs


class _Fixed:
    """Values that depend on parameters and mode alone: numbers stay, the rest becomes entries of the vector aux."""

    def __init__(self, nodes: list[_Node], p: ca.SX, m: ca.SX):
        self._nodes, self._sources = nodes, {2: p, 3: m}
        self._expr: dict[int, ca.SX] = {}
        self._symbol: dict = {}
        self._wanted: list[ca.SX] = []

    def _expression(self, i: int) -> ca.SX:
        if i not in self._expr:
            node = self._nodes[i]
            if node.number is not None:
                self._expr[i] = ca.SX(node.number)
            elif node.place is not None:
                self._expr[i] = self._sources[node.place[0]][node.place[1]]
            else:
                args = [self._expression(a) for a in node.args]
                self._expr[i] = ca.SX.unary(node.op, *args) if len(args) == 1 else ca.SX.binary(node.op, *args)
        return self._expr[i]

    def value(self, i: int) -> ca.SX | None:
        """Return node i as a number or an entry of aux; None if it is exactly zero."""
        return self._entry(i, self._expression(i))

    def reciprocal(self, i: int) -> ca.SX:
        """Return 1 / node i, computed in the prelude."""
        return self._entry(("reciprocal", i), 1 / self._expression(i))

    def _entry(self, key, expression: ca.SX) -> ca.SX | None:
        if expression.is_constant():
            return None if expression.is_zero() else expression
        if key not in self._symbol:
            self._symbol[key] = ca.SX.sym(f"aux_{len(self._wanted)}")
            self._wanted.append(expression)
        return self._symbol[key]

    def symbols(self) -> ca.SX:
        return ca.vertcat(*self._symbol.values()) if self._symbol else ca.SX(0, 1)

    def expressions(self) -> ca.SX:
        return ca.densify(ca.vertcat(*self._wanted)) if self._wanted else ca.SX(0, 1)


def _at(jet: Jet, k: int):
    return jet[k] if k < len(jet) else None


def _times(a, b):
    return None if a is None or b is None else a * b


def _plus(a, b):
    if a is None:
        return b
    return a if b is None else a + b


def _minus(a, b):
    if b is None:
        return a
    return -b if a is None else a - b


def _newest_last(k: int) -> list[int]:
    """Return 1 .. k - 1 in the order in which the later one of coefficients j and k - j becomes known."""
    return sorted(range(1, k), key=lambda j: max(j, k - j))


def _convolution(a: Jet, b: Jet, k: int):
    """Sum of a[j] b[k-j] for j = 1 .. k - 1, the newest coefficients last, so that the sum waits for nothing before."""
    total = None
    for j in _newest_last(k):
        total = _plus(total, _times(_at(a, j), _at(b, k - j)))
    return total


def _derivative(a: Jet) -> Jet:
    """Return j a[j] for every j."""
    return [_scaled(e, j) for j, e in enumerate(a)]


def _product(a: Jet, b: Jet, k: int, last: int = 0):
    """Sum of a[j] b[k-j] for j = 0 .. k - last.

    The terms with the newest coefficients are added last: the others are ready long before, and the recurrence from one
    order to the next, which sets the time of a call, becomes one multiplication and one addition.
    """
    if k == 0:
        return _times(_at(a, 0), _at(b, 0))
    rest = _convolution(a, b, k)
    if last == 0:
        rest = _plus(rest, _times(_at(a, k), _at(b, 0)))
    return _plus(rest, _times(_at(a, 0), _at(b, k)))


def _square(a: Jet, k: int, first: int = 0):
    """Coefficient k of a^2 (from index `first` on both sides), each pair once, the newest last."""
    pairs = None
    for j in range((k - 1) // 2, 0, -1):
        pairs = _plus(pairs, _times(_at(a, j), _at(a, k - j)))
    middle = _times(_at(a, k // 2), _at(a, k // 2)) if k % 2 == 0 and k // 2 >= first else None
    rest = _plus(_scaled(pairs, 2), middle)
    return _plus(rest, _times(_scaled(_at(a, 0), 2), _at(a, k))) if first == 0 and k > 0 else rest


def _scaled(a, factor: float):
    return None if a is None else a * factor


def _moment(a: Jet, b: Jet, k: int, last: int = 0):
    """1/k times the sum of j a[j] b[k-j], j = 1 .. k - last: coefficient k of the integral of a' b; the newest last."""
    rest = _scaled(_convolution(_derivative(a[: k + 1]), b, k), 1 / k)
    return rest if last else _plus(rest, _times(_at(a, k), _at(b, 0)))


def _coefficient(op: int, k: int, out: Jet, args: list[Jet], partner: Jet, fixed: _Fixed, sources):
    """Return coefficient k of one operation, given its coefficients below k and those of its arguments up to k."""
    a = args[0]
    if op == ca.OP_ADD:
        return _plus(_at(a, k), _at(args[1], k))
    if op == ca.OP_SUB:
        return _minus(_at(a, k), _at(args[1], k))
    if op == ca.OP_MUL:
        return _product(a, args[1], k)
    if op == ca.OP_NEG:
        return _minus(None, _at(a, k))
    if op == ca.OP_TWICE:
        return _scaled(_at(a, k), 2)
    if op == ca.OP_SQ:
        return _square(a, k)
    if op == ca.OP_DIV and not fixed._nodes[sources[1]].moves:
        return _times(_at(a, k), fixed.reciprocal(sources[1]))
    if op == ca.OP_IF_ELSE_ZERO:
        if fixed._nodes[sources[0]].moves:
            raise SceneError("a condition depends on the state outside a switch; write it as a Piecewise")
        chosen = _at(args[1], k)
        return None if chosen is None or a[0] is None else ca.if_else(a[0], chosen, 0)
    if op in (ca.OP_ASSIGN, ca.OP_LIFT):
        return _at(a, k)
    if k == 0:
        return _first(op, args, partner)
    rule = _RULES.get(op)
    if rule is None:
        raise SceneError(f"the operation {_name(op)} has no Taylor recurrence; use route='integrators'")
    return rule(k, out, args, partner)


def _first(op: int, args: list[Jet], partner: Jet):
    values = [ca.SX(0) if j[0] is None else j[0] for j in args]
    out = ca.SX.unary(op, *values) if len(values) == 1 else ca.SX.binary(op, *values)
    if op in _PARTNERS:
        partner.append(_PARTNERS[op](values, out))
    return out


def _name(op: int) -> str:
    names = [n for n in dir(ca) if n.startswith("OP_") and getattr(ca, n) == op]
    return names[0] if names else f"number {op}"


def _divide(k, out, args, partner):
    a, b = args
    return _times(_minus(_at(a, k), _product(out, b, k, last=1)), partner[0])


def _invert(k, out, args, partner):
    return _times(_minus(None, _product(out, args[0], k, last=1)), partner[0])


def _sqrt(k, out, args, partner):
    return _times(_minus(_at(args[0], k), _square(out, k, first=1)), partner[0])


def _exp(k, out, args, partner):
    return _moment(args[0], out, k)


def _expm1(k, out, args, partner):
    return _plus(_moment(args[0], out, k), _at(args[0], k))


def _log(k, out, args, partner):
    return _times(_minus(_at(args[0], k), _moment(out, args[0], k, last=1)), partner[0])


def _pow(k, out, args, partner):
    """``out a' e = a out'`` for a constant exponent e."""
    a, e = args[0], args[1][0]
    total = None
    for j in (*_newest_last(k), 0):
        total = _plus(total, _times(_times(_at(a, k - j), _at(out, j)), e * ((k - j) / k) - j / k))
    return _times(total, partner[0])


def _with_cofactor(sign: float):
    """Pairs such as (sin, cos): out' = outer * partner * a', partner' = inner * out * a'."""
    outer, inner = sign

    def rule(k, out, args, partner):
        new = _scaled(_moment(args[0], partner, k), outer)
        other = _scaled(_moment(args[0], out, k), inner)
        partner.append(other)
        return new

    return rule


def _from_square(sign: float):
    """tan (+) and tanh (-): out' = (1 +- out^2) a'; the partner is 1 +- out^2."""

    def rule(k, out, args, partner):
        new = _moment(args[0], partner, k)
        partner.append(_scaled(_square([*out, new], k), sign))
        return new

    return rule


def _from_root(root_of, outer: float):
    """asin, acos, asinh, acosh: out' root = outer a', root^2 = root_of(a); the partner is the root."""

    def rule(k, out, args, partner):
        a = args[0]
        root = _scaled(_square(a, k), root_of)
        partner.append(_times(_minus(root, _square([*partner, None], k, first=1)), 0.5 / partner[0]))
        rest = _moment(out, partner, k, last=1)
        return _times(_minus(_scaled(_at(a, k), outer), rest), 1 / partner[0])

    return rule


def _from_rational(sign: float):
    """atan (+) and atanh (-): out' (1 +- a^2) = a'; the partner is 1 +- a^2."""

    def rule(k, out, args, partner):
        a = args[0]
        partner.append(_scaled(_square(a, k), sign))
        rest = _moment(out, partner, k, last=1)
        return _times(_minus(_at(a, k), rest), 1 / partner[0])

    return rule


def _erf(k, out, args, partner):
    """out' = 2/sqrt(pi) exp(-a^2) a'; the partner is that exponential's jet."""
    a = args[0]
    square = [_scaled(_square(a, j), -1.0) for j in range(k)]
    if k > 1:
        partner.append(_moment(square, partner, k - 1))
    return _moment(a, partner, k)


def _atan2(k, out, args, partner):
    """out' (x^2 + y^2) = x y' - y x'; the partner is x^2 + y^2."""
    y, x = args
    partner.append(_plus(_square(x, k), _square(y, k)))
    turn = _minus(_moment(y, x, k), _moment(x, y, k))
    rest = _moment(out, partner, k, last=1)
    return _times(_minus(turn, rest), 1 / partner[0])


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
    ca.OP_SIN: _with_cofactor((1.0, -1.0)),
    ca.OP_COS: _with_cofactor((-1.0, 1.0)),
    ca.OP_SINH: _with_cofactor((1.0, 1.0)),
    ca.OP_COSH: _with_cofactor((1.0, 1.0)),
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
