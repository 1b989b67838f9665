"""Stick-slip of two slides: the smallest static friction with a limit cycle, and the cycles above it.

With a smaller static friction the slip phase starts with a smaller excess force, and its minimum of w is higher. The
cycle ends where it only touches w = 0, a condition on a periodic orbit that is solved as such.
"""

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.model.arguments import is_one_of, items
from symfric.model.numeric import Floats
from symfric.model.symbols import finite, shortened
from symfric.search import ROUNDING, zero
from symfric.spelling import spelt
from symfric.theory.drive.pair import (
    Pair,
    SlidesOrbit,
    W,
    closed,
    difference,
    landed,
    multipliers,
    passes,
    path,
    released,
    slope,
    turns,
)
from symfric.theory.drive.slides import ratios
from symfric.theory.drive.slides_cycle import SlidesCycle

DIPS = 6  # number of minima of w, in the slip after a long stick, tried as the grazing one
LOOK = 2**15  # number of samples of that slip
LARGEST = 1e6  # largest delta sought
FIRST = 1e-4, 1.5  # first step from a grazing orbit, of delta, and its growth while the family has not turned
LONGEST = 40  # decay times, or periods, of the slip after a long stick
INWARD = 0.02, 1e-15  # first step towards weaker friction, of the load, and the least one, where the family ends
REMEMBER = (0.0, 0.25, 0.5, 0.75, 1.0)  # homotopy: weights of the dependence of the stick on the previous slip


@spelt
def two_slides_threshold(
    *, r: float, zeta: float, s1: float, s2: float, fc1: float = 1.0, damping: str = "omega1"
) -> float:
    """Return the smallest static friction fs1 at which two slides have a limit cycle of one slip and one stick.

    Parameters
    ----------
    r, zeta, s1, s2, damping
        As in `slope_limits`.
    fc1 : float
        Kinetic friction over ``m1 omega1 v`` >= 0.

    Returns
    -------
    float
        ``fc1`` more than a number that does not depend on it; infinite if the slip after a long stick does not come
        back to w = 0, however strong the friction was (up to 1e6).

    Raises
    ------
    NotFound
        If it does come back, but no cycle of one slip and one stick is found.
    SceneError
        If a parameter is bad.

    Notes
    -----
    See `two_slides_onset`. With little damping cycles of several slips may go on below; its `end` tells.

    Examples
    --------
    >>> import symfric as sf
    >>> pair = dict(r=0.5, zeta=2, s1=0.2, s2=0.3)
    >>> round(sf.theory.drive.two_slides_threshold(**pair), 6)
    7.742902
    """
    pair, fc1 = Pair(*ratios(r, zeta, s1, s2, damping)), _kinetic(fc1)
    return fc1 + difference(pair, _onset(pair, fc1)[0]) if _dips(pair) else float("inf")


@spelt
def two_slides_onset(
    *, r: float, zeta: float, s1: float, s2: float, fc1: float = 1.0, damping: str = "omega1"
) -> SlidesCycle:
    """Return the limit cycle of two slides with the smallest static friction.

    Parameters
    ----------
    r, zeta, s1, s2, fc1, damping
        As in `two_slides_threshold`.

    Returns
    -------
    SlidesCycle

    Raises
    ------
    NotFound
        If there is no cycle of one slip and one stick.
    SceneError
        If a parameter is bad.

    Notes
    -----
    Guida, before figure 15: a phase trajectory tangent to ``eta1' - eta2' = -1``. Solves for the periodic orbit of
    closed-form slip and stick whose slip ends with w = w' = 0. The first guess is the slip after a long stick, which
    starts at ``a + b delta``: of all times t the least ``delta(t)`` with w(t) = 0. Where delta falls from the grazing
    orbit on, into the family, its least value is a fold. Derived in derivations/guida.

    Examples
    --------
    >>> import symfric as sf
    >>> pair = dict(r=0.5, zeta=2, s1=0.2, s2=0.3)
    >>> round(sf.theory.drive.two_slides_onset(**pair).period, 6)
    30.34765
    """
    pair, fc1 = Pair(*ratios(r, zeta, s1, s2, damping)), _kinetic(fc1)
    return _cycle(pair, fc1, *_onset(pair, fc1))


