"""Bounces that die out: when infinitely many of them are over, and flights that are too short to count."""

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.events.impacts import AFTER, RATE, SIZE, is_open, told
from symfric.solve.loop.modes.tolerances import instant, natural_time
from symfric.solve.loop.workspace import LoopArrays

_LITTLE = 0.01  # flight of a contact that rocks, in tolerances of the natural time, that is negligible
_INSTANTS = 128.0  # the same in rounding errors of the present time
_ALIKE = 1e-6  # relative difference of flights that count as the same


@compiled(inline=True)
def _negligible(w: LoopArrays) -> float:
    """Return the duration of a flight that is negligible."""
    return max(_LITTLE * w.clock.tolerance * natural_time(w), _INSTANTS * instant(w))


@compiled
def dies_out(w: LoopArrays, n_x: int) -> bool:
    """Whether contacts that strike in turns, as of a block that rocks, leave each other for a negligible time."""
    struck, leaves, little = False, False, _negligible(w)
    for k in range(w.openings.variable.size):
        struck = struck or w.impacts.struck[k] != 0
        if w.impacts.touches[k] and w.impacts.rests[k] == 0:
            g = n_x + w.limits.first_opening + 2 * k
            v, a = told(w, AFTER, k), -2.0 * w.probe[g, 2]
            if w.impacts.struck[k] or not 2.0 * v < a * little:
                return False
            leaves = True
    return struck and leaves


@compiled
def time_to_rest(w: LoopArrays, n_x: int) -> float:
    """Return after which time the bounces of the contacts that struck have died out, 0 unless that is negligible.

    With the rate v of the gap after the impact, its acceleration -a and jerk j, the flights last
    ``s + j s^2/(3 a) + O(s^3)`` in all, ``s = 2 v/(a (1 - e))``, from ``s = 2 v/a (1 + e + e^2 + ...)`` without jerk.
    The rest of this series and the height of the flights are below the tolerance; the motion in the mean is that of the
    closed contact. This holds for one contact that no other one strikes meanwhile, and for several whose flights are
    the same. A flight of a negligible time is the last one, at any e.
    """
    longest, first, ratio, little = 0.0, 0.0, 0.0, _negligible(w)
    for k in range(w.openings.variable.size):
        v, g = told(w, AFTER, k), n_x + w.limits.first_opening + 2 * k
        if w.impacts.struck[k] == 0 or not is_open(w, k):
            continue
        e, a, jerk = -v / told(w, RATE, k), -2.0 * w.probe[g, 2], 6.0 * w.probe[g, 3]
        if a <= 0.0 or not e > 0.0:
            return 0.0
        flight = 2.0 * v / a
        if flight <= little:
            longest = max(longest, flight)
            continue
        if e >= 1.0:
            return 0.0
        rest = flight / (1.0 - e)
        height, size = v * v / a, max(w.scale[g], told(w, SIZE, k))
        bend = jerk * rest / a
        if height > w.clock.tolerance * size or bend * bend * rest > w.clock.tolerance * natural_time(w):
            return 0.0
        if first > 0.0 and not (abs(flight - first) <= _ALIKE * first and abs(e - ratio) <= _ALIKE):
            return 0.0
        longest, first, ratio = max(longest, all_flights(w, n_x, k)), flight, e
    return 0.0 if longest > little and _another_strikes(w, n_x, longest) else longest


@compiled
def all_flights(w: LoopArrays, n_x: int, k: int) -> float:
    """Return how long the bounces of contact k last, from its impact, and the series of a flight in ``w.probe``."""
    v, g = told(w, AFTER, k), n_x + w.limits.first_opening + 2 * k
    e, a, jerk = -v / told(w, RATE, k), -2.0 * w.probe[g, 2], 6.0 * w.probe[g, 3]
    rest = 2.0 * v / a
    if e < 1.0:  # else it is the last one, see `time_to_rest`
        rest /= 1.0 - e
    return rest + jerk * rest * rest / (3.0 * a)


@compiled
def _another_strikes(w: LoopArrays, n_x: int, time: float) -> bool:
    """Whether a contact that did not strike closes within a time, with the accelerations of the present mode."""
    for k in range(w.openings.variable.size):
        g = n_x + w.limits.first_opening + 2 * k
        flies = is_open(w, k) and w.impacts.struck[k] == 0
        if flies and w.probe[g, 0] + time * (w.probe[g, 1] + time * w.probe[g, 2]) < 0.0:
            return True
    return False
