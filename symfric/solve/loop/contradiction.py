"""By how much the modes of contacts contradict their forces."""

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS, HOLDS, SHARES
from symfric.solve.loop.layout import backward, forward
from symfric.solve.loop.tolerances import ROUNDING, TIE, doubt_of, instant, natural_time, no_acceleration
from symfric.solve.loop.workspace import PULL

_CLEARLY = 1e3  # times zero, of what a slip acceleration becomes in a natural time


@compiled
def contradiction(w, n_x, i, horizon):
    """Return by how much the mode of contact i contradicts its forces, and the way it would slip.

    Where sticking and slipping contradict them both, to rounding, they have been tried in turn: then sticking wins if
    its force falls below its bound again, slipping otherwise.
    """
    size, where = contradicts(w, n_x, i, horizon)
    tie, turns = TIE, 3
    if size > 0.0 and (w.m[i] == HOLDS or w.m[i] == SHARES):
        turns = 4
        row = n_x + (forward(i) if where > 0 else backward(i))
        if w.probe[row, 1] > 0.0:  # it falls below its bound again: no slip would last
            tie, turns = max(TIE, 16.0 * doubt_of(w, i) / stick_scale(w, n_x + backward(i))), 2
    if size <= tie and w.turns[i] >= turns:
        return 0.0, 0  # a tie to rounding: either mode is right
    return size, where


@compiled(inline=True)
def contradicts(w, n_x, i, horizon):
    """Return the same whether or not that is a tie."""
    if not w.zero[i]:
        return 0.0, 0
    if w.m[i] == FOLLOWS or w.m[i] == AT_BOUND:
        return _drift(w, n_x + backward(i), i)
    if w.m[i] > 0.5:
        return _excess(w, n_x + backward(i), horizon, doubt_of(w, i))
    return _backing(w, n_x + backward(i), i, horizon), 0


@compiled(inline=True)
def idles(w, row):
    """Whether a slip that begins does not move at all, not even later."""
    return w.probe[row, 1] == 0.0 and w.probe[row, 2] == 0.0 and w.probe[row, 3] == 0.0


@compiled
def rests(w, row, i):
    """Whether a slip that begins does not move, to rounding."""
    later = 6.0 * abs(w.probe[row, 3]) * natural_time(w) ** 2
    return _drift(w, row, i)[0] == 0.0 and later <= _CLEARLY * no_acceleration(w, i, 0.0)


@compiled(inline=True)
def stick_scale(w, row):
    """Return the bound of a sticking contact plus the magnitude of its force, from its guards."""
    over, under = w.probe[row, 0], w.probe[row + 1, 0]
    return 0.5 * abs(over + under) + 0.5 * abs(over - under)


@compiled(inline=True)
def _excess(w, row, horizon, doubt):
    """Return by how much (relative) a sticking contact exceeds its bound now or soon, and the way it will slip.

    Both sides may be at the bound to rounding, where it is far below the forces that cancel: then the side that falls.
    An excess that is over within the rounding of time is none: that of a load which returns from zero, missed by as
    much.
    """
    scale = stick_scale(w, row)
    side = 0 if w.probe[row, 0] < w.probe[row + 1, 0] else 1
    g, slope = w.probe[row + side, 0], w.probe[row + side, 1]
    if g < -doubt and -g > slope * instant(w):
        return -g / scale, 2 * side - 1
    for _ in range(2):
        g, slope = w.probe[row + side, 0], w.probe[row + side, 1]
        if g <= ROUNDING * scale and slope * horizon < -TIE * scale:
            return 0.5 * TIE, 2 * side - 1
        side = 1 - side
    return 0.0, 0


@compiled(inline=True)
def _drift(w, row, i):
    """Return by how much a contact whose force is given starts to slip all the same, and which way.

    More than anything else may contradict: what others have to hold is known only with its friction.
    """
    rate, pull, little = w.probe[row, 1], w.gauge[PULL, i], no_acceleration(w, i, 0.0)
    if abs(rate) <= little:
        rate = w.probe[row, 2] * natural_time(w)
        if abs(rate) <= _CLEARLY * little:
            return 0.0, 0
    return 1.0 + abs(rate) / (abs(rate) + pull), 1 if rate > 0.0 else -1


@compiled(inline=True)
def _backing(w, row, i, horizon):
    """Return by how much (relative to the pull of static friction) a slipping contact accelerates the wrong way."""
    first, second, pull = w.probe[row, 1], w.probe[row, 2], w.gauge[PULL, i]
    little = no_acceleration(w, i, second)
    if first < -little:
        return -first / (pull - first)
    if first <= little and second * horizon < -no_acceleration(w, i, 0.0):
        return 0.5 * TIE
    return 0.0
