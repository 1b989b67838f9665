"""Every combination of what contacts do in an impact; the one with the largest least margin is taken.

So ties, where one of several contacts is on the border between two, need no threshold.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.impacts import APART, SLIPS, STICKS, TURNS
from symfric.solve.loop.codes import MANY_CONTACTS, OK, PAINLEVE, SLIP
from symfric.solve.loop.events.direction_sizes import SAMPLES
from symfric.solve.loop.events.directions import (
    AGREE,
    MOST_SWEEPS,
    POLISHES,
    START_ANGLE,
    chord_step,
    find_angles,
    sample_angle,
)
from symfric.solve.loop.events.impact_verdicts import DISTINCT, is_best, keep, least_margin, restore, staying
from symfric.solve.loop.events.impacts import (
    FEASIBLE,
    MOST_TRIALS,
    SECOND,
    SWERVE,
    ask,
    field_of,
    is_planar,
    largest_rate,
    next_trial,
    set_way_before,
    told,
)
from symfric.solve.loop.precision import TINY
from symfric.solve.loop.workspace import LoopArrays


@compiled
def try_all(w: LoopArrays, alone: bool) -> int:
    """Try all combinations; leave the best in place.

    Where friction drops from rest to slip, what static friction can hold stays, though it could slip as well.
    """
    n, total, best, second, held = w.openings.variable.size, 1.0, -np.inf, -np.inf, 0
    for k in range(n):
        w.impacts.tried[k] = 0
        w.impacts.options[k] = _options(w, k, alone)
        total *= w.impacts.options[k]
    if total > MOST_TRIALS:
        return MANY_CONTACTS
    scale = max(largest_rate(w), TINY)
    for _ in range(int(total)):
        for k in range(n):
            _set(w, k, alone)
        for way in range(_aim(w)):
            _take_way(w, way)
            ask(w)
            margin = least_margin(w)
            stay = staying(w) if margin > DISTINCT * scale else 0
            if stay < held:
                continue
            if stay > held:
                best, second, held = -np.inf, -np.inf, stay
            if margin > best:
                if best > -np.inf and not is_best(w):
                    second = best
                best = margin
                keep(w)
            elif margin > second and not is_best(w):
                second = margin
        next_trial(w, n)
    restore(w)
    return OK if best >= -FEASIBLE * scale and not second > DISTINCT * scale else PAINLEVE


@compiled(inline=True)
def _options(w: LoopArrays, k: int, alone: bool) -> int:
    """Return the number of things that contact k may do."""
    if w.impacts.touches[k] == 0:
        return 1
    return (2 if w.openings.line[k] < 0 else (3 if is_planar(w, k) else 4)) - alone


@compiled(inline=True)
def _set(w: LoopArrays, k: int, alone: bool) -> None:
    """Set what contact k does in the present trial."""
    kind, side, option = APART, 1.0, w.impacts.tried[k]
    if w.impacts.touches[k]:
        option += alone  # the only one is not apart
        kind = APART if option == 0 else (STICKS if option == 1 else SLIPS)
        side = 1.0 if option < 3 else -1.0
        i = w.openings.line[k]
        slips = i >= 0 and set_way_before(w, k)
        if alone and slips and not is_planar(w, k):
            kind = STICKS if option == 1 else (SLIPS if option == 2 else TURNS)
            side = 1.0 if w.gauge[SLIP, i] > 0.0 else -1.0
    w.impacts.asked[field_of(w, 0, k)], w.impacts.asked[field_of(w, 1, k)] = kind, side


@compiled
def _aim(w: LoopArrays) -> int:
    """Find the directions of slips in the plane after the impact that friction opposes; return the number of choices.

    Those of one contact are in ``w.planes.angles``. Those of several are found one after the other, until they agree:
    one choice at most, which is the only one as long as the contacts affect each other weakly.
    """
    slipping, last = 0, -1
    for k in range(w.openings.variable.size):
        if is_planar(w, k) and w.impacts.asked[field_of(w, 0, k)] == SLIPS:
            slipping, last = slipping + 1, k
            _point(w, k, START_ANGLE)
    w.planes.aimed[0] = last
    if slipping == 0:
        w.planes.aimed[0] = -1
        return 1
    if slipping == 1:
        return _ways(w, last)
    w.planes.aimed[0] = -1
    for _ in range(MOST_SWEEPS):
        turned = 0.0
        for k in range(w.openings.variable.size):
            if is_planar(w, k) and w.impacts.asked[field_of(w, 0, k)] == SLIPS:
                turned = max(turned, _turn_to_best(w, k))
        if not turned > AGREE:
            return 1 if turned >= 0.0 else 0
    return 0


@compiled
def _ways(w: LoopArrays, k: int) -> int:
    """Find the directions of contact k, with those of the others as they are; return how many there are."""
    for s in range(SAMPLES):
        _point(w, k, sample_angle(s))
        ask(w)
        w.planes.samples[s] = told(w, SWERVE, k)
    n = find_angles(w)
    for s in range(n):
        for _ in range(POLISHES):
            angle = w.planes.angles[s]
            _point(w, k, angle)
            ask(w)
            step = chord_step(w, angle, told(w, SWERVE, k))
            w.planes.angles[s] = angle - step
    return n


@compiled
def _turn_to_best(w: LoopArrays, k: int) -> float:
    """Turn contact k to the direction of the largest margin; return by how much, NaN if there is none."""
    e, f, best, angle = w.impacts.asked[field_of(w, 4, k)], w.impacts.asked[field_of(w, 5, k)], -np.inf, np.nan
    for s in range(_ways(w, k)):
        _point(w, k, w.planes.angles[s])
        ask(w)
        if told(w, SECOND, k) > best:
            best, angle = told(w, SECOND, k), w.planes.angles[s]
    _point(w, k, angle)
    return abs(w.impacts.asked[field_of(w, 4, k)] - e) + abs(w.impacts.asked[field_of(w, 5, k)] - f)


@compiled(inline=True)
def _take_way(w: LoopArrays, way: int) -> None:
    """Take one of the directions that were found."""
    if w.planes.aimed.size and w.planes.aimed[0] >= 0:
        _point(w, w.planes.aimed[0], w.planes.angles[way])


@compiled(inline=True)
def _point(w: LoopArrays, k: int, angle: float) -> None:
    """Set the direction of contact k in the plane."""
    w.impacts.asked[field_of(w, 4, k)], w.impacts.asked[field_of(w, 5, k)] = np.cos(angle), np.sin(angle)
