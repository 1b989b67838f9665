"""Taylor recurrences over the instruction list of a CasADi SX function.

Every instruction becomes the list of its Taylor coefficients in time; coefficient k of the right-hand side gives
coefficient k + 1 of the state. What depends on parameters and mode alone is split off into a prelude, computed once
per mode.
"""

import casadi as ca

from symfric.codegen.instructions import BRANCHING, Node, read
from symfric.solve.loop.stepping.enclosure import hiding, unseen
from symfric.solve.loop.stepping.series import PROBED, Series
from symfric.solve.taylor.affine_forms import gathered
from symfric.solve.taylor.fixed import Fixed
from symfric.solve.taylor.recurrences import Jet, Value, at, coefficient, plus, scaled, times
from symfric.solve.taylor.table import LONG, OperationTable, length

# Most states of a system whose newest coefficients are computed outside the operations, see `_split_rates`, and most
# moving operations for which two orders, or one, are. In larger systems this costs more than it saves: by measurement
# the second order makes a cubic law 10 % faster and LuGre's 10 % slower.
_STATES, _TWO, _ONE = 4, 20, 100
_GATHERED = 6_000  # instructions of a field whose sums are gathered; in longer ones most are rows of numbers already


def is_branching(field: ca.Function) -> bool:
    """Whether a moving quantity enters a root, a non-integer power or an inverse function."""
    nodes, _ = read(field)
    return any(node.op in BRANCHING for node in nodes if node.moves)


def is_long(field: ca.Function, order: int) -> bool:
    """Whether the series of a field is a table of its operations; see `symfric.solve.taylor.table`."""
    return length(read(field)[0], order) > LONG


def expand(field: ca.Function, order: int, suffix: str = "") -> Series:
    """Return the Taylor series of ``y' = rate`` and of every guard and observable along it.

    Parameters
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``.
    order : int
        Highest order of the coefficients.
    suffix : str
        Suffix of the names of the functions.

    Raises
    ------
    SceneError
        If an operation has no recurrence; named.
    """
    nodes, outputs = read(gathered(field) if field.n_instructions() <= _GATHERED else field)
    n_x, p, m = field.nnz_in(0), ca.SX.sym("p", field.nnz_in(2)), ca.SX.sym("m", field.nnz_in(3))
    fixed, state = Fixed(nodes, p, m), ca.SX.sym("y", n_x + 1)
    rows = [] if length(nodes, order) > LONG else _written_out(nodes, outputs, fixed, state, order)
    targets = [*outputs[0], *outputs[1], *outputs[2]]
    hidden = hiding(nodes, order)
    exposed = tuple(r for r, node in enumerate(targets) if hidden[node])
    bounds = terms = None
    if exposed:
        box, *out = unseen(nodes, targets, n_x, order, fixed.value)
        bounds, terms = (
            ca.Function(name + suffix, [box, fixed.symbols()], [ca.densify(e)], {"cse": True})
            for name, e in zip(("unseen", "terms"), out, strict=True)
        )
    table = None if rows else OperationTable(nodes, outputs, fixed, n_x, order)
    series, probe = (
        table.function(name + suffix, last) if table else _flat(name + suffix, state, fixed, rows, last)
        for name, last in (("series", order), ("probe", PROBED))
    )
    return Series(
        prelude=ca.Function("prelude" + suffix, [p, m], [fixed.expressions()], {"cse": True}),
        series=series,
        probe=probe,
        order=order,
        unseen=bounds,
        terms=terms,
        exposed=exposed,
        room=table.room if table else 0,
    )


