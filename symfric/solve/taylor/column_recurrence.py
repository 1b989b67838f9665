"""Taylor series of the derivatives of a motion: linear equations with the same slopes for every column.

Along a motion, the derivatives V in every direction obey ``V' = L V + c (G V) + b``, and those of observables are of
the same form; see `symfric.solve.taylor.slopes`. The series of the slopes, of one kind for all columns, and of the
columns of b are computed with those of the motion; one recurrence for a single column remains, whose products are those
of a slope with a derivative. It is written once and carried out for several columns side by side, in vectors: see
`symfric.codegen.columns`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from symfric.codegen.columns import Layout
from symfric.solve.taylor.recurrences import Jet, Value, at, plus, scaled, times

Rows = list[list[Jet]]  # jets of the entries of a matrix, row by row


@dataclass(frozen=True)
class SlopeJets:
    """Jets of the slopes of a motion.

    Attributes
    ----------
    linear : list of list of Jet
        L, (n_x + n_f, n_x), of the rates and of the observables that are followed.
    coefficients : list of list of Jet
        c, (n_x + n_f, n_a), fixed.
    of_atoms : list of list of Jet
        G, (n_a, n_x).
    rests : list of list of Jet
        b, (n_x + n_f, n_s).
    """

    linear: Rows
    coefficients: Rows
    of_atoms: Rows
    rests: Rows


class ColumnRecurrence:
    """The recurrence of one column, and what it takes from the motion.

    Parameters
    ----------
    slopes : Slopes
    aux : SX
        Fixed values, which slopes may contain; complete.
    order : int
        Highest order of the coefficients.
    apart : bool
        Whether the newest coefficients are added last, which makes the way from one order to the next short.

    Attributes
    ----------
    shared : list of SX
        Values that all columns take.
    own : list of list of SX
        Values of every column.
    """

    def __init__(self, slopes: SlopeJets, aux: ca.SX, order: int, apart: bool) -> None:
        self._aux, self._order, self._apart = aux, order, apart
        self.n_s = len(slopes.rests[0])
        self.shared: list[ca.SX] = []
        self.own: list[list[ca.SX]] = [[] for _ in range(self.n_s)]
        n_x = len(slopes.linear[0])
        self._start = ca.SX.sym("V", n_x)
        self._symbols: list[ca.SX] = []
        self._own_symbols: list[ca.SX] = []
        self._newest = [[self._number(_slope(slopes, i, j)) for j in range(n_x)] for i in range(n_x if apart else 0)]
        self._linear, self._of_atoms = (
            [[self._taken(jet) for jet in row] for row in rows] for rows in (slopes.linear, slopes.of_atoms)
        )
        self._coefficients = slopes.coefficients
        self._rests = [self._taken_each(row) for row in slopes.rests]
        self._states = self._recurrence()
        atoms = [self._products(self._states, k, k) for k in range(order + 1)]
        self._rows = [
            [self._row(i, self._states, atoms[k], k, k) for k in range(order + 1)]
            for i in range(n_x, len(slopes.linear))
        ]

    def _taken(self, jet: Jet) -> Jet:
        """Return a jet of symbols for the values of a slope; a number, or a fixed value, is that."""
        if len(jet) == 1:
            return jet
        return [self._number(e) for e in jet]

    def _number(self, value: Value) -> Value:
        """Return a symbol for a value that all columns take; a number is itself."""
        if value is None or value.is_constant():
            return value
        self._symbols.append(ca.SX.sym(f"s_{len(self._symbols)}"))
        self.shared.append(value)
        return self._symbols[-1]

    def _taken_each(self, jets: Sequence[Jet]) -> Jet:
        """Return a jet of symbols for the values that each column has of its own; zero where one column has none."""
        taken: Jet = []
        for k in range(max(len(jet) for jet in jets)):
            values = [at(jet, k) for jet in jets]
            if all(e is None for e in values):
                taken.append(None)
                continue
            taken.append(ca.SX.sym(f"o_{len(self._own_symbols)}"))
            self._own_symbols.append(taken[-1])
            for own, e in zip(self.own, values, strict=True):
                own.append(ca.SX(0) if e is None else e)
        return taken

    def _recurrence(self) -> list[Jet]:
        V: list[Jet] = [[e] for e in ca.vertsplit(self._start)]
        for k in range(self._order):
            newest = k - 1 if self._apart else k
            atoms, rates = self._products(V, k, newest), []
            for i in range(len(V)):
                rate = scaled(self._row(i, V, atoms, k, newest), 1 / (k + 1))
                for slope, jet in zip(self._newest[i], V, strict=True) if self._apart else ():
                    rate = plus(times(scaled(slope, 1 / (k + 1)), jet[k]), rate)
                rates.append(ca.SX(0) if rate is None else rate)
            for jet, rate in zip(V, rates, strict=True):
                jet.append(rate)
        return V

    def _products(self, V: Sequence[Jet], k: int, newest: int) -> Jet:
        """Return coefficients k of ``G V``, without coefficients of the column above `newest`."""
        return [_sum(row, V, None, k, newest) for row in self._of_atoms]

    def _row(self, i: int, V: Sequence[Jet], atoms: Jet, k: int, newest: int) -> Value:
        """Return coefficient k of row i, given those of the products, without coefficients above `newest`."""
        total = at(self._rests[i], k)
        for c, atom in zip(self._coefficients[i], atoms, strict=True):
            total = plus(times(c[0], atom), total)
        return _sum(self._linear[i], V, total, k, newest)

    def column(self, name: str, last: int) -> ca.Function:
        """Return the function ``(V(0), shared, aux, own) -> (states, rows)``, coefficients up to order `last`."""
        states, rows = (
            [ca.SX(0) if at(jet, k) is None else jet[k] for jet in jets for k in range(last + 1)]
            for jets in (self._states, self._rows)
        )
        given = [self._start, _vector(self._symbols), self._aux, _vector(self._own_symbols)]
        return ca.Function(name, given, [ca.densify(_vector(states)), ca.densify(_vector(rows))], {"cse": True})

    def handed_over(self, layout: Layout) -> ca.SX:
        """Return what the motion hands over, as `layout` places it: shared values, then own ones, column by column."""
        columns = [min(s, self.n_s - 1) for s in range(layout.room_of_entry)]  # no lane is without a number
        own = [self.own[s][e] for e in range(len(self._own_symbols)) for s in columns]
        return ca.densify(_vector([*self.shared, *own]))


def _slope(slopes: SlopeJets, i: int, j: int) -> Value:
    """Return the slope of rate i by state j, of order zero."""
    total = at(slopes.linear[i][j], 0)
    for c, row in zip(slopes.coefficients[i], slopes.of_atoms, strict=True):
        total = plus(total, times(c[0], at(row[j], 0)))
    return total


def _sum(row: Sequence[Jet], V: Sequence[Jet], rest: Value, k: int, newest: int) -> Value:
    """Return `rest` and coefficient k of a row times a column, without coefficients of the column above `newest`."""
    total = rest
    for j in range(newest + 1):
        for slope, jet in zip(row, V, strict=True):
            total = plus(times(at(slope, k - j), jet[j]), total)
    return total


def _vector(entries: Sequence[ca.SX]) -> ca.SX:
    return ca.vertcat(*entries) if entries else ca.SX(0, 1)