@spelt
def two_slides_cycle(
    *, r: float, zeta: float, s1: float, s2: float, fc1: float = 1.0, fs1: float, damping: str = "omega1"
) -> SlidesCycle:
    """Return the limit cycle of two slides from closed-form linear flows, matched by Newton's method.

    Parameters
    ----------
    r, zeta, s1, s2, fc1, damping
        As in `two_slides_threshold`.
    fs1 : float
        Static friction over ``m1 omega1 v``.

    Returns
    -------
    SlidesCycle

    Raises
    ------
    NotFound
        If there is no cycle of one slip and one stick.
    SceneError
        If a parameter is bad.

    Examples
    --------
    >>> import symfric as sf
    >>> pair = dict(r=0.5, zeta=2, s1=0.2, s2=0.3)
    >>> round(sf.theory.drive.two_slides_cycle(**pair, fs1=7.8).period, 6)
    30.525932
    """
    pair, fc1 = Pair(*ratios(r, zeta, s1, s2, damping)), _kinetic(fc1)
    delta = finite(fs1, "fs1") - fc1
    least, end = _onset(pair, fc1)
    smallest = difference(pair, least)
    if delta < smallest:
        raise NotFound(f"fs1 is {fs1:g}: two slides of these values cycle from {fc1 + smallest:.12g} on")
    orbit = _followed(pair, fc1, least, delta) or _after_a_long_stick(pair, fc1, delta)
    if orbit is None:
        raise NotFound(f"no cycle of one slip and one stick found for fs1 = {fs1:g}")
    return _cycle(pair, fc1, orbit, end if delta == smallest else "")


@spelt
def two_slides_thresholds(
    parameter: str,
    values: Floats,
    *,
    r: float | None = None,
    zeta: float | None = None,
    s1: float | None = None,
    s2: float | None = None,
    fc1: float = 1.0,
    damping: str = "omega1",
) -> np.ndarray:
    """Return the smallest fs1 with a limit cycle for many values of one parameter, by continuation.

    Parameters
    ----------
    parameter : {"r", "zeta", "s1", "s2"}
        Given by `values`; the others by themselves.
    values : sequence of float
    r, zeta, s1, s2, fc1 : float
        The others of the parameters of `two_slides_threshold`.
    damping : {"omega1", "omega2"}
        What s2 refers to.

    Returns
    -------
    ndarray, shape (n,)
        As `two_slides_threshold`.

    Raises
    ------
    SceneError
        If an argument is out of its range.

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> found = sf.theory.drive.two_slides_thresholds("s1", [0.2, 0.25], r=0.5, zeta=2, s2=0.3)
    >>> round(float(np.asarray(found)[0]), 6)
    7.742902
    """
    given = {"r": r, "zeta": zeta, "s1": s1, "s2": s2}
    if not is_one_of(parameter, given):
        raise SceneError(f"no parameter {shortened(parameter)} to vary; there are {', '.join(given)}")
    if given[parameter] is not None:
        raise SceneError(f"{parameter} is varied and given as {shortened(given[parameter])}; leave it out")
    fc1, orbit, thresholds = _kinetic(fc1), None, []
    for value in items(values, "values"):
        pair = Pair(*ratios(**{**given, parameter: value}, damping=damping))
        orbit, end = _again(pair, fc1, orbit) or (_onset(pair, fc1) if _dips(pair) else (None, ""))
        thresholds.append(np.inf if orbit is None else fc1 + difference(pair, orbit))
        orbit = orbit if end in ("grazing", "longer slip") else None
    return np.array(thresholds)


def _kinetic(fc1: float) -> float:
    fc1 = finite(fc1, "fc1")
    if fc1 < 0:
        raise SceneError(f"fc1 is {fc1:g}; friction is not negative")
    return float(fc1)