def _written_out(nodes: list[Node], outputs: list[list[int]], fixed: Fixed, state: ca.SX, order: int) -> list[Jet]:
    """Return the coefficients of states, guards and observables."""
    n_x = state.numel() - 1
    sweep = _Sweep(nodes, fixed)
    x: list[Jet] = [[state[i]] for i in range(n_x)]
    clock = [state[n_x], ca.SX(1)]
    slopes: list[list[Jet]] = []
    most = _taken_out(n_x, sum(node.moves for node in nodes))
    for k in range(order + 1):
        sweep.extend([at(row, k) for row in x], at(clock, k))
        if k == 0 and most:
            slopes = [[sweep.trial(1, [_unit(i, n_x)], [None], outputs[0]) for i in range(n_x)]]
        if 0 < k < most:
            slopes.append(_next_slopes(slopes[-1], k, state, [*(row[1] for row in x), clock[1]]))
        if k == 0 or not most:
            rates = [scaled(sweep.at(out, k), 1 / (k + 1)) for out in outputs[0]]
        else:
            newest = min(most, (k + 1) // 2)  # no product of two of them is of order k
            times_of = [at(clock, k - newest + 1 + j) for j in range(newest)]
            rest = sweep.trial(k, newest * [n_x * [None]], times_of, outputs[0])
            rates = _split_rates(rest, slopes[:newest], x, k)
        for row, rate in zip(x, rates, strict=True):
            row.append(rate)
    jets = sweep.jets
    return x + [jets[o] if nodes[o].moves else [fixed.value(o)] for o in (*outputs[1], *outputs[2])]


def _taken_out(n_x: int, moving: int) -> int:
    """Return how many of the newest coefficients are computed outside the operations."""
    return 0 if n_x > _STATES or moving > _ONE else 2 if moving <= _TWO else 1


class _Sweep:
    """The jets of all nodes, extended by one order at a time."""

    def __init__(self, nodes: list[Node], fixed: Fixed) -> None:
        self._nodes, self._fixed = nodes, fixed
        self._moving = [i for i, node in enumerate(nodes) if node.moves]
        self.jets: list[Jet] = [[] for _ in nodes]  # empty for nodes that do not move
        self._partners: list[Jet] = [[] for _ in nodes]

    def at(self, i: int, k: int) -> Value:
        """Return coefficient k of node i."""
        return at(self.jets[i] if self._nodes[i].moves else [self._fixed.value(i)], k)

    def extend(self, newest: Jet, clock: Value) -> None:
        """Append the next coefficient to every jet, from the newest ones of states and time."""
        for i in self._moving:
            node, jet = self._nodes[i], self.jets[i]
            if node.place is not None:
                jet.append(newest[node.place[1]] if node.place[0] == 0 else clock)
                continue
            args = [self.jets[a] if self._nodes[a].moves else [self._fixed.value(a)] for a in node.args]
            jet.append(coefficient(node.op, len(jet), jet, args, self._partners[i], node.saturates, node.grows))

    def trial(self, k: int, newest: list[Jet], clock: Jet, targets: list[int]) -> Jet:
        """Return coefficients k of the nodes `targets` for other newest coefficients of states and time."""
        first = k - len(newest) + 1
        tried: dict[int, Jet] = {}
        partners: dict[int, Jet] = {}
        for i in self._moving:
            tried[i], partners[i] = list(self.jets[i][:first]), list(self._partners[i][:first])
        for order in range(first, k + 1):
            for i in self._moving:
                node, jet = self._nodes[i], tried[i]
                if node.place is not None:
                    j = order - first
                    jet.append(newest[j][node.place[1]] if node.place[0] == 0 else clock[j])
                    continue
                args = [tried[a] if self._nodes[a].moves else [self._fixed.value(a)] for a in node.args]
                jet.append(coefficient(node.op, order, jet, args, partners[i], node.saturates, node.grows))
        return [tried[o][k] if self._nodes[o].moves else None for o in targets]


def _unit(i: int, n: int) -> Jet:
    return [ca.SX(1) if j == i else None for j in range(n)]


def _next_slopes(slopes: list[Jet], k: int, state: ca.SX, rate: Jet) -> list[Jet]:
    """Return Taylor coefficient k of the slopes of the rates along the motion."""
    along = ca.vertcat(*(ca.SX(0) if r is None else r for r in rate))
    change = lambda e: None if e is None else ca.jtimes(e, state, along) / k  # noqa: E731
    changes = [[change(e) for e in column] for column in slopes]
    return [[None if e is None or e.is_zero() else e for e in column] for column in changes]


def _split_rates(rest: Jet, slopes: list[list[Jet]], x: list[Jet], k: int) -> Jet:
    """Return coefficients k + 1 of the states, as the part by older coefficients plus slopes times the newest.

    The rates are linear in the newest coefficients; `slopes` holds Taylor coefficients of their derivatives by the
    states. Taken out, the newest pass through one multiplication and addition from order to order instead of through
    every operation of the equations; that chain sets the time of a call.
    """
    rates = []
    for i, old in enumerate(rest):
        rate = scaled(old, 1 / (k + 1))
        for age in range(len(slopes) - 1, -1, -1):
            for j, row in enumerate(x):
                rate = plus(rate, times(scaled(slopes[age][j][i], 1 / (k + 1)), at(row, k - age)))
        rates.append(rate)
    return rates


def _flat(name: str, state: ca.SX, fixed: Fixed, rows: list[Jet], order: int) -> ca.Function:
    entries = [at(row, k) for row in rows for k in range(order + 1)]
    out = ca.vertcat(*(ca.SX(0) if e is None else e for e in entries))
    return ca.Function(name, [state, fixed.symbols()], [ca.densify(out)], {"cse": True})
