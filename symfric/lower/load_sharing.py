"""Load sharing of parallel contacts, in proportion to their static bounds."""

from collections.abc import Mapping, Sequence
from functools import cache, partial
from typing import TYPE_CHECKING
from zlib import crc32

import casadi as ca
import numpy as np
import sympy as sp

from symfric.lower.constraint_forces import DISTINCT, HOLDS, SHARES
from symfric.model.symbols import TIME

_LEAST = 1e-290  # added to squares of bounds that may vanish, so that the share of one alone is the whole
_SEEN = 1e-6  # relative difference of two ratios that is no rounding
_NEARLY = 1e-6  # relative remainder of a row, orthogonal to others, below which it counts as dependent

if TYPE_CHECKING:
    from symfric.lower.contact_dynamics import ContactDynamics


def parallels(model: "ContactDynamics") -> list[tuple[int, float | sp.Expr]]:
    """Return for each contact the first one of whose slip its own is a multiple, and the factor; not for smooth laws.

    The sign of a factor is known, whatever the parameters in it.
    """
    contacts = model.contacts
    ratio = partial(_ratio_of_rows, model) if model.system.rows else _Ratios(model).ratio
    roots = []
    for i, c in enumerate(contacts):
        before = [k for k in range(i) if not contacts[k].law.smooth]
        alike = ((k, r) for k in before if (r := ratio(i, k)) is not None)
        roots.append((i, 1.0) if c.law.smooth else next(alike, (i, 1.0)))
    return roots


def dependent(model: "ContactDynamics") -> list[bool]:
    """Return which contacts may have a slip that depends linearly on those of several others.

    With slopes that vary this is not known in advance, so all contacts that share velocities with them count.
    """
    groups = [k for k, _ in model.parallels]
    rigid = {k: c.slip for k, c in enumerate(model.contacts) if not c.law.smooth}
    slopes: dict[int, Sequence[sp.Expr] | np.ndarray] = {k: _slopes(model, slip) for k, slip in rigid.items()}
    sets = [({k}, {j for j, e in enumerate(slopes[k]) if e != 0}) for k in dict.fromkeys(groups) if k in slopes]
    joined: list[tuple[set[int], set[int]]] = []
    for group, velocities in sets:
        for other in [e for e in joined if e[1] & velocities]:
            joined.remove(other)
            group, velocities = group | other[0], velocities | other[1]
        joined.append((group, velocities))
    in_circuit = set().union(*(_in_a_circuit({k: slopes[k] for k in group}) for group, _ in joined))
    return [k in in_circuit for k in groups]


def _in_a_circuit(slopes: Mapping[int, Sequence[sp.Expr] | np.ndarray]) -> set[int]:
    """Return the rows that depend linearly on others, or nearly; all of them unless they are numbers."""
    if len(slopes) < 2:
        return set()
    if not all(isinstance(row, np.ndarray) or all(e.is_number for e in row) for row in slopes.values()):
        return set(slopes)
    rows = {k: np.array(row, dtype=float) for k, row in slopes.items()}
    rows_in_circuit = set()
    for k, row in rows.items():
        others = np.array([r / np.linalg.norm(r) for j, r in rows.items() if j != k]).T
        left = row - others @ np.linalg.lstsq(others, row, rcond=None)[0]
        if np.linalg.norm(left) <= _NEARLY * np.linalg.norm(row):
            rows_in_circuit.add(k)
    return rows_in_circuit


def _slopes(model: "ContactDynamics", slip: sp.Expr) -> Sequence[sp.Expr] | np.ndarray:
    row = model.system.slopes(slip)
    return row if isinstance(row, np.ndarray) else [e.xreplace(model.constants) for e in row]


def _ratio_of_rows(model: "ContactDynamics", i: int, k: int) -> float | None:
    """Return what slip i is over slip k, each a row of numbers and a speed; None unless that never changes."""
    system, slip, other = model.system, model.contacts[i].slip, model.contacts[k].slip
    row, rest = system.slopes(slip), system.slopes(other)
    if not (isinstance(row, np.ndarray) and isinstance(rest, np.ndarray)):
        return None
    k = int(np.argmax(np.abs(rest)))
    ratio = row[k] / rest[k]
    if ratio == 0.0 or np.any(np.abs(row - ratio * rest) > DISTINCT * np.abs(row)):
        return None
    still = dict.fromkeys((*system.u, *system.rows), sp.S.Zero)
    a, b = slip.xreplace(still), other.xreplace(still)
    if a == b == 0 or sp.expand(a - sp.nsimplify(ratio) * b) == 0:
        return float(ratio)
    if a.is_number and b.is_number and abs(float(a) - ratio * float(b)) <= DISTINCT * abs(float(a)):
        return float(ratio)
    return None


def _row(slip: sp.Expr, u: Sequence[sp.Symbol]) -> np.ndarray | None:
    """Return the slopes of a slip and its value at rest, if these are numbers."""
    row = [*(slip.diff(e) for e in u), slip.xreplace(dict.fromkeys(u, sp.Integer(0)))]
    return np.array(row, dtype=float) if all(e.is_number for e in row) else None


def _number(symbol: sp.Symbol, turn: int) -> sp.Float:
    """Return a number between 1/4 and 5/4 for a symbol, another one at each turn."""
    return sp.Float(0.25 + crc32(f"{symbol} {turn}".encode()) / 2**32)


def _apart(a: np.ndarray | None, b: np.ndarray | None) -> bool:
    """Whether values at two instants tell that one quantity is no constant multiple of another."""
    if a is None or b is None:
        return False
    crossed = a[0] * b[1], a[1] * b[0]
    return bool(abs(crossed[0] - crossed[1]) > _SEEN * max(map(abs, crossed)))


