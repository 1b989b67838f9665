"""Gather sums and multiples: every linear part of a field becomes one sum with fixed coefficients.

A friction law scaled by load, direction and mass reaches the rate through a chain of sums and multiples, each of which
would cost an instruction at every order of the series. Here the rate becomes ``c_1 a_1 + c_2 a_2 + ...`` in which the
atoms a move (states and nonlinear operations) and the coefficients, computed once per mode, hold parameters and mode; a
choice by the mode is a choice of coefficients.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from symfric.codegen.instructions import ENTIRE, Node, read
from symfric.scalars import Scalar, applied, if_else, scalar

_ONE, _ZERO = scalar(1), scalar(0)
_MOST = 4  # most terms of a sum that is repeated where it is used; a longer one is computed once


@dataclass(frozen=True)
class _Form:
    """An affine form: fixed factor, coefficients by the index of their atom, and fixed part."""

    terms: dict[int, Scalar]
    rest: Scalar
    factor: Scalar

    def times(self, factor: Scalar) -> "_Form":
        return _Form(self.terms, self.rest, self.factor * factor)

    def spread(self) -> tuple[dict[int, Scalar], Scalar]:
        """Return coefficients and fixed part, multiplied by the factor."""
        return {a: c * self.factor for a, c in self.terms.items()}, self.rest * self.factor

    def plus(self, other: "_Form") -> "_Form":
        (terms, rest), (others, more) = self.spread(), other.spread()
        for a, c in others.items():
            terms[a] = terms[a] + c if a in terms else c
        return _Form({a: c for a, c in terms.items() if not c.is_zero()}, rest + more, _ONE)


def gathered(field: ca.Function) -> ca.Function:
    """Return an equivalent function ``(y, t, p, m) -> (rate, guards, rows)`` with gathered sums.

    What is written twice, as the rate of a bristle that its damping contains too, is computed once.
    """
    arguments = [ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in())]
    nodes, outputs = read(_once(field.name(), arguments, list(field(*arguments)), field))
    work = _Gathering(arguments)
    for node in nodes:
        work.add(node)
    out = [ca.vertcat(*(work.value(i) for i in row)) if row else ca.SX(0, 1) for row in outputs]
    return _once(field.name(), arguments, out, field)


def _once(name: str, arguments: list[ca.SX], out: Sequence[ca.SX], like: ca.Function) -> ca.Function:
    """Return a function that computes every expression once."""
    return ca.Function(name, arguments, ca.cse([ca.densify(e) for e in out]), like.name_in(), like.name_out())


def affine(field: ca.Function, arguments: list[ca.SX], rows: Sequence[int]) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return coefficients (n, n_a), atoms (n_a,) and fixed parts (n,) of entries of a field.

    Parameters
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``.
    arguments : list of SX
        Symbols y, t, p, m.
    rows : sequence of int
        Of ``[rate; guards; rows]``.
    """
    nodes, outputs = read(_once(field.name(), arguments, list(field(*arguments)), field))
    work = _Gathering(arguments)
    for node in nodes:
        work.add(node)
    entries = [i for group in outputs for i in group]
    return work.affine([entries[r] for r in rows])


