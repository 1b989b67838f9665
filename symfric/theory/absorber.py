"""Tuned mass damper on an undamped main mass: response, and optimal tuning and damping for several criteria.

One main mass on a spring, omega1 = 1; on it a mass ``mu`` times as large, on a spring tuned to ``f = omega2/omega1``
and a damper ``zeta = c2/(2 m2 omega2)``. Every formula is proved in derivations/absorber.py.
"""

from typing import NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.offering import offer
from symfric.model.symbols import finite

__all__ = [
    "SYMBOLS",
    "AbsorberSymbols",
    "Tuned",
    "decay_rate",
    "fastest_decay",
    "fixed_points",
    "least_peak",
    "least_variance",
    "peaks",
    "response",
    "state_matrix",
    "variance",
    "widest_stability",
]


class AbsorberSymbols(NamedTuple):
    """Symbols of the formulas.

    Attributes
    ----------
    mu, f, zeta, g : Symbol
        Mass ratio, tuning, damping ratio, frequency over that of the main mass.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.absorber.SYMBOLS.f
    f
    """

    mu: sp.Symbol
    f: sp.Symbol
    zeta: sp.Symbol
    g: sp.Symbol


class Tuned(NamedTuple):
    """A tuning, a damping, and the value of the criterion that they reach; numbers or formulas.

    Attributes
    ----------
    tuning : float or Expr
        ``omega2/omega1``.
    damping : float or Expr
        ``c2/(2 m2 omega2)``.
    value : float or Expr

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.absorber.fixed_points(0.1).damping, 6)
    0.184637
    """

    tuning: float | sp.Expr
    damping: float | sp.Expr
    value: float | sp.Expr


#: Symbols of the tuned mass damper: mass ratio mu, tuning f, damping ratio zeta, frequency ratio g.
SYMBOLS = AbsorberSymbols(*sp.symbols("mu f zeta g", positive=True))
# relative imaginary part up to which a root counts as real, because rounding splits double roots
_REAL = 1e-7


@alone(SYMBOLIC)
def response(mass_ratio=None, tuning=None, damping=None, g=None, *, symbolic: bool = False):
    r"""Return the amplitude ``|x1 k1/F|`` of the main mass under a harmonic force of frequency g = Omega/omega1.

    Parameters
    ----------
    mass_ratio, tuning, damping : float
    g : float or array_like
    symbolic : bool
        Return the formula in `SYMBOLS`.

    Returns
    -------
    float or Expr

    Notes
    -----
    .. math:: \left|\frac{x_1 k_1}{F}\right|^2 = \frac{(f^2-g^2)^2 + (2\zeta f g)^2}
        {[(1-g^2)(f^2-g^2) - \mu f^2 g^2]^2 + (2\zeta f g)^2 (1 - g^2 - \mu g^2)^2}

    Den Hartog, *Mechanical Vibrations*, section 3.3.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.absorber.response(0.1, 0.909, 0.185, 1.0), 6)
    4.243258
    """
    if symbolic:
        mu, f, zeta, g = SYMBOLS
        return sp.sqrt(_squares(mu, f, zeta, g)[0] / _squares(mu, f, zeta, g)[1])
    above, below = _squares(*_given(mass_ratio, tuning, damping), np.asarray(g, dtype=float))
    with np.errstate(divide="ignore"):
        result = np.sqrt(above / below)
    return result if result.ndim else float(result)


