"""Crossings of a surface by a trajectory: sign changes of a function of the state along its polynomials.

A step is halved until the function has no zero or is monotone on each part, by bounds from its Chebyshev coefficients,
so that no pair of close crossings is missed. Each crossing is located within a bracket on the step's own polynomial.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from symfric.errors import SceneError
from symfric.solve.path import Path

_DEGREE = 24  # degree of the Chebyshev polynomials; a part on which they do not resolve the function is halved
_RESOLVED = 1e-12  # size of the last coefficients, relative to the largest value, of a resolved function
_ROUNDING = 64 * np.finfo(float).eps  # value that counts as zero, relative to the largest value
_CALM = 1e-12  # variation, relative to that by the states, below which the function is zero up to rounding
_SHIFT = 1e-6  # finite-difference step relative to the sizes of the states
_HALVINGS = 50  # most halvings of a step
_NARROW = 2.0**-54  # width of a bracket, as a fraction of a step, at which a crossing is found
_ROUNDS = 2 * _HALVINGS  # most rounds of this search
_BLOCK = 4096  # steps processed at once, which bounds the memory
_MOST = 64 * _BLOCK  # most parts at once; a noisy function is not split further

_PLACES = 0.5 - 0.5 * np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)  # Chebyshev nodes on [0, 1]
_COEFFICIENTS = np.linalg.inv(np.polynomial.chebyshev.chebvander(2 * _PLACES - 1, _DEGREE))
_SLOPES = np.polynomial.chebyshev.chebder(np.eye(_DEGREE + 1))

Function = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Parts(NamedTuple):
    """Parts of the steps of a path: index of the step, start and width as fractions of it; each (n,)."""

    step: np.ndarray
    begin: np.ndarray
    width: np.ndarray


def crossings(
    path: Path, function: Function, direction: int, after: float, sizes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the times and states at which a trajectory crosses a surface.

    Parameters
    ----------
    path : Path
    function : callable
        ``(x, t) -> g`` with x (n_x, ...) and t (...); the surface is g = 0.
    direction : int
        1 where g rises, -1 where it falls, 0 for both.
    after : float
        Earlier crossings are left out.
    sizes : ndarray, shape (n_x,)
        Sizes of the states.

    Returns
    -------
    times : ndarray, shape (n,)
    states : ndarray, shape (n_x, n)

    Raises
    ------
    SceneError
        If the function is not finite on the motion.

    Notes
    -----
    A motion that touches the surface and turns back does not cross it. One that stays on it for a while, as one that
    sticks may, crosses it where it arrives, and only if it leaves on the other side. What begins on the surface does
    not cross it there. A jump through the surface, as that of an impact, crosses it, with the state before the jump.
    """
    first = int(path.step_of(np.array(after)))
    blocks = [np.arange(k, min(k + _BLOCK, path.t.size)) for k in range(first, path.t.size, _BLOCK)]
    scale = max(_largest(path, function, block) for block in blocks)
    if not np.isfinite(scale):
        raise SceneError("the section is not finite somewhere on the motion; check its roots and divisions")
    if scale <= _CALM * _moved(path, function, slice(first, None), sizes):
        return np.zeros(0), np.zeros((path.coefficients.shape[1], 0))
    blur = _ROUNDING * scale
    split = [_split(path, function, blur, block) for block in blocks]
    parts = Parts(*(np.concatenate(column) for column in zip(*(p for p, _ in split), strict=True)))
    part, ends, value = _with_jumps(path, function, blur, blocks, parts.step, np.concatenate([v for _, v in split]))
    sign = np.where(np.abs(value) <= blur, 0.0, np.sign(value))
    off = np.flatnonzero(sign)
    before = off[:-1][sign[off[:-1]] * sign[off[1:]] < 0]
    before = before[sign[before] != direction]
    step, place = _located(path, function, Parts(*(p[part[before]] for p in parts)), sign[before])
    place = np.where(ends[before], 1.0, place)
    times = path.t[step] + place * path.h[step]
    late = times >= after
    return times[late], _states(path, step, place[:, None])[:, late, 0]