class _Gathering:
    """The affine forms of the nodes read so far."""

    def __init__(self, arguments: list[ca.SX]) -> None:
        self._arguments = [[scalar(e) for e in ca.vertsplit(a)] if a.numel() else [] for a in arguments]
        self._forms: list[_Form] = []
        self._atoms: list[Scalar] = []
        self._entire: list[bool] = []
        self._whole_of: dict[int, int] = {}  # atoms that stand for whole nodes, by the identity of their terms
        self._made: dict[tuple[Any, ...], _Form] = {}  # products and quotients by their atoms

    def value(self, i: int) -> Scalar:
        """Return node i as an expression."""
        return self._sum(*self._forms[i].spread())

    def _sum(self, terms: dict[int, Scalar], rest: Scalar) -> Scalar:
        total = None
        for a, c in terms.items():
            term = self._atoms[a] if c.is_one() else c * self._atoms[a]
            total = term if total is None else total + term
        if total is None:
            return rest
        return total if rest.is_zero() else total + rest

    def affine(self, entries: Sequence[int]) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Return coefficients, atoms and fixed parts of some nodes."""
        forms = [self._forms[i].spread() for i in entries]
        used = sorted({a for terms, _ in forms for a in terms})
        coefficients = ca.SX(len(forms), len(used))
        for i, (terms, _) in enumerate(forms):
            for a, c in terms.items():
                coefficients[i, used.index(a)] = c
        atoms, rests = ([self._atoms[a] for a in used], [rest for _, rest in forms])
        column, fixed = (ca.vertcat(*e) if e else ca.SX(0, 1) for e in (atoms, rests))
        return coefficients, column, fixed

    def add(self, node: Node) -> None:
        """Append the form of the next node."""
        self._forms.append(self._form(node))

    def _form(self, node: Node) -> _Form:
        if node.number is not None:
            return _fixed(scalar(node.number))
        if node.place is not None:
            symbol = self._arguments[node.place[0]][node.place[1]]
            return self._new(symbol, entire=True) if node.moves else _fixed(symbol)
        parts = [self._forms[i] for i in node.args]
        if not node.moves:
            return _fixed(applied(node.op, [f.rest for f in parts]))  # fixed nodes have the factor 1
        if node.op in (ca.OP_ADD, ca.OP_SUB):
            left, right = (self._short(i) for i in node.args)
            return left.plus(right if node.op == ca.OP_ADD else right.times(scalar(-1)))
        if node.op in (ca.OP_NEG, ca.OP_TWICE):
            return self._short(node.args[0]).times(scalar(-1 if node.op == ca.OP_NEG else 2))
        if node.op in (ca.OP_ASSIGN, ca.OP_LIFT):
            return parts[0]
        if node.op == ca.OP_MUL and not all(f.terms for f in parts):
            k = 0 if parts[0].terms else 1
            return self._short(node.args[k]).times(parts[1 - k].spread()[1])
        if node.op == ca.OP_DIV and not parts[1].terms:
            return self._short(node.args[0]).times(1 / parts[1].spread()[1])
        if node.op == ca.OP_IF_ELSE_ZERO and not parts[0].terms and all(self._entire[a] for a in parts[1].terms):
            return self._chosen(parts[0].spread()[1], self._short(node.args[1]))
        return self._nonlinear(node)

    def _nonlinear(self, node: Node) -> _Form:
        """Return an operation on whole nodes; fixed factors of products and quotients are extracted."""
        if node.op in (ca.OP_MUL, ca.OP_SQ, ca.OP_DIV):
            factors, atoms = zip(*(self._factor(i) for i in node.args), strict=True)
            factor = factors[0] * factors[0] if node.op == ca.OP_SQ else applied(node.op, list(factors))
            key = ("/", *atoms) if node.op == ca.OP_DIV else ("*", *sorted((*atoms, *atoms)[:2]))
            if key not in self._made:
                entire = node.op != ca.OP_DIV and all(self._entire[a] for a in atoms)
                self._made[key] = self._new(applied(node.op, [self._atoms[a] for a in atoms]), entire)
            return self._made[key].times(factor)
        entire = node.op in ENTIRE and all(self._entire[a] for i in node.args for a in self._forms[i].terms)
        return self._new(applied(node.op, [self.value(i) for i in node.args]), entire)

    def _factor(self, i: int) -> tuple[Scalar, int]:
        """Return node i as a fixed factor times an atom."""
        form = self._forms[i]
        if len(form.terms) == 1 and form.rest.is_zero():
            ((a, c),) = form.terms.items()
            return c * form.factor, a
        return form.factor, self._whole(i)

    def _whole(self, i: int) -> int:
        """Return an atom for node i without its factor; nodes that are multiples of each other have the same."""
        form = self._forms[i]
        key = id(form.terms)  # which a form shares with its multiples, and which lives as long as they do
        if key not in self._whole_of:
            entire = all(self._entire[a] for a in form.terms)
            ((self._whole_of[key], _),) = self._new(self._sum(form.terms, form.rest), entire).terms.items()
        return self._whole_of[key]

    def _short(self, i: int) -> _Form:
        """Return the form of node i, as a single atom if it is long."""
        form = self._forms[i]
        return form if len(form.terms) <= _MOST else _Form({self._whole(i): _ONE}, _ZERO, form.factor)

    def _chosen(self, condition: Scalar, form: _Form) -> _Form:
        terms, rest = form.spread()
        return _Form({a: if_else(condition, c, 0) for a, c in terms.items()}, if_else(condition, rest, 0), _ONE)

    def _new(self, value: Scalar, entire: bool) -> _Form:
        self._atoms.append(value)
        self._entire.append(entire)
        return _Form({len(self._atoms) - 1: _ONE}, _ZERO, _ONE)


def _fixed(value: Scalar) -> _Form:
    return _Form({}, value, _ONE)
