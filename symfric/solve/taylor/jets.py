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


@dataclass
class _Node:
    """One instruction in single-assignment form."""

    op: int
    args: tuple[int, ...]
    number: float | None = None
    moves: bool = False
    place: tuple[int, int] | None = None  # (argument, element) of an input


def expand(field: ca.Function, order: int) -> Series:
    """Return the Taylor series of ``y' = rate`` and of every guard and row along it.

    Parameters
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``.
    order : int
        Highest order of the coefficients.

    Raises
    ------
    SceneError
        If an operation has no recurrence; named.
    """
    nodes, outputs = _read(field)
    n_x = field.nnz_in(0)
    state, p, m = ca.SX.sym("y", n_x + 1), ca.SX.sym("p", field.nnz_in(2)), ca.SX.sym("m", field.nnz_in(3))
    fixed = _Fixed(nodes, p, m)
    jets: list[Jet | None] = [None] * len(nodes)
    partners: dict[int, Jet] = {}
    x: list[Jet] = [[state[i]] for i in range(n_x)]
    clock = [state[n_x], ca.SX(1)]
    needed = [i for i, node in enumerate(nodes) if node.moves]
    for k in range(order + 1):
        for i in needed:
            node = nodes[i]
            if node.place is not None:
                jets[i] = x[node.place[1]] if node.place[0] == 0 else clock
                continue
            if k == 0:
                jets[i] = []
            args = [jets[a] if nodes[a].moves else [fixed.value(a)] for a in node.args]
            jets[i].append(_coefficient(node.op, k, jets[i], args, partners.setdefault(i, []), fixed, node.args))
        for row, out in zip(x, outputs[0], strict=True):
            rate = _at(jets[out] if nodes[out].moves else [fixed.value(out)], k)
            row.append(_scaled(rate, 1 / (k + 1)))
    rows = x + [jets[o] if nodes[o].moves else [fixed.value(o)] for o in (*outputs[1], *outputs[2])]
    return Series(
        prelude=ca.Function("prelude", [p, m], [fixed.expressions()], {"cse": True}),
        series=_flat("series", state, fixed, rows, order),
        probe=_flat("probe", state, fixed, rows, min(order, 2)),
        order=order,
        entire=all(node.op in _ENTIRE or _divides_by_fixed(nodes, node) for node in nodes if node.moves),
    )


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


def _total(terms):
    """Sum pairwise: shorter dependency chains and smaller rounding than from left to right."""
    terms = [t for t in terms if t is not None]
    while len(terms) > 1:
        terms = [terms[i] + terms[i + 1] if i + 1 < len(terms) else terms[i] for i in range(0, len(terms), 2)]
    return terms[0] if terms else None


def _product(a: Jet, b: Jet, k: int, last: int = 0):
    """Sum of a[j] b[k-j] for j = 0 .. k - last.

    The terms with the newest coefficients are added last: the others are ready long before, and the recurrence from one
    order to the next, which sets the time of a call, becomes one multiplication and one addition.
    """
    rest = _total([_times(_at(a, j), _at(b, k - j)) for j in range(1, k)])
    if k == 0:
        return _times(_at(a, 0), _at(b, 0))
    if last == 0:
        rest = _plus(rest, _times(_at(a, k), _at(b, 0)))
    return _plus(rest, _times(_at(a, 0), _at(b, k)))


def _square(a: Jet, k: int, first: int = 0):
    """Coefficient k of a^2 (from index `first` on both sides), each pair once, the newest last."""
    pairs = _total([_times(_at(a, j), _at(a, k - j)) for j in range(1, (k + 1) // 2)])
    middle = _times(_at(a, k // 2), _at(a, k // 2)) if k % 2 == 0 and k // 2 >= first else None
    rest = _plus(_scaled(pairs, 2), middle)
    return _plus(rest, _times(_scaled(_at(a, 0), 2), _at(a, k))) if first == 0 and k > 0 else rest


def _scaled(a, factor: float):
    return None if a is None else a * factor


def _moment(a: Jet, b: Jet, k: int, last: int = 0):
    """1/k times the sum of j a[j] b[k-j], j = 1 .. k - last: coefficient k of the integral of a' b; the newest last."""
    rest = _total([_scaled(_times(_at(a, j), _at(b, k - j)), j / k) for j in range(2, k)])
    if k > 1:
        rest = _plus(rest, _scaled(_times(_at(a, 1), _at(b, k - 1)), 1 / k))
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
    terms = [_times(_times(_at(a, k - j), _at(out, j)), e * ((k - j) / k) - j / k) for j in range(k)]
    return _times(_total(terms), partner[0])


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
        rest = _total([_scaled(_times(_at(out, j), _at(partner, k - j)), j / k) for j in range(1, k)])
        return _times(_minus(_scaled(_at(a, k), outer), rest), 1 / partner[0])

    return rule


def _from_rational(sign: float):
    """atan (+) and atanh (-): out' (1 +- a^2) = a'; the partner is 1 +- a^2."""

    def rule(k, out, args, partner):
        a = args[0]
        partner.append(_scaled(_square(a, k), sign))
        rest = _total([_scaled(_times(_at(out, j), _at(partner, k - j)), j / k) for j in range(1, k)])
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
    rest = _total([_scaled(_times(_at(out, j), _at(partner, k - j)), j / k) for j in range(1, k)])
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
