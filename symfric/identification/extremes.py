"""Turning points of a free decay, from a noisy record."""

from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound

WINDOW = 0.1  # half width of the samples around an extreme that it is taken from, in periods
DEGREE = 4  # of the polynomial through them
LEAST = 8  # samples that it takes
OVER_NOISE = 4.0  # excursions that count, in standard deviations of the noise
LATE = 1.4  # the longest half period, relative to the usual one, before the motion counts as ended
FEWEST = 4  # extremes


class Extremes(NamedTuple):
    """Turning points.

    Attributes
    ----------
    t, x : ndarray, shape (n,)
    sigma : ndarray, shape (n,)
        Standard errors of `x`.
    omega : float
        Angular frequency, from their times.
    """

    t: np.ndarray
    x: np.ndarray
    sigma: np.ndarray
    omega: float


def extremes(t: np.ndarray, x: np.ndarray, noise: float | None = None) -> Extremes:
    """Return the turning points of a record that swings about its middle.

    Parameters
    ----------
    t, x : ndarray, shape (n,)
    noise : float, optional
        Standard deviation of a sample; from second differences unless given.

    Raises
    ------
    NotFound
        If fewer than 4 are found.

    Notes
    -----
    Each is the extreme of a polynomial of degree 4 through the samples within a tenth of a period of it, which averages
    the noise; those at the ends of the record, and the last excursion, in which the body may rest, are left out.
    """
    scatter = float(np.std(np.diff(x, 2))) / np.sqrt(6) if noise is None else noise
    rough = _rough(x, OVER_NOISE * scatter)
    if rough.size < 2:
        raise NotFound("the record has no swings above its noise; give a record of a free decay")
    half = float(np.median(np.diff(t[rough])))
    kept: list[float] = []
    places: list[tuple[float, float, float]] = []
    for k in rough:
        if t[k] - t[0] < 2 * WINDOW * half or (kept and t[k] - kept[-1] > LATE * half):
            if kept:
                break
            continue
        at = _refined(t, x, t[k], 2 * WINDOW * half, noise)
        if at is not None:
            kept.append(float(t[k]))
            places.append(at)
    if len(places) < FEWEST:
        raise NotFound(
            f"the record has {len(places)} swings above its noise with enough samples; a decay needs at least {FEWEST}"
        )
    times, values, errors = np.array(places).T
    omega = np.pi / float(np.polyfit(np.arange(times.size), times, 1)[0])
    return Extremes(times, values, np.maximum(errors, 1e-12 * float(np.max(np.abs(values)))), omega)


def _rough(x: np.ndarray, threshold: float) -> np.ndarray:
    """Return the index of the largest sample of each excursion to one side, the last one left out."""
    centred = x - 0.5 * (np.max(x[x.size // 2 :]) + np.min(x[x.size // 2 :]))
    threshold = max(threshold, 1e-9 * float(np.max(np.abs(centred))))
    out = np.flatnonzero(np.abs(centred) > threshold)
    side = np.sign(centred[out])
    begins = np.flatnonzero(np.diff(side, prepend=0.0))
    parts = np.split(out, begins[1:])
    return np.array([p[np.argmax(np.abs(centred[p]))] for p in parts[:-1]], dtype=int)


def _refined(
    t: np.ndarray, x: np.ndarray, at: float, reach: float, noise: float | None
) -> tuple[float, float, float] | None:
    """Return time, value and standard error of the extreme near a time, None for too few samples."""
    for _ in range(2):
        near = np.abs(t - at) <= reach
        s = (t[near] - at) / reach
        if s.size < LEAST or t[0] > at - reach or t[-1] < at + reach:
            return None
        table = np.polynomial.polynomial.polyvander(s, DEGREE)
        inverse = np.linalg.pinv(table)
        own = inverse @ x[near]
        turns = np.polynomial.polynomial.polyroots(np.polynomial.polynomial.polyder(own))
        turns = turns.real[(np.abs(turns.imag) < 1e-9) & (np.abs(turns.real) <= 1)]
        if not turns.size:
            return None
        place = float(turns[np.argmin(np.abs(turns))])
        at += place * reach
    row = place ** np.arange(DEGREE + 1)
    rest = x[near] - table @ own
    scatter = float(np.sqrt(rest @ rest / max(1, s.size - DEGREE - 1))) if noise is None else noise
    return at, float(row @ own), scatter * float(np.linalg.norm(row @ inverse))