def _with_jumps(
    path: Path, function: Function, blur: float, blocks: list[np.ndarray], step: np.ndarray, value: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Add the values before jumps, and that at the end, to those at the start of the parts.

    Parameters
    ----------
    step, value : ndarray, shape (n,)
        Of each part.

    Returns
    -------
    part : ndarray of int, shape (m,)
        To which each value belongs.
    ends : ndarray of bool, shape (m,)
        Whether it is that at the end of its part.
    value : ndarray, shape (m,)
    """
    left = np.concatenate([_values(path, function, block, np.ones((block.size, 1)))[:, 0] for block in blocks])
    last = np.flatnonzero(np.append(np.diff(step), 1))  # part of each step
    jumps = np.append(np.abs(left[:-1] - value[last[:-1] + 1]) > blur, True)
    at, every = last[jumps], np.arange(step.size)
    ends = np.insert(np.zeros(step.size, dtype=bool), at + 1, True)
    return np.insert(every, at + 1, at), ends, np.insert(value, at + 1, left[jumps])


def _states(path: Path, step: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the states at places (m, k), fractions of m steps, shape (n_x, m, k)."""
    c = path.coefficients[step].transpose(1, 2, 0)[..., None]  # (n_x, order + 1, m, 1)
    s = place * path.h[step][:, None]
    x = c[:, -1] + 0.0 * s
    for j in range(c.shape[1] - 2, -1, -1):
        x = x * s + c[:, j]
    return np.asarray(x)


def _values(path: Path, function: Function, step: np.ndarray, place: np.ndarray) -> np.ndarray:
    return function(_states(path, step, place), path.t[step][:, None] + place * path.h[step][:, None])


def _largest(path: Path, function: Function, step: np.ndarray) -> float:
    """Return about the largest magnitude of the function on some steps, from samples."""
    return float(np.max(np.abs(_values(path, function, step, np.tile(_PLACES[::4], (step.size, 1))))))


def _moved(path: Path, function: Function, steps: slice, sizes: np.ndarray) -> float:
    """Return how much the function changes when each state changes by its size: the scale of its rounding error."""
    x, t = path.coefficients[steps, :, 0].T, path.t[steps]
    here = function(x, t)
    ways = _SHIFT * np.diag(sizes)
    return float(np.max(sum(np.abs(function(x + way[:, None], t) - here) for way in ways))) / _SHIFT


def _split(path: Path, function: Function, blur: float, step: np.ndarray) -> tuple[Parts, np.ndarray]:
    """Split steps into parts on which the function has no zero or is monotone; return the parts and its initial values.

    The values, (n,), are those at the start of the parts, which are in the order of time.
    """
    waiting, done = Parts(step, np.zeros(step.size), np.ones(step.size)), []
    for halving in range(_HALVINGS + 1):
        g = _values(path, function, waiting.step, waiting.begin[:, None] + waiting.width[:, None] * _PLACES)
        ready = _decided(g, blur)
        if halving == _HALVINGS or waiting.step.size > _MOST:
            ready[:] = True
        done.append((*(p[ready] for p in waiting), g[ready, 0]))
        step, left, half = (waiting.step[~ready], waiting.begin[~ready], 0.5 * waiting.width[~ready])
        if not step.size:
            break
        waiting = Parts(np.tile(step, 2), np.concatenate([left, left + half]), np.tile(half, 2))
    step, start, width, value = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.lexsort((start, step))
    return Parts(step[order], start[order], width[order]), value[order]


def _decided(g: np.ndarray, blur: float) -> np.ndarray:
    """Whether the function has no zero, is monotone or is zero on each part; `g` holds its values at `_PLACES`."""
    c = np.abs(g @ _COEFFICIENTS.T)
    slope = np.abs(g @ (_SLOPES @ _COEFFICIENTS).T)
    size = np.max(np.abs(g), axis=1)
    resolved = np.max(c[:, -3:], axis=1) <= _RESOLVED * size + blur
    apart = c[:, 0] > np.sum(c[:, 1:], axis=1) + blur
    monotone = slope[:, 0] > np.sum(slope[:, 1:], axis=1)
    return np.asarray((size <= blur) | (resolved & (apart | monotone)))


def _located(path: Path, function: Function, parts: Parts, sign: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the step, and the fraction of it, at which the function changes its sign on each part.

    By the method of Chandrupatla (Advances in Engineering Software 28, 1997, 145-149): an inverse quadratic step where
    the last three values allow it, else a bisection.
    """
    if not sign.size:
        return parts.step, parts.begin
    begin, h, c = path.t[parts.step], path.h[parts.step], path.coefficients[parts.step]
    orders = np.arange(c.shape[2])

    def after(place: np.ndarray) -> np.ndarray:
        """Return the function, positive behind the crossing."""
        x = np.einsum("mxk,mk->xm", c, (place * h)[:, None] ** orders)
        return -sign * function(x, begin + place * h)

    low, high = parts.begin, parts.begin + parts.width
    (a, f_a), (b, f_b) = (high, after(high)), (low, after(low))  # the newest place, and one beyond the crossing from it
    part = np.full(sign.size, 0.5)
    for _ in range(_ROUNDS):
        x = a + part * (b - a)
        f = after(x)
        behind = f >= 0
        low, high = np.where(behind, low, x), np.where(behind, x, high)
        wide = high - low
        if np.all((wide <= _NARROW) | (wide <= np.spacing(high))):
            break
        same = behind == (f_a >= 0)
        third, f_third = np.where(same, a, b), np.where(same, f_a, f_b)
        b, f_b = np.where(same, b, a), np.where(same, f_b, f_a)
        a, f_a = x, f
        with np.errstate(all="ignore"):
            xi, phi = (a - b) / (third - b), (f_a - f_b) / (f_third - f_b)
            steep = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
            inner = f_a / (f_b - f_a) * f_third / (f_b - f_third)
            inner += (third - a) / (b - a) * f_a / (f_third - f_a) * f_b / (f_third - f_b)
        least = np.minimum(0.5, np.maximum(_NARROW, np.spacing(high)) / wide)
        part = np.clip(np.where(steep & np.isfinite(inner), inner, 0.5), least, 1 - least)
    return parts.step, high