def _onset(pair: Pair, fc1: float) -> tuple[SlidesOrbit, str]:
    """Return the orbit of the smallest delta, and the kind of end of its family; raise `NotFound` if there is none."""
    dips = _dips(pair)
    if not dips:
        raise NotFound("two slides of these values do not cycle: the slip after a long stick does not come back")
    orbits = []
    for t, delta, y in dips[:DIPS]:
        orbit = _remembering(pair, _stuck(pair, y, t, delta), landing=0.0)
        if orbit is not None and passes(pair, orbit, fc1) and W @ pair.slip @ pair.slip @ orbit.y > 0:
            orbits.append(orbit)
    orbits.sort(key=lambda orbit: difference(pair, orbit))
    onset = (_least(pair, fc1, orbits[0]) if orbits else None) or _from_above(pair, fc1, dips[0][1])
    if onset is None:
        raise NotFound("no cycle of one slip and one stick found for two slides of these values")
    return onset


def _dips(pair: Pair) -> list[tuple[float, float, np.ndarray]]:
    """Return time, delta and state where a slip after a long stick would graze w = 0, smallest delta first."""
    a, b = pair.ramp()
    t, fundamental = _long_slip(pair)
    rise, fall = 1 + fundamental @ a @ W, fundamental @ b @ W
    with np.errstate(divide="ignore", invalid="ignore"):
        delta = np.where((fall < 0) & (rise > 0), -rise / fall, np.inf)
    least = np.flatnonzero((delta[1:-1] < delta[:-2]) & (delta[1:-1] <= delta[2:])) + 1
    order = [k for k in least[np.argsort(delta[least])] if delta[k] < LARGEST]
    return [(float(t[k]), float(delta[k]), fundamental[k] @ (a + b * delta[k])) for k in order]


def _again(pair: Pair, fc1: float, before: SlidesOrbit | None) -> tuple[SlidesOrbit, str] | None:
    """Return the onset near the grazing orbit of a neighbouring parameter value, None if it no longer exists."""
    orbit = None if before is None else closed(pair, before, landing=0.0)
    return _least(pair, fc1, orbit) if orbit is not None and passes(pair, orbit, fc1) else None


def _long_slip(pair: Pair) -> tuple[np.ndarray, np.ndarray]:
    """Return times (n,) and fundamental matrices (n, 4, 4) of slip, until it has decayed or after many periods."""
    rates = np.abs(np.linalg.eigvals(pair.slip).real)
    turns = 2 * np.pi * max(1.0, pair.zeta)
    end = min(LONGEST / np.min(rates), LONGEST * turns)
    columns = [path(pair.slipping, e, end, LOOK) for e in np.eye(4)]
    return columns[0][0], np.stack([states.T for _, states in columns], axis=2)


def _stuck(pair: Pair, y: np.ndarray, slip: float, delta: float) -> SlidesOrbit:
    """Return a guess of an orbit: the stick from y lasts until the load is delta."""
    longest = 2 * (delta + abs(pair.load @ y)) * (1 + pair.r * pair.zeta**2) + 20 * max(1.0, pair.zeta)
    t, states = path(pair.sticking, y, longest)
    return SlidesOrbit(y, float(slip), float(t[max(1, int(np.argmax(pair.load @ states >= delta)))]))


def _remembering(pair: Pair, guess: SlidesOrbit, **load: float) -> SlidesOrbit | None:
    """Close an orbit directly, or by a homotopy in the dependence of the stick on the previous slip."""
    orbit = closed(pair, guess, **load)
    if orbit is not None:
        return orbit
    orbit = guess
    for share in REMEMBER:
        orbit = closed(pair, orbit, share=share, **load)
        if orbit is None:
            return None
    return orbit


def _least(pair: Pair, fc1: float, graze: SlidesOrbit) -> tuple[SlidesOrbit, str] | None:
    """Return the orbit of the smallest delta in the family that starts at a grazing orbit, and the kind of its end."""
    delta = difference(pair, graze)
    before = graze
    for k in range(40):
        orbit = closed(pair, before, landing=-FIRST[0] * delta * FIRST[1] ** k)
        if orbit is None:
            return None
        if slope(pair, orbit) < 0:
            return (graze, _touch(pair, graze)) if k == 0 else _fold(pair, fc1, before, orbit)
        before = orbit
    return None


