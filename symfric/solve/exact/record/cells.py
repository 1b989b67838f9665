"""Cells of the friction profile: which one the mass is in, what friction holds it there, and where friction ends."""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.solve.exact.record.accumulation import CONSTANT, GAIN, HIGH, KINETIC, LOW, MU, SLOPE, STATIC, STIFF
from symfric.solve.exact.record.forced_flow import EPS
from symfric.solve.exact.record.workspace import RecordArrays
from symfric.solve.loop.codes import LOST_CONTACT, OK, UNDECIDED
from symfric.solve.loop.precision import ROUNDING

BEHIND, AHEAD, FARTHEST = range(3)  # entries of `grip`


@compiled
def take_off(w: RecordArrays, c: int) -> None:
    """Take the part off a cell in which friction would be negative."""
    line = w.cells[c]
    zero = -line[MU] / line[SLOPE] if line[SLOPE] != 0.0 else 0.0
    if line[SLOPE] > 0.0 and _is_negative(line, line[LOW]):
        line[LOW], w.place.gaps = min(zero, line[HIGH]), 1
    elif line[SLOPE] < 0.0 and _is_negative(line, line[HIGH]):
        line[HIGH], w.place.gaps = max(zero, line[LOW]), 1
    elif line[SLOPE] == 0.0 and line[MU] < 0.0:
        line[LOW], line[HIGH], w.place.gaps = np.inf, -np.inf, 1


@compiled
def _is_negative(line: np.ndarray, u: float) -> bool:
    """Whether the coefficient of a cell is negative at u by more than rounding."""
    part = line[SLOPE] * u
    return bool(line[MU] + part < -8.0 * EPS * (abs(line[MU]) + abs(part)) or part == -np.inf)


@compiled
def cell_of(w: RecordArrays, u: float) -> int:
    """Return the cell in which u lies, the right one of an edge."""
    c = 0
    while c < w.cells.shape[0] - 1 and u >= w.cells[c, HIGH]:
        c += 1
    return c


@compiled
def ahead(w: RecordArrays, u: float, way: float) -> int:
    """Return the cell into which a mass at rest at u would slip; on an edge it depends on the direction."""
    c = w.place.where
    while way > 0.0 and c < w.cells.shape[0] - 1 and u >= w.cells[c, HIGH]:
        c += 1
    while way < 0.0 and c > 0 and u <= w.cells[c, LOW]:
        c -= 1
    return c


@compiled
def bound_friction(w: RecordArrays, u: float) -> float:
    """Set the static friction at rest at u in both directions; return u, or the edge that equals it to rounding."""
    w.grip[FARTHEST] = max(w.grip[FARTHEST], abs(u))
    for column in (LOW, HIGH):
        edge = w.cells[w.place.where, column]
        if abs(u - edge) <= ROUNDING * max(w.grip[FARTHEST], abs(edge)) < np.inf:
            u = edge
    for side, way in ((BEHIND, -1.0), (AHEAD, 1.0)):
        line = w.cells[ahead(w, u, way)]
        w.grip[side] = w.force[STATIC] * (line[MU] + line[SLOPE] * u)
    return u


@compiled
def drive(w: RecordArrays, u: float, a: float) -> float:
    """Return the direction in which the applied force moves a mass at rest at u, 0 if friction holds it."""
    applied = w.force[GAIN] * a + w.force[CONSTANT] - w.force[STIFF] * u
    if applied > w.grip[AHEAD] * (1.0 + 4.0 * EPS):  # a force that equals the bound to rounding is held
        return 1.0
    return -1.0 if applied < -w.grip[BEHIND] * (1.0 + 4.0 * EPS) else 0.0


@compiled
def is_lost(w: RecordArrays, u: float) -> bool:
    """Whether friction would be negative at u, or beyond it."""
    return bool(w.place.gaps and not w.cells[w.place.where, LOW] <= u <= w.cells[w.place.where, HIGH])


@compiled
def friction_holds(w: RecordArrays, u: float) -> int:
    """Return the status of the friction at the start, which may not be negative, nor larger once it slips."""
    kinetic, static = w.force[KINETIC], w.force[STATIC]
    if is_lost(w, u) or (kinetic < 0.0 and static < 0.0):
        return LOST_CONTACT
    rounding = 1e-12 * abs(static)
    return UNDECIDED if kinetic < -rounding or kinetic > static + rounding else OK