class _Ratios:
    """Ratios of slips written as expressions."""

    def __init__(self, model: "ContactDynamics") -> None:
        self._slips = [c.slip for c in model.contacts]
        self._rows = [_row(slip, model.system.u) for slip in self._slips]
        self._moving = {*model.system.states, TIME, *model.inputs}
        self._samples = cache(self._sampled)

    def ratio(self, i: int, k: int) -> float | sp.Expr | None:
        """Return what slip i is over slip k, None unless it is constant; numbers are compared to rounding.

        It may contain parameters if their assumptions determine its sign.
        """
        row, other = self._rows[i], self._rows[k]
        if row is None or other is None:
            return None if _apart(self._samples(i), self._samples(k)) else self._symbolic(i, k)
        largest = int(np.argmax(np.abs(other[:-1])))
        ratio = row[largest] / other[largest]
        alike = ratio != 0.0 and np.all(np.abs(row - ratio * other) <= DISTINCT * np.abs(row))
        return float(ratio) if alike else None

    def _symbolic(self, i: int, k: int) -> float | sp.Expr | None:
        ratio = sp.cancel(self._slips[i] / self._slips[k])
        if ratio.is_number:
            return float(ratio) if ratio.is_finite and ratio != 0 else None
        known = not ratio.free_symbols & self._moving and (ratio.is_positive or ratio.is_negative)
        return ratio if known else None

    def _sampled(self, i: int) -> np.ndarray | None:
        """Return slip i at two states and times that nothing distinguishes, None if it has no numbers there."""
        slip, moving = self._slips[i], self._moving
        at = [{s: _number(s, k * (s in moving)) for s in slip.free_symbols} for k in (0, 1)]
        try:
            return np.array([float(slip.xreplace(values)) for values in at])
        except TypeError:  # a function without numbers
            return None


def _sign(factor: float | sp.Expr) -> float:
    return 1.0 if factor > 0 else -1.0


def rooms_left(model: "ContactDynamics", friction: ca.SX) -> tuple[ca.SX, list[tuple[ca.SX, ca.SX]]]:
    """Share the friction forces of sticking contacts.

    Parameters
    ----------
    model : ContactDynamics
    friction : SX
        Friction of each contact, where the first sticking one of a parallel group carries the whole force.

    Returns
    -------
    friction : SX
    rooms : list of pairs of SX
        For each contact, the reserve to its bound before it slips backwards, and before it slips forwards.
    """
    groups, edges = model.parallels, model.edges
    same = [_sign(factor) for _, factor in groups]  # direction of a contact relative to its group

    def shared(way: int) -> tuple[list[ca.SX], ca.SX]:
        """Return bounds and friction of the groups for impending slip in the direction `way`."""
        loads = [edges.towards(i, ca.SX(way * s), model.load[i]) for i, s in enumerate(same)]
        bounds = [load * stick for load, stick in zip(loads, ca.vertsplit(model.static), strict=True)]
        return bounds, _in_proportion(model, friction, bounds, groups)

    back = shared(-1)
    forth = shared(1) if edges.switches else back
    rooms, least = [], ca.SX(back[1])
    for i, s in enumerate(same):
        (low_bounds, behind), (high_bounds, ahead) = (back, forth) if s > 0 else (forth, back)
        rooms.append((low_bounds[i] - behind[i], high_bounds[i] + ahead[i]))
        if edges.switches and [k for k, _ in groups].count(groups[i][0]) > 1:
            least[i] = ca.if_else(s * back[1][i] >= 0, back[1][i], forth[1][i])
    return least, rooms


def _in_proportion(
    model: "ContactDynamics", friction: ca.SX, bounds: list[ca.SX], groups: list[tuple[int, float | sp.Expr]]
) -> ca.SX:
    """Return the friction forces, those of parallel sticking contacts shared in proportion to their bounds.

    Contacts without load share nothing: the one with its own constraint keeps its force, which exceeds its
    bound of zero. Where loads depend on the state, those that vanish together share equally.
    """
    shared = ca.SX(friction)
    for first in {k for k, _ in groups}:
        group = [(i, factor) for i, (k, factor) in enumerate(groups) if k == first]
        if len(group) < 2:
            continue
        factors = {i: model.read(factor) for i, factor in group}
        sticks = {i: (model.s[i] == HOLDS) + (model.s[i] == SHARES) for i, _ in group}
        whole = sum(ca.if_else(sticks[i], factors[i] * friction[i], 0) for i, _ in group)
        reach = sum(ca.if_else(sticks[i], ca.fabs(factors[i]) * bounds[i], 0) for i, _ in group)
        if ca.depends_on(reach, ca.vertcat(model.y, model.t, model.pressed)):  # no condition: series have none on these
            # products of two bounds, the same above and below the fraction: a bound whose terms cancel may be rounding
            sizes = {j: sticks[j] * ca.fabs(factors[j]) for j, _ in group}
            parts = {i: sum(sizes[j] * (bounds[i] * bounds[j]) for j, _ in group) + _LEAST for i, _ in group}
            loaded, reach = ca.SX(1), ca.SX(sum(sizes[i] * parts[i] for i, _ in group))
        else:
            parts, loaded = {i: bounds[i] for i, _ in group}, ca.SX(reach > 0)
            reach = ca.if_else(loaded, reach, 1)
        for i, factor in group:
            part = _sign(factor) * parts[i] * whole / reach
            shared[i] = ca.if_else(sticks[i] * loaded, part, friction[i])
    return shared