def peaks(mass_ratio: float, tuning: float, damping: float) -> tuple[tuple[float, float], ...]:
    """Return frequency g and height of every peak of `response`, the highest first: it is the H-infinity norm.

    Parameters
    ----------
    mass_ratio : float
        ``m2/m1`` > 0.
    tuning : float
        ``omega2/omega1``.
    damping : float
        ``c2/(2 m2 omega2)``.

    Returns
    -------
    tuple of (float, float)

    Notes
    -----
    No frequency is sampled: the extrema are the roots of a polynomial of degree 5 in g^2. Without damping the two peaks
    are infinite.

    Examples
    --------
    >>> import symfric as sf
    >>> [(round(g, 4), round(h, 4)) for g, h in sf.theory.absorber.peaks(0.1, 0.909, 0.185)]
    [(1.0589, 4.5915), (0.8481, 4.587)]
    """
    mu, f, zeta = _given(mass_ratio, tuning, damping)
    # g^2 = middle + size t: near 1 for small masses, where the peaks are close together
    middle, size, apart = (1.0, np.sqrt(mu), (f - 1) * (f + 1)) if mu < 1 else (0.0, 1.0, f**2)
    shift = np.polynomial.Polynomial([0.0, size])
    main, off = 1 - middle - shift, apart - shift  # 1 - g^2 and f^2 - g^2
    rigid = main * off - mu * f**2 * (middle + shift)
    if zeta == 0:
        return tuple((float(np.sqrt(middle + size * t)), np.inf) for t in np.sort(rigid.roots()))
    damper = (2 * zeta * f) ** 2 * (middle + shift)
    above, below = off**2 + damper, rigid**2 + damper * (main - mu * (middle + shift)) ** 2
    slope = above.deriv() * below - above * below.deriv()
    all_roots = np.asarray(slope.roots(), dtype=complex)
    roots = [float(t.real) for t in all_roots if abs(t.imag) <= _REAL * abs(t)]
    found = [t for t in roots if slope.deriv()(t) < 0 and middle + size * t > 0]
    rest = -middle / size
    found = [*found, rest] if slope(rest) < 0 or not found else found
    heights = ((float(np.sqrt(middle + size * t)), float(np.sqrt(above(t) / below(t)))) for t in found)
    return tuple(sorted(heights, key=lambda p: -p[1]))


def variance(mass_ratio: float, tuning: float, damping: float) -> float:
    """Return the mean square of x1 under white noise of unit intensity as the force: the squared H2 norm.

    Parameters
    ----------
    mass_ratio : float
        ``m2/m1`` > 0.
    tuning : float
        ``omega2/omega1``.
    damping : float
        ``c2/(2 m2 omega2)``.

    Returns
    -------
    float

    Notes
    -----
    ``int_0^oo h^2 dt`` of the response h to a unit impulse, from the Lyapunov equation of the state space; infinite
    without damping.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.absorber.variance(0.1, 0.909, 0.185), 6)
    3.201548
    """
    from scipy.linalg import solve_continuous_lyapunov

    mu, f, zeta = _given(mass_ratio, tuning, damping)
    if zeta == 0:
        return np.inf
    push = np.array([0.0, 0.0, 1.0, 0.0])
    return float(solve_continuous_lyapunov(state_matrix(mu, f, zeta), -np.outer(push, push))[0, 0])


def decay_rate(mass_ratio: float, tuning: float, damping: float, main_damping: float = 0.0) -> float:
    """Return the decay rate of free vibration over omega1: the largest real part of an eigenvalue, negated.

    `main_damping` is ``c1/(2 m1 omega1)``, negative for a main mass that excites itself. Where eigenvalues coincide
    they are known to half the digits.

    Parameters
    ----------
    mass_ratio : float
        ``m2/m1`` > 0.
    tuning : float
        ``omega2/omega1``.
    damping : float
        ``c2/(2 m2 omega2)``.
    main_damping : float
        ``c1/(2 m1 omega1)``.

    Returns
    -------
    float

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.absorber.decay_rate(0.1, 0.909, 0.185), 6)
    0.081015
    """
    matrix = state_matrix(*_given(mass_ratio, tuning, damping), finite(main_damping, "main_damping"))
    return -float(np.max(np.linalg.eigvals(matrix).real))


def state_matrix(mu: float, f: float, zeta: float, main_damping: float = 0.0) -> np.ndarray:
    """Return the matrix of ``d/dt (x1, x2, u1, u2)``, time in units of 1/omega1.

    Parameters
    ----------
    mu, f, zeta : float
        Mass ratio, tuning, damping ratio of the absorber.
    main_damping : float
        ``c1/(2 m1 omega1)``.

    Returns
    -------
    ndarray, shape (4, 4)

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.absorber.state_matrix(0.1, 0.9, 0.2).shape
    (4, 4)
    """
    spring, damper = f**2 * np.array([[-mu, mu], [1, -1]]), 2 * zeta * f * np.array([[-mu, mu], [1, -1]])
    spring[0, 0] -= 1.0
    damper[0, 0] -= 2 * main_damping
    return np.block([[np.zeros((2, 2)), np.eye(2)], [spring, damper]])


