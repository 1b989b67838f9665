"""Taylor recurrences over the instruction list of a CasADi SX function.

Every instruction becomes the list of its Taylor coefficients in time; coefficient k of the right-hand side gives
coefficient k + 1 of the state. What depends on parameters and mode alone is split off into a prelude, computed once
per mode.
"""

from collections.abc import Iterable

import casadi as ca

from symfric.codegen.columns import Layout, WithColumns
from symfric.codegen.instructions import BRANCHING, Node, read
from symfric.lower.automaton import VariedField
from symfric.solve.loop.stepping.enclosure import hiding, unseen
from symfric.solve.loop.stepping.series import PROBED, Series
from symfric.solve.taylor.affine_forms import gathered
from symfric.solve.taylor.column_recurrence import ColumnRecurrence, SlopeJets
from symfric.solve.taylor.fixed import Fixed
from symfric.solve.taylor.recurrences import Jet, Value, at, coefficient, plus, scaled, times
from symfric.solve.taylor.slopes import slopes_of
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


def is_long(field: ca.Function, order: int, varied: VariedField | None = None) -> bool:
    """Return whether the series of a field, which may be made from another, is a table of its operations.

    See `symfric.solve.taylor.table`.
    """
    if length(read(field)[0], order) <= LONG:
        return False
    if varied is None or field.n_instructions() > _GATHERED:
        return True
    nodes, outputs = read(gathered(_beside(field, slopes_of(varied, field.nnz_in(0)))))
    return length(nodes, order, _moving(nodes, [i for group in _of_motion(outputs, varied) for i in group])) > LONG


def expand(field: ca.Function, order: int, suffix: str = "", varied: VariedField | None = None) -> Series:
    """Return the Taylor series of ``y' = rate`` and of every guard and observable along it.

    Parameters
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``.
    order : int
        Highest order of the coefficients.
    suffix : str
        Suffix of the names of the functions.
    varied : VariedField, optional
        From which the field was made; the series of derivatives are then made of those of its slopes.

    Raises
    ------
    SceneError
        If an operation has no recurrence; named.
    """
    derived = varied
    if varied is not None and is_long(field, order, varied):
        varied = None  # its table has the derivatives as states
    if varied is not None:
        field = _beside(field, slopes_of(varied, field.nnz_in(0)))
    nodes, outputs = read(gathered(field) if field.n_instructions() <= _GATHERED else field)
    n_x, p, m = field.nnz_in(0), ca.SX.sym("p", field.nnz_in(2)), ca.SX.sym("m", field.nnz_in(3))
    fixed, state = Fixed(nodes, p, m), ca.SX.sym("y", n_x + 1)
    written = varied is not None or length(nodes, order) <= LONG
    motion = _Motion(nodes, outputs, fixed, state, order, varied) if written else None
    targets = [*outputs[0], *outputs[1], *outputs[2]]
    hidden = hiding(nodes, order)
    exposed = tuple(r for r, node in enumerate(targets) if hidden[node])
    bounds = terms = None
    if exposed:
        of_motion = [i for group in _of_motion(outputs, derived)[:3] for i in group] if derived else targets
        box, *out = unseen(nodes, targets, n_x, order, fixed.value, of_motion)
        bounds, terms = (
            ca.Function(name + suffix, [box, fixed.symbols()], [ca.densify(e)], {"cse": True})
            for name, e in zip(("unseen", "terms"), out, strict=True)
        )
    writer = motion or OperationTable(nodes, outputs, fixed, n_x, order)
    series, probe = writer.function("series" + suffix, order), writer.function("probe" + suffix, PROBED)
    return Series(
        prelude=ca.Function("prelude" + suffix, [p, m], [fixed.expressions()], {"cse": True}),
        series=series,
        probe=probe,
        order=order,
        unseen=bounds,
        terms=terms,
        exposed=exposed,
        room=writer.room if isinstance(writer, OperationTable) else 0,
    )


def _beside(field: ca.Function, slopes: ca.Function) -> ca.Function:
    """Return the function ``(y, t, p, m) -> (rate, guards, rows, L, c, G, b)``; see `slopes_of`."""
    given = [ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in())]
    out = [*field.call(given), *slopes.call(given)]
    return ca.Function(field.name(), given, out)


def _of_motion(outputs: list[list[int]], varied: VariedField) -> list[list[int]]:
    """Return the nodes of rates, guards and observables without those of derivatives, and of the slopes."""
    rows = len(outputs[2]) - varied.followed * len(varied.directions)
    return [outputs[0][: varied.field.nnz_in(0)], outputs[1], outputs[2][:rows], *outputs[3:]]


