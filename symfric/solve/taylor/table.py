"""Long Taylor series as a table of operations, carried out by loops over operations of one kind.

Written out, the recurrences of n operations up to order k are some n k^2 instructions, which take a minute to compile
for a sum of some hundred sines. Here the recurrence of every kind of operation is written out once for each order, in a
loop over a part of the table: compiled in a second, whatever n, and run about as fast.

The coefficients of every operation lie in ``aux`` behind the fixed values, those of states and time first: ``order +
1`` for each, and as many again for the companion that some operations carry along.
"""

import hashlib
import math
from collections import deque
from collections.abc import Iterable, Sequence
from functools import cache

import casadi as ca

from symfric.codegen.instructions import ENTIRE, Node
from symfric.codegen.llvm_ir import Shared, Written, body
from symfric.codegen.loop_loader import sources_key
from symfric.solve.taylor.fixed import Fixed
from symfric.solve.taylor.long_sums import long_sums
from symfric.solve.taylor.recurrences import Jet, Value, at, coefficient, scaled, times

LONG = 30_000  # number of instructions of a written-out series beyond which it becomes a table
_LINEAR = {ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE, ca.OP_IF_ELSE_ZERO, ca.OP_ASSIGN, ca.OP_LIFT}
_PRODUCT = {ca.OP_MUL, ca.OP_SQ}
_STATE, _TIME, _SHORT = -1, -2, -3  # operations besides CasADi's: integral of a rate, time, an observable of low degree
_ZERO, _PLUS, _MINUS, _PLUS_TIMES, _MINUS_TIMES = -4, -5, -6, -7, -8  # a sum begins; a term, or a multiple, is added
# operation, degrees of its arguments, whether it saturates, whether it grows
_Kind = tuple[int, tuple[int, ...], bool, bool]
_Step = tuple[int, int, int]  # indices of the result and of two arguments
_SUMMED: _Kind = (-9, (), False, False)  # a long sum
_RULE = "void (double*, double*, [3 x i32]*, i64, i64)*"
_ROUNDED = 6  # the rules of a kind are compiled up to a multiple of this order, so that most tolerances share them
_MOST = 10**6  # degree in time of what is no line in time


def _degrees(nodes: Sequence[Node], order: int) -> list[int]:
    """Return the degree in time of every node: 0 if it does not move, 1 if it is linear, else the order."""
    degrees: list[int] = []
    for node in nodes:
        given = tuple(degrees[a] for a in node.args)
        if node.place is not None:
            degrees.append((order, 1, 0, 0)[node.place[0]])
        elif not any(given):
            degrees.append(0)
        else:
            degrees.append(1 if _is_line(node.op, given) else order)
    return degrees


def _is_line(op: int, degrees: tuple[int, ...]) -> bool:
    """Whether arguments of these degrees make a linear function of time."""
    return max(degrees) == 1 and _is_linear(op, degrees)


def _is_linear(op: int, degrees: tuple[int, ...]) -> bool:
    return op in _LINEAR or (op in _PRODUCT and 0 in degrees)


def length(nodes: Sequence[Node], order: int, among: Iterable[int] | None = None) -> int:
    """Return the approximate number of instructions of a written-out series of the nodes, or of some of them."""
    degrees, total = _degrees(nodes, order), 0
    for node in nodes if among is None else (nodes[i] for i in among):
        given = tuple(degrees[a] for a in node.args)
        if not any(given) or _is_line(node.op, given):
            continue
        terms = (min(d for d in given if d) + 1) // 2  # average number of terms of a convolution
        total += order * (1 if _is_linear(node.op, given) else 2 * terms if node.op in _PRODUCT else 4 * terms)
    return total


