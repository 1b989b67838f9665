"""Mean drag and power of a contact under fast vibration across or along its sliding direction.

The sliding speed is v, the fast velocity ``q cos theta``. Across it the slip is ``S = sqrt(v^2 + q^2 cos^2 theta)``,
and along it ``w = v + q cos theta``. All results are per normal load.
"""

import itertools
import math
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.laws import Law
from symfric.model.numeric import gauss_legendre
from symfric.model.symbols import numbers_of, shortened
from symfric.spelling import spelt

Values: TypeAlias = Any  # a number or an array of them
_Of = Callable[[float, float], float]
_Weight = Callable[[np.ndarray], np.ndarray]
_FAR = 40.0  # exponent beyond which the integrand of a mean across is below rounding
_NODES = 24  # of a panel
_HALVES = 0.5 ** np.arange(50, 0, -1.0)
_GRADED = np.concatenate([[0.0], _HALVES, 1 - _HALVES[-2::-1], [1.0]])  # edges of panels that get finer to both ends


@spelt
def lateral_vibration_drag(speed: Values, intensity: Values, law: Law | None = None) -> Any:
    r"""Return the mean friction against the sliding under fast vibration across it, over the normal load.

    Parameters
    ----------
    speed : float or array_like
        Sliding speed, >= 0.
    intensity : float or array_like
        Amplitude q of the fast velocity across, >= 0, in the unit of the speed; broadcast against `speed`.
    law : Law, optional
        In numbers; Coulomb friction with the coefficient 1 by default, whose drag is a factor for every other one.

    Returns
    -------
    float or ndarray
        Zero at rest, except without vibration.

    Raises
    ------
    SceneError
        If a number is negative or the law has symbols or memory.

    Notes
    -----
    :math:`\langle\mu(S)\,v/S\rangle`. Of Coulomb friction :math:`\frac{2}{\pi}\frac{v}{A}K(m)`,
    :math:`A^2 = v^2 + q^2`, ``m = (q/A)^2``, from ``1 - m = (v/A)^2``, so that no digits are
    lost for v << q; other laws by quadrature in the variable x of ``tan theta = sqrt(v/A) e^x`` (theta from the slowest
    instant), in which the integrand is smooth on every scale. ``law.averaged_across(q)`` is the same mean
    as a law for scenes.

    Examples
    --------
    >>> import symfric as sf
    >>> f"{sf.theory.plane.lateral_vibration_drag(1.0, 2.0):.12f}"
    '0.642637681773'
    """
    from scipy.special import ellipkm1

    if law is not None:
        return _each(speed, intensity, lambda v, q: _drag_across(law, v, q), law)
    v, q = _given(speed, intensity)
    total = np.hypot(v, q)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = v / total
        drag = np.where(v > 0, 2 / np.pi * cosine * ellipkm1(cosine**2), 0.0)
    tiny = (v > 0) & (cosine < 1e-150)  # its square underflows; K is ln(4 A/v) there
    if np.any(tiny):
        with np.errstate(divide="ignore", invalid="ignore"):
            drag = np.where(tiny, 2 / np.pi * cosine * (math.log(4) - np.log(cosine)), drag)
    return _plain(drag)


@spelt
def longitudinal_vibration_drag(speed: Values, intensity: Values, law: Law | None = None) -> Any:
    r"""Return the mean friction against the sliding under fast vibration along it, over the normal load.

    Parameters
    ----------
    speed, intensity, law
        As in `lateral_vibration_drag`, the vibration along the sliding direction.

    Returns
    -------
    float or ndarray

    Raises
    ------
    SceneError
        If a number is negative or the law has symbols or memory.

    Notes
    -----
    ``<mu(v + q cos theta)>``, which ``law.averaged(q)`` has as an expression, Thomsen (41), (47): of Coulomb friction
    ``(2/pi) asin(v/q)`` for v < q, and 1 from there on.

    Examples
    --------
    >>> import symfric as sf
    >>> f"{sf.theory.plane.longitudinal_vibration_drag(1.0, 2.0):.12f}"
    '0.333333333333'
    """
    if law is not None:
        return _each(speed, intensity, lambda v, q: mean_along(law, v, q, law) if v else 0.0, law)
    v, q = _given(speed, intensity)
    ratio = np.divide(v, q, out=np.ones(v.shape), where=q > v)
    return _plain(np.where(q > v, 2 / np.pi * np.arcsin(ratio), np.sign(v)))


@spelt
def lateral_vibration_power(speed: Values, intensity: Values, law: Law | None = None) -> Any:
    r"""Return the mean power that maintains fast vibration across the sliding, over the normal load.

    Parameters
    ----------
    speed, intensity, law
        As in `lateral_vibration_drag`.

    Returns
    -------
    float or ndarray
        Coefficient of friction times speed.

    Raises
    ------
    SceneError
        If a number is negative or the law has symbols or memory.

    Notes
    -----
    :math:`\langle\mu(S)\,q^2\cos^2\theta/S\rangle`: what friction takes, ``<mu(S) S>``, less what the sliding brings.
    For weak vibration the damping ``mu/v`` of `transverse_damping`, times q^2/2. Of Coulomb friction ``(2/pi)(A E - v^2
    K/A)``, which Carlson's integral R_D gives without a difference.

    Examples
    --------
    >>> import symfric as sf
    >>> f"{sf.theory.plane.lateral_vibration_power(1.0, 0.01) / (0.01**2 / 2):.4f}"
    '1.0000'
    """
    from scipy.special import elliprd

    if law is not None:
        return _each(speed, intensity, lambda v, q: _power_across(law, v, q), law)
    v, q = _given(speed, intensity)
    total = np.hypot(v, q)
    with np.errstate(invalid="ignore", divide="ignore"):
        rest = (v / total) ** 2
        power = 2 / (3 * np.pi) * q * (q / total) * rest * elliprd(0.0, 1.0, rest)
    return _plain(np.where(q == 0, 0.0, np.where(rest < 1e-200, 2 / np.pi * q, power)))