@alone(SYMBOLIC)
def fixed_points(mass_ratio=None, *, symbolic: bool = False) -> Tuned:
    """Return Den Hartog's tuning and damping; its value is the height of the two points that all dampings share.

    Parameters
    ----------
    mass_ratio : float, optional
        ``m2/m1`` > 0.
    symbolic : bool
        Return the formula in `SYMBOLS` instead of a number.

    Returns
    -------
    Tuned

    Notes
    -----
    ``f = 1/(1+mu)``, ``zeta^2 = 3 mu/(8 (1+mu))``, ``sqrt((2+mu)/mu)``: the tuning makes the fixed points equally high,
    the damping is the root mean square of the two that make one of them a peak. The true peak is a little higher, see
    `peaks`; the least one possible is `least_peak`. Den Hartog, *Mechanical Vibrations*, (3.27) to (3.30).

    Examples
    --------
    >>> import symfric as sf
    >>> best = sf.theory.absorber.fixed_points(0.1)
    >>> round(best.tuning, 6)
    0.909091
    >>> round(best.damping, 6)
    0.184637
    """
    mu = SYMBOLS.mu
    return _result(mass_ratio, symbolic, 1 / (1 + mu), sp.sqrt(3 * mu / (8 * (1 + mu))), sp.sqrt((2 + mu) / mu))


@alone(SYMBOLIC)
def least_peak(mass_ratio=None, *, symbolic: bool = False) -> Tuned:
    r"""Return the tuning and damping of the least largest `response`, and that response: the exact H-infinity optimum.

    Parameters
    ----------
    mass_ratio : float, optional
        ``m2/m1`` > 0.
    symbolic : bool
        Return the formula in `SYMBOLS` instead of a number.

    Returns
    -------
    Tuned

    Notes
    -----
    With :math:`w = \sqrt{4+3\mu}`

    .. math:: f^2 = \frac{8\,[16+23\mu+9\mu^2+2(2+\mu)w]}{3(1+\mu)^2(64+80\mu+27\mu^2)},\quad
        \zeta^2 = \frac{8+9\mu-4w}{16(1+\mu)},\quad
        h^2 = \frac{(8+9\mu)^2(16+9\mu)-128\,w^3}{27\mu^2(32+27\mu)}

    O. Nishihara and T. Asami, J. Vib. Acoust. 124 (2002) 576-582. Both peaks are equal, and along the curve of equal
    peaks h is stationary.

    Examples
    --------
    >>> import symfric as sf
    >>> best = sf.theory.absorber.least_peak(0.1)
    >>> round(best.tuning, 6)
    0.909058
    >>> round(best.damping, 6)
    0.18547
    """
    mu = SYMBOLS.mu
    w = sp.sqrt(4 + 3 * mu)
    tuning = 8 * (16 + 23 * mu + 9 * mu**2 + 2 * (2 + mu) * w) / (3 * (1 + mu) ** 2 * (64 + 80 * mu + 27 * mu**2))
    damping = (8 + 9 * mu - 4 * w) / (16 * (1 + mu))
    height = ((8 + 9 * mu) ** 2 * (16 + 9 * mu) - 128 * w**3) / (27 * mu**2 * (32 + 27 * mu))
    return _result(mass_ratio, symbolic, *(sp.sqrt(e) for e in (tuning, damping, height)))


@alone(SYMBOLIC)
def least_variance(mass_ratio=None, *, symbolic: bool = False) -> Tuned:
    """Return the tuning and damping of the least `variance`, and that variance: the H2 optimum.

    Parameters
    ----------
    mass_ratio : float, optional
        ``m2/m1`` > 0.
    symbolic : bool
        Return the formula in `SYMBOLS` instead of a number.

    Returns
    -------
    Tuned

    Notes
    -----
    ``f = sqrt((2+mu)/2)/(1+mu)``, ``zeta^2 = mu (4+3 mu)/(8 (1+mu)(2+mu))``, ``J = sqrt((4+3 mu)/(mu (1+mu)))/2``:
    G. B. Warburton, Earthquake Eng. Struct. Dyn. 10 (1982) 381-401; T. Asami et al., J. Vib. Acoust. 124 (2002) 284.

    Examples
    --------
    >>> import symfric as sf
    >>> best = sf.theory.absorber.least_variance(0.1)
    >>> round(best.tuning, 6)
    0.931541
    >>> round(best.damping, 6)
    0.15254
    """
    mu = SYMBOLS.mu
    damping = sp.sqrt(mu * (4 + 3 * mu) / (8 * (1 + mu) * (2 + mu)))
    value = sp.sqrt((4 + 3 * mu) / (mu * (1 + mu))) / 2
    return _result(mass_ratio, symbolic, sp.sqrt((2 + mu) / 2) / (1 + mu), damping, value)