class OperationTable:
    """The operations of a field as a table.

    Parameters
    ----------
    nodes : sequence of Node
    outputs : sequence of three lists of int
        Nodes of the rates, guards and observables.
    fixed : Fixed
        Receives the values of nodes that do not move, and is complete afterwards.
    n_x, order : int
        Number of states, and highest order of the coefficients.

    Attributes
    ----------
    room : int
        Length of what the coefficients need in aux.
    """

    def __init__(self, nodes: Sequence[Node], outputs: Sequence[list[int]], fixed: Fixed, n_x: int, order: int) -> None:
        self._stride = order + 1
        degrees = _degrees(nodes, order)
        targets = {i for group in outputs for i in group}
        sums = long_sums(nodes, targets)
        args_of = {i: tuple(t.atom for t in terms) for i, terms in sums.items()}
        computed = _needed(nodes, targets, args_of)
        used = {a for i in computed for a in args_of.get(i, nodes[i].args)} | targets
        used |= {t.factor for terms in sums.values() for t in terms if t.factor is not None}
        place = {i: fixed.index(i) for i in sorted(used) if not nodes[i].moves}
        begin = end = fixed.count

        def taken(stretches: int = 1) -> int:
            nonlocal end
            end += stretches * self._stride
            return end - stretches * self._stride

        self._given = [taken() for _ in range(n_x + 1)]  # indices of states and time
        place |= {i: self._given[_position(nodes[i], n_x)] for i in used if nodes[i].moves and nodes[i].place}
        place |= {i: taken(1 if nodes[i].op in _LINEAR | _PRODUCT else 2) for i in computed}

        self._kinds: dict[_Kind, int] = {}
        self._runs: list[tuple[int, list[_Step]]] = []  # index of a kind, and its operations
        for i, rate in enumerate(outputs[0]):
            self._append((_STATE, (degrees[rate],), False, False), [(self._given[i], place[rate], place[rate])])
        self._append((_TIME, (), False, False), [(self._given[n_x], 0, 0)])
        kind_of = {i: _SUMMED if i in sums else _kind_of(nodes[i], degrees) for i in computed}
        for kind, run in _in_runs(nodes, kind_of, args_of):
            if kind == _SUMMED:
                self._append((_ZERO, (), False, False), [(place[i], 0, 0) for i in run])
                entries: dict[_Kind, list[tuple[int, _Step]]] = {}
                for i in run:
                    for n, term in enumerate(sums[i]):
                        op = (_PLUS, _MINUS) if term.factor is None else (_PLUS_TIMES, _MINUS_TIMES)
                        factor = place[term.atom if term.factor is None else term.factor]
                        to: _Kind = (op[term.sign < 0], (degrees[term.atom],), False, False)
                        entries.setdefault(to, []).append((n, (place[i], place[term.atom], factor)))
                for to, steps in entries.items():  # terms of different sums in turn: none waits for the one before
                    self._append(to, [step for _, step in sorted(steps, key=lambda e: e[0])])
                continue
            self._append(kind, [(place[i], place[nodes[i].args[0]], place[nodes[i].args[-1]]) for i in run])
        short = {i: taken() for i in sorted({*outputs[1], *outputs[2]}) if degrees[i] < order}
        for i, target in short.items():
            self._append((_SHORT, (degrees[i],), False, False), [(target, place[i], place[i])])
        self._rows = self._given[:n_x] + [(place | short)[i] for i in (*outputs[1], *outputs[2])]
        self.room = end - begin

    def _append(self, kind: _Kind, steps: list[_Step]) -> None:
        op, degrees, saturates, grows = kind
        kind = op, tuple(_MOST if d == self._stride - 1 else d for d in degrees), saturates, grows
        self._runs.append((self._kinds.setdefault(kind, len(self._kinds)), steps))

    def function(self, name: str, last: int) -> Written:
        """Return the function ``([y; t], aux) -> coefficients`` of all rows up to order `last`, row by row."""
        most = _ROUNDED * math.ceil((self._stride - 1) / _ROUNDED)
        shared = [_rules_of(kind, most) for kind in self._kinds]
        start, end = _copying(0), _copying(last)
        text: list[str] = []
        runs: list[tuple[int, int, int]] = []  # index of a kind, first step, number of steps
        steps: list[_Step] = []
        for kind, run in self._runs:
            runs.append((kind, len(steps), len(run)))
            steps += run
        kinds = f"[{len(self._kinds)} x {_RULE}]"
        called = (f"{kinds} [{', '.join(f'{_RULE} @{rules.names[k]}' for rules in shared)}]" for k in range(last + 1))
        text.append(_constant(f"{name}_rules", kinds, called))
        text.append(_triples(f"{name}_runs", "i64", runs))
        text.append(_triples(f"{name}_steps", "i32", steps))
        text.append(_triples(f"{name}_given", "i32", [(e, i, i) for i, e in enumerate(self._given)]))
        text.append(_triples(f"{name}_rows", "i32", [(i * (last + 1), e, e) for i, e in enumerate(self._rows)]))
        counts = {"given": len(self._given), "rows": len(self._rows), "runs": len(runs), "steps": len(steps)}
        ends = {"start": start.names[0], "end": end.names[0], "stride": self._stride}
        text.append(_MAIN.format(name=name, rule=_RULE, kinds=kinds, orders=last + 1, **ends, **counts))
        used = [*(name for rules in shared for name in rules.names[: last + 1]), *start.names, *end.names]
        declared = tuple(f"declare {_RULE[: _RULE.index('(')]}@{name}{_RULE[_RULE.index('(') : -1]}" for name in used)
        return Written(name, "\n".join(text), declared, (*shared, start, end))