def _fold(pair: Pair, fc1: float, first: SlidesOrbit, second: SlidesOrbit) -> tuple[SlidesOrbit, str] | None:
    """Return the orbit of least delta between two orbits (a fold)."""
    loads = [float(pair.load @ orbit.y) for orbit in (first, second)]
    load = zero(lambda e: slope(pair, landed(pair, second, e)), *loads, xtol=1e-14 * abs(loads[1]), rtol=ROUNDING)
    fold = landed(pair, second, load)
    return (fold, "fold") if passes(pair, fold, fc1) else None


def _from_above(pair: Pair, fc1: float, delta: float) -> tuple[SlidesOrbit, str] | None:
    """Return the end of the family of cycles, continued from strong friction towards weaker friction."""
    orbit = next((o for k in range(12) if (o := _after_a_long_stick(pair, fc1, delta * 2**k)) is not None), None)
    if orbit is None:
        return None
    low, size = float(pair.load @ orbit.y), INWARD[0]
    start = low
    while size > INWARD[1]:
        high = min(low - size * start, 0.0)
        ahead = closed(pair, orbit, landing=high)
        if ahead is None or not passes(pair, ahead, fc1):
            size /= 2  # an earlier part of the slip touches w = 0 in between, or the family turns
            continue
        if slope(pair, ahead) > 0 and high < 0:
            return _fold(pair, fc1, orbit, ahead)
        orbit, low = ahead, high
        if high == 0:
            break
    return orbit, _touch(pair, orbit) if low == 0 else "inner grazing"


def _touch(pair: Pair, orbit: SlidesOrbit) -> str:
    """Return the continuation of a slip phase after it touched w = 0."""
    t, fundamental = _long_slip(pair)
    later = 1 + fundamental[t > 1e-3 * orbit.slip] @ orbit.y @ W
    return "grazing" if np.all(later > 0) else "longer slip"


def _followed(pair: Pair, fc1: float, least: SlidesOrbit, delta: float) -> SlidesOrbit | None:
    """Return the orbit of a delta by continuation from the least one; None if the family does not reach it."""
    start = pair.load @ least.y
    smallest = difference(pair, least)
    if delta <= smallest:
        return least
    orbit, low, size = least, start, 1e-3 * smallest
    for _ in range(80):
        high = low - size
        ahead = closed(pair, orbit, landing=high)
        if ahead is None or not passes(pair, ahead, fc1):
            return None
        if difference(pair, ahead) >= delta:
            break
        orbit, low, size = ahead, high, 1.5 * size
    else:
        return None
    load = zero(lambda e: difference(pair, landed(pair, ahead, e)) - delta, high, low)
    orbit = landed(pair, ahead, load)
    return orbit if passes(pair, orbit, fc1) else None


def _after_a_long_stick(pair: Pair, fc1: float, delta: float) -> SlidesOrbit | None:
    """Return the orbit of a delta from the slip after a long stick."""
    a, b = pair.ramp()
    t, fundamental = _long_slip(pair)
    w = 1 + fundamental @ (a + b * delta) @ W
    back = np.flatnonzero((w[1:-1] > 0) & (w[2:] <= 0))
    if not back.size:
        return None
    k = int(back[0]) + 1
    orbit = _remembering(pair, _stuck(pair, fundamental[k] @ (a + b * delta), t[k], delta), release=delta)
    return orbit if orbit is not None and passes(pair, orbit, fc1) else None


def _cycle(pair: Pair, fc1: float, orbit: SlidesOrbit, end: str) -> SlidesCycle:
    """Return an orbit as a `SlidesCycle`, in the source's coordinates."""
    out = released(pair, orbit)
    rest = np.array([-fc1, pair.r * pair.zeta**2 * fc1, 0.0, 0.0])
    phases = ((pair.slipping, out, orbit.slip), (pair.sticking, orbit.y, orbit.stick))
    first, second = (float(np.ptp(np.concatenate([turns(*phase, row) for phase in phases]))) for row in (0, 1))
    return SlidesCycle(
        float(fc1 + pair.load @ out),
        orbit.slip,
        orbit.stick,
        (first, second),
        orbit.y + rest,
        out + rest,
        multipliers(pair, orbit),
        end,
    )