@alone(SYMBOLIC)
def fastest_decay(mass_ratio=None, *, symbolic: bool = False) -> Tuned:
    """Return the tuning and damping of the largest `decay_rate`, and that rate over omega1.

    Parameters
    ----------
    mass_ratio : float, optional
        ``m2/m1`` > 0.
    symbolic : bool
        Return the formula in `SYMBOLS` instead of a number.

    Returns
    -------
    Tuned

    Notes
    -----
    Up to mu = 4 both pairs of eigenvalues coincide: ``f = 1/(1+mu)``, ``zeta = sqrt(mu/(1+mu))``, rate ``zeta/2``.
    Above, three real ones do, at ``-s``; with ``y = 2 sqrt(mu) cos((acos(-2/sqrt(mu)) - 2 pi)/3)``, a root of
    ``y^3 - 3 mu y + 4 mu``, it is ``s^2 = (y-1)/(1+mu)``, and the fourth lies at ``-s (4-y)/(3 y-4)``.

    Examples
    --------
    >>> import symfric as sf
    >>> best = sf.theory.absorber.fastest_decay(0.1)
    >>> round(best.tuning, 6)
    0.909091
    >>> round(best.damping, 6)
    0.301511
    """
    mu = SYMBOLS.mu
    y = 2 * sp.sqrt(mu) * sp.cos((sp.acos(-2 / sp.sqrt(mu)) - 2 * sp.pi) / 3)
    s, ratio = sp.sqrt((y - 1) / (1 + mu)), (4 - y) / (3 * y - 4)
    triple = s**2 * sp.sqrt(ratio), s * (1 + 3 * ratio) / (2 * sp.sqrt(ratio)), s
    pairs = 1 / (1 + mu), sp.sqrt(mu / (1 + mu)), sp.sqrt(mu / (1 + mu)) / 2
    formulas = (sp.Piecewise((p, mu <= 4), (t, True)) for p, t in zip(pairs, triple, strict=True))
    return _result(mass_ratio, symbolic, *formulas)


@alone(SYMBOLIC)
def widest_stability(mass_ratio=None, *, symbolic: bool = False) -> Tuned:
    """Return the tuning and damping that stabilise the largest negative damping of the main mass, and that damping.

    Parameters
    ----------
    mass_ratio : float, optional
        ``m2/m1`` > 0.
    symbolic : bool
        Return the formula in `SYMBOLS` instead of a number.

    Returns
    -------
    Tuned
        The value is the least upper bound of ``-c1/(2 m1 omega1)``: an absorber as near to this one as one likes
        stabilises a main mass that lies as little below it. At the bound itself the eigenvalues are imaginary.

    Notes
    -----
    With ``w = sqrt(1+mu)``: ``f = 1/w``, ``zeta^2 = (w-1)/(2 w)``, bound ``sqrt(w (w-1)/2)``, where both pairs of
    eigenvalues meet on the imaginary axis.

    Examples
    --------
    >>> import symfric as sf
    >>> best = sf.theory.absorber.widest_stability(0.1)
    >>> round(best.tuning, 6)
    0.953463
    >>> round(best.damping, 6)
    0.152541
    """
    w = sp.sqrt(1 + SYMBOLS.mu)
    return _result(mass_ratio, symbolic, 1 / w, sp.sqrt((w - 1) / (2 * w)), sp.sqrt(w * (w - 1) / 2))


def _squares(mu, f, zeta, g):
    """Return numerator and denominator of the squared response."""
    damper = (2 * zeta * f * g) ** 2
    above = (f**2 - g**2) ** 2 + damper
    below = ((1 - g**2) * (f**2 - g**2) - mu * f**2 * g**2) ** 2 + damper * (1 - (1 + mu) * g**2) ** 2
    return above, below


def _result(mass_ratio, symbolic: bool, *formulas: sp.Expr) -> Tuned:
    if symbolic:
        return Tuned(*formulas)
    mu = sp.Rational(_positive(mass_ratio, "mass_ratio"))  # exact, to avoid cancellation for small mu
    return Tuned(*(float(e.subs(SYMBOLS.mu, mu).evalf(17)) for e in formulas))


def _given(mass_ratio, tuning, damping) -> tuple[float, float, float]:
    zeta = finite(damping, "damping")
    if zeta < 0:
        raise SceneError(f"damping is {zeta:g}; it must not be negative")
    return _positive(mass_ratio, "mass_ratio"), _positive(tuning, "tuning"), zeta


def _positive(value, name: str) -> float:
    if value is None:
        raise SceneError(f"no {name}; give a number, or ask for the formula with symbolic=True")
    number = finite(value, name)
    if not number > 0:
        raise SceneError(f"{name} is {number:g}; it must be positive")
    return number


offer(__name__)