# (y, aux, c): copy the start to aux; for every order apply the rule of every run; copy the rows from aux to c
_MAIN = """define void @{name}(double* %y, double* %aux, double* %c) nounwind {{
entry:
  %given = getelementptr [{given} x [3 x i32]], [{given} x [3 x i32]]* @{name}_given, i64 0, i64 0
  call void @{start}(double* %y, double* %aux, [3 x i32]* %given, i64 {given}, i64 0)
  br label %order
order:
  %k = phi i64 [0, %entry], [%next_order, %ordered]
  br label %run
run:
  %i = phi i64 [0, %order], [%next_run, %run]
  %kind_at = getelementptr [{runs} x [3 x i64]], [{runs} x [3 x i64]]* @{name}_runs, i64 0, i64 %i, i64 0
  %first_at = getelementptr i64, i64* %kind_at, i64 1
  %count_at = getelementptr i64, i64* %kind_at, i64 2
  %kind = load i64, i64* %kind_at
  %first = load i64, i64* %first_at
  %count = load i64, i64* %count_at
  %rule_at = getelementptr [{orders} x {kinds}], [{orders} x {kinds}]* @{name}_rules, i64 0, i64 %k, i64 %kind
  %rule = load {rule}, {rule}* %rule_at
  %steps = getelementptr [{steps} x [3 x i32]], [{steps} x [3 x i32]]* @{name}_steps, i64 0, i64 %first
  call void %rule(double* %aux, double* %aux, [3 x i32]* %steps, i64 %count, i64 {stride})
  %next_run = add i64 %i, 1
  %more_runs = icmp ult i64 %next_run, {runs}
  br i1 %more_runs, label %run, label %ordered
ordered:
  %next_order = add i64 %k, 1
  %more_orders = icmp ult i64 %next_order, {orders}
  br i1 %more_orders, label %order, label %done
done:
  %rows = getelementptr [{rows} x [3 x i32]], [{rows} x [3 x i32]]* @{name}_rows, i64 0, i64 0
  call void @{end}(double* %aux, double* %c, [3 x i32]* %rows, i64 {rows}, i64 0)
  ret void
}}"""

# apply a function of (a, b, result, companion) to every step; arguments and results are in separate arrays
_LOOP = """define void @{name}(double* %from, double* %to, [3 x i32]* %steps, i64 %count, i64 %stride) nounwind {{
entry:
  br label %loop
loop:
  %n = phi i64 [0, %entry], [%next, %loop]
  %result_at = getelementptr [3 x i32], [3 x i32]* %steps, i64 %n, i64 0
  %first_at = getelementptr [3 x i32], [3 x i32]* %steps, i64 %n, i64 1
  %second_at = getelementptr [3 x i32], [3 x i32]* %steps, i64 %n, i64 2
  %result = load i32, i32* %result_at
  %first = load i32, i32* %first_at
  %second = load i32, i32* %second_at
  %i0 = getelementptr double, double* %from, i32 %first
  %i1 = getelementptr double, double* %from, i32 %second
  %i2 = getelementptr double, double* %to, i32 %result
  %i3 = getelementptr double, double* %i2, i64 %stride
  %o0 = getelementptr double, double* %i2, i64 {k}
  %o1 = getelementptr double, double* %i3, i64 {k}
{body}
  %next = add i64 %n, 1
  %more = icmp ult i64 %next, %count
  br i1 %more, label %loop, label %done
done:
  ret void
}}"""


@cache
def _rules_of(kind: _Kind, most: int) -> Shared:
    """Return the rules of a kind for the orders up to `most`."""
    label = hashlib.sha256(f"{_written_by()} {kind} {most}".encode()).hexdigest()[:24]
    names = tuple(f"symfric_{label}_{k}" for k in range(most + 1))
    return Shared(names, label, lambda: [_loop(name, _rule(name, kind, k), k) for k, name in enumerate(names)])


@cache
def _copying(last: int) -> Shared:
    """Return the function that copies coefficients up to order `last`."""
    label = hashlib.sha256(f"{_written_by()} copy {last}".encode()).hexdigest()[:24]
    name, a = f"symfric_{label}", ca.SX.sym("a", last + 1)
    return Shared((name,), label, lambda: [_loop(name, ca.Function("copy", [a, ca.SX.sym("b")], [a]))])


@cache
def _written_by() -> str:
    """Return a key of what writes the rules."""
    return f"{ca.CasadiMeta.version()} {sources_key(__name__)}"


def _loop(name: str, rule: ca.Function, k: int = 0) -> Written:
    """Return the function that applies a rule to a part of the table."""
    return Written(name, _LOOP.format(name=name, k=k, body="\n".join(body(rule))))


def _constant(name: str, kind: str, entries: Iterable[str]) -> str:
    entries = list(entries)
    return f"@{name} = internal constant [{len(entries)} x {kind}] [{', '.join(entries)}]"