class _Motion:
    """The coefficients of states, guards and observables, written out.

    Parameters
    ----------
    nodes : list of Node
    outputs : list of list of int
        Nodes of rates, guards and observables; then, if the states hold derivatives, those of their slopes.
    fixed : Fixed
    state : SX
        Start of all states, and time.
    order : int
    varied : VariedField or None
    """

    def __init__(
        self,
        nodes: list[Node],
        outputs: list[list[int]],
        fixed: Fixed,
        state: ca.SX,
        order: int,
        varied: VariedField | None,
    ) -> None:
        self._nodes, self._fixed, self._state = nodes, fixed, state
        self._n_x, self._n_s, self._n_f = len(outputs[0]), 0, 0
        self._outputs = outputs
        if varied is not None:
            self._n_x, self._n_s, self._n_f = varied.field.nnz_in(0), len(varied.directions), varied.followed
            self._outputs = _of_motion(outputs, varied)
        self._x = self._coefficients(order)

    def _coefficients(self, order: int) -> list[Jet]:
        """Return the coefficients of the states, and compute those of all outputs."""
        n_x, outputs, rates_of = self._n_x, self._outputs, self._outputs[0]
        self._sweep = sweep = _Sweep(self._nodes, self._fixed, [i for group in outputs for i in group])
        own = ca.vertcat(self._state[:n_x], self._state[-1])
        x: list[Jet] = [[own[i]] for i in range(n_x)]
        clock = [own[n_x], ca.SX(1)]
        slopes: list[list[Jet]] = []
        most = _taken_out(n_x, len(_moving(self._nodes, [i for group in outputs[:3] for i in group])))
        of_rates = _moving(self._nodes, rates_of)
        for k in range(order + 1):
            sweep.extend([at(row, k) for row in x], at(clock, k))
            if k == 0 and most:
                slopes = [[sweep.trial(1, [_unit(i, n_x)], [None], rates_of, of_rates) for i in range(n_x)]]
            if 0 < k < most:
                slopes.append(_next_slopes(slopes[-1], k, own, [*(row[1] for row in x), clock[1]]))
            if k == 0 or not most:
                rates = [scaled(sweep.at(out, k), 1 / (k + 1)) for out in rates_of]
            else:
                newest = min(most, (k + 1) // 2)  # no product of two of them is of order k
                times_of = [at(clock, k - newest + 1 + j) for j in range(newest)]
                rest = sweep.trial(k, newest * [n_x * [None]], times_of, rates_of, of_rates)
                rates = _split_rates(rest, slopes[:newest], x, k)
            for row, rate in zip(x, rates, strict=True):
                row.append(rate)
        return x

    def _jet(self, i: int) -> Jet:
        return self._sweep.jets[i] if self._nodes[i].moves else [self._fixed.value(i)]

    def _others(self) -> list[Jet]:
        """Return the coefficients of guards and observables."""
        return [self._jet(i) for i in (*self._outputs[1], *self._outputs[2])]

    def function(self, name: str, last: int) -> ca.Function | WithColumns:
        """Return the function ``([y; t], aux) -> coefficients`` up to order `last`, row by row."""
        states, others = _flat(self._x, last), _flat(self._others(), last)
        if not self._n_s:
            return self._function(name, [ca.vertcat(states, others)])
        n_x, n_s = self._n_x, self._n_s
        L, c, G, b = (
            [[self._jet(i)[: last + 1] for i in group[r : r + n]] for r in range(0, len(group), n)] if n else []
            for group, n in zip(self._outputs[3:], (n_x, len(self._outputs[5]) // n_x, n_x, n_s), strict=True)
        )
        columns = ColumnRecurrence(
            SlopeJets(L, c or [[] for _ in L], G, b), self._fixed.symbols(), last, apart=n_x <= _STATES
        )
        layout = Layout(n_x, n_s, len(self._outputs[1]) + len(self._outputs[2]))
        values = self._function(f"{name}_values", [states, others, columns.handed_over(layout)])
        return WithColumns(name, values, columns.column(f"{name}_column", last), layout)

    def _function(self, name: str, out: list[ca.SX]) -> ca.Function:
        return ca.Function(name, [self._state, self._fixed.symbols()], [ca.densify(e) for e in out], {"cse": True})


def _moving(nodes: list[Node], targets: Iterable[int]) -> list[int]:
    """Return the moving nodes that some nodes follow from, in order, with these."""
    needed = set(targets)
    for i in range(len(nodes) - 1, -1, -1):
        if i in needed:
            needed.update(nodes[i].args)
    return [i for i in sorted(needed) if nodes[i].moves]


def _taken_out(n_x: int, moving: int) -> int:
    """Return how many of the newest coefficients are computed outside the operations."""
    return 0 if n_x > _STATES or moving > _ONE else 2 if moving <= _TWO else 1


class _Sweep:
    """The jets of the nodes that some follow from, extended by one order at a time."""

    def __init__(self, nodes: list[Node], fixed: Fixed, targets: list[int]) -> None:
        self._nodes, self._fixed = nodes, fixed
        self._moving = _moving(nodes, targets)
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

    def trial(self, k: int, newest: list[Jet], clock: Jet, targets: list[int], moving: list[int]) -> Jet:
        """Return coefficients k of the nodes `targets` for other newest coefficients of states and time.

        They follow from the nodes `moving`.
        """
        first = k - len(newest) + 1
        tried: dict[int, Jet] = {}
        partners: dict[int, Jet] = {}
        for i in moving:
            tried[i], partners[i] = list(self.jets[i][:first]), list(self._partners[i][:first])
        for order in range(first, k + 1):
            for i in moving:
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


def _flat(rows: list[Jet], last: int) -> ca.SX:
    entries = [at(row, k) for row in rows for k in range(last + 1)]
    return ca.vertcat(*(ca.SX(0) if e is None else e for e in entries))