@spelt
def longitudinal_vibration_power(speed: Values, intensity: Values, law: Law | None = None) -> Any:
    r"""Return the mean power that maintains fast vibration along the sliding, over the normal load.

    Parameters
    ----------
    speed, intensity, law
        As in `longitudinal_vibration_drag`.

    Returns
    -------
    float or ndarray
        Coefficient of friction times speed; negative where friction that falls with the speed drives the vibration.

    Raises
    ------
    SceneError
        If a number is negative or the law has symbols or memory.

    Notes
    -----
    :math:`\langle\operatorname{sgn}(w)\,\mu(|w|)\,q\cos\theta\rangle`; of Coulomb friction ``(2/pi) sqrt(q^2 -
    v^2)`` for v < q and 0 above, where the vibration costs nothing and changes nothing. For the cubic law see
    `sf.theory.belt.mean_power`.

    Examples
    --------
    >>> import symfric as sf
    >>> f"{sf.theory.plane.longitudinal_vibration_power(1.0, 2.0):.12f}"
    '1.102657790844'
    """
    if law is not None:
        return _each(speed, intensity, lambda v, q: _power_along(law, v, q), law)
    v, q = _given(speed, intensity)
    inside = np.maximum(q - v, 0.0) * (q + v)
    return _plain(2 / np.pi * np.sqrt(inside))


def _given(speed: Values, intensity: Values) -> tuple[np.ndarray, np.ndarray]:
    """Return speeds and intensities as arrays of one shape, none of them negative."""
    v, q = numbers_of(speed, "speed"), numbers_of(intensity, "intensity")
    for name, array in (("speed", v), ("intensity", q)):
        if not np.all((array >= 0) & np.isfinite(array)):
            raise SceneError(
                f"{name} is {array if array.ndim else float(array)}; give finite numbers that are not below 0"
            )
    try:
        v, q = np.broadcast_arrays(v, q)
    except ValueError:
        raise SceneError(f"speed has the shape {v.shape} and intensity {q.shape}; give shapes that broadcast") from None
    return v, q


def _plain(result: np.ndarray) -> Any:
    return result if result.ndim else float(result)


@alone(SYMBOLIC)
def _each(speed: Values, intensity: Values, of: _Of, law: Law) -> Any:
    """Return ``of(v, q)`` for every pair."""
    if not isinstance(law, Law):
        raise SceneError(f"law is {shortened(law)}; give one of sf.laws")
    v, q = _given(speed, intensity)
    law(0.0)  # raises if the law has symbols
    values = [of(float(a), float(b)) for a, b in zip(v.ravel(), q.ravel(), strict=True)]
    return _plain(np.array(values).reshape(v.shape))


def mean_across(law: Law, v: float, q: float, weight: _Weight, of: _Weight | None = None) -> float:
    """Return the mean of ``mu(S) weight(S)`` over theta for v > 0; with `of` in the place of mu, of the same breaks."""
    of = law if of is None else of
    if q == 0:
        return float(of(np.array(v))) * float(weight(np.array(v)))
    total = math.hypot(v, q)
    root = math.sqrt(v / total)
    reach = _FAR - math.log(root)
    marks = {-reach, reach}
    for b in (float(e) for e in law.breaks):
        if v < b < total:
            marks.add(0.5 * math.log((b - v) * (b + v) / ((total - b) * (total + b))) - math.log(root))
    edges = [m for m in sorted(marks) if -reach <= m <= reach]
    parts = [np.linspace(*piece, 2 + int(piece[1] - piece[0])) for piece in itertools.pairwise(edges)]
    x, weights = _panels(parts)
    t = root * np.exp(x)
    s = np.hypot(v, total * t) / np.hypot(1.0, t)
    return float(2 / np.pi * np.sum(weights * of(s) * weight(s) * t / (1 + t * t)))


def _drag_across(law: Law, v: float, q: float) -> float:
    return mean_across(law, v, q, lambda s: v / s) if v > 0 else 0.0


def _power_across(law: Law, v: float, q: float) -> float:
    if q == 0:
        return 0.0
    if v == 0:
        return _power_along(law, 0.0, q)
    return mean_across(law, v, q, lambda s: (s - v) * (s + v) / s)


def _power_along(law: Law, v: float, q: float) -> float:
    """Return the mean of ``sgn(w) mu(|w|) q cos theta``."""
    return mean_along(law, v, q, lambda w: law(w) * (w - v))


def mean_along(law: Law, v: float, q: float, of: _Weight) -> float:
    """Return the mean over theta of a function of ``w = v + q cos theta`` that breaks where the friction does."""
    if q == 0:
        return float(of(np.array(v)))
    levels = [0.0, *(s * float(b) for b in law.breaks for s in (-1, 1))]
    marks = sorted({0.0, math.pi, *(math.acos((w - v) / q) for w in levels if abs(w - v) < q)})
    parts = [low + (high - low) * _GRADED for low, high in itertools.pairwise(marks)]
    theta, weights = _panels(parts)
    w = (v - q) + 2 * q * np.cos(theta / 2) ** 2  # its sign is right, too, where it nearly vanishes
    return float(np.sum(weights * of(w)) / np.pi)


def _panels(parts: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of Gauss and Legendre between neighbouring edges of each part."""
    nodes, weights = gauss_legendre(_NODES)
    low = np.concatenate([edges[:-1] for edges in parts])
    width = np.concatenate([np.diff(edges) for edges in parts])
    return (low[:, None] + width[:, None] * nodes).ravel(), (width[:, None] * weights).ravel()