def _triples(name: str, kind: str, entries: Iterable[tuple[int, int, int]]) -> str:
    triple = f"[3 x {kind}]"
    return _constant(name, triple, (f"{triple} [{', '.join(f'{kind} {e}' for e in entry)}]" for entry in entries))


def _position(node: Node, n_x: int) -> int:
    """Return the index of a state, or of time, which follows the states."""
    assert node.place is not None
    return node.place[1] if node.place[0] == 0 else n_x


def _kind_of(node: Node, degrees: list[int]) -> _Kind:
    return node.op, tuple(degrees[a] for a in node.args), node.saturates, node.grows


def _needed(nodes: Sequence[Node], targets: set[int], args_of: dict[int, tuple[int, ...]]) -> list[int]:
    """Return the operations on what moves that the targets follow from, if long sums are taken at once."""
    needed, todo = set(), list(targets)
    while todo:
        i = todo.pop()
        if i not in needed and nodes[i].moves and nodes[i].place is None:
            needed.add(i)
            todo += args_of.get(i, nodes[i].args)
    return sorted(needed)


def _in_runs(
    nodes: Sequence[Node], kind_of: dict[int, _Kind], args_of: dict[int, tuple[int, ...]]
) -> list[tuple[_Kind, list[int]]]:
    """Return the operations grouped into few runs of one kind, each after the operations on which it depends."""
    args = {i: args_of.get(i, nodes[i].args) for i in kind_of}
    waits = {i: sum(a in kind_of for a in args[i]) for i in kind_of}
    users: dict[int, list[int]] = {i: [] for i in kind_of}
    for i in kind_of:
        for a in args[i]:
            if a in kind_of:
                users[a].append(i)
    ready: dict[_Kind, deque[int]] = {kind: deque() for kind in kind_of.values()}
    for i, missing in waits.items():
        if missing == 0:
            ready[kind_of[i]].append(i)
    runs = []
    while any(ready.values()):
        kind = max(ready, key=lambda e: len(ready[e]))
        run: list[int] = []
        now = ready[kind]
        if kind == _SUMMED:  # they are carried out together: none may take the result of another
            ready[kind] = deque()
        while now:
            run.append(now.popleft())
            for user in users[run[-1]]:
                waits[user] -= 1
                if waits[user] == 0:
                    ready[kind_of[user]].append(user)
        runs.append((kind, run))
    return runs


def _rule(name: str, kind: _Kind, k: int) -> ca.Function:
    """Return ``(a, b, result, companion) -> coefficients k`` of result and companion, given all lower ones.

    A function of a constant is constant even where its slope is infinite, such as a power of ``Max(x, 0)``.
    """
    op, degrees, saturates, grows = kind
    given = [ca.SX.sym(f"a{n}", min(k, degree) + 1) for n, degree in enumerate(degrees)]
    out, partner = ca.SX.sym("out", k), ca.SX.sym("partner", k)
    jets: list[Jet] = [ca.vertsplit(e) for e in given]
    new_ones: list[Value] = []  # coefficient 0 is known from the start
    if op == _STATE and k:
        new_ones = [scaled(at(jets[0], k - 1), 1 / k)]
    elif op == _TIME and k:
        new_ones = [ca.SX(k == 1)]
    elif op == _SHORT:
        new_ones = [at(jets[0], k)]
    elif op == _ZERO:
        new_ones = [ca.SX(0)]
    elif op in (_PLUS, _MINUS, _PLUS_TIMES, _MINUS_TIMES):
        factor, out = ca.SX.sym("factor"), ca.SX.sym("out", k + 1)
        term = at(jets[0], k)
        if op in (_PLUS_TIMES, _MINUS_TIMES):
            term = times(factor, term)
        new = out[k] if term is None else out[k] + term if op in (_PLUS, _PLUS_TIMES) else out[k] - term
        return ca.Function(name, [given[0], factor, out, partner], [new])
    elif op >= 0 and not (k > 1 and _is_line(op, degrees)):
        carried: Jet = ca.vertsplit(partner) if k else []
        new = coefficient(op, k, ca.vertsplit(out) if k else [], jets, carried, saturates, grows)
        new_ones = [new, carried[k]] if len(carried) > k else [new]
    new_ones = [ca.SX(0) if e is None else ca.densify(ca.SX(e)) for e in new_ones]
    if k and op >= 0 and op not in ENTIRE:
        change = sum((ca.fabs(e) for jet in jets for e in jet[1:]), ca.SX(0))
        new_ones = [ca.if_else(change == 0, 0, e) for e in new_ones]
    unused = [ca.SX.sym(f"unused{n}") for n in range(2 - len(given))]
    return ca.Function(name, [*given, *unused, out, partner], new_ones)
