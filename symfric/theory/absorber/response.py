"""Tuned mass damper on an undamped main mass: harmonic response, mean square under noise, decay rate."""

from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from symfric.model.symbols import finite, numbers_of, positive
from symfric.spelling import spelt
from symfric.theory.closed_form import closed_form, needed


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


#: Symbols of the tuned mass damper: mass ratio mu, tuning f, damping ratio zeta, frequency ratio g.
SYMBOLS = AbsorberSymbols(*sp.symbols("mu f zeta g", positive=True))
# relative imaginary part up to which a root counts as real, because rounding splits double roots
_REAL = 1e-7


def _squares(mu: Any, f: Any, zeta: Any, g: Any) -> tuple[Any, Any]:
    """Return numerator and denominator of the squared response."""
    damper = (2 * zeta * f * g) ** 2
    above = (f**2 - g**2) ** 2 + damper
    below = ((1 - g**2) * (f**2 - g**2) - mu * f**2 * g**2) ** 2 + damper * (1 - (1 + mu) * g**2) ** 2
    return above, below


def _given(mass_ratio: Any, tuning: Any, damping: Any) -> tuple[float, float, float]:
    zeta = positive(damping, "damping", zero=True)
    return _ratio(mass_ratio, "mass_ratio"), _ratio(tuning, "tuning"), zeta


def _ratio(value: Any, name: str) -> float:
    return positive(needed(value, name), name)


def _amplitude(_: sp.Expr, mass_ratio: Any = None, tuning: Any = None, damping: Any = None, g: Any = None) -> Any:
    """Return the response in numbers, by the formula in NumPy."""
    above, below = _squares(*_given(mass_ratio, tuning, damping), numbers_of(g, "g"))
    with np.errstate(divide="ignore"):
        result = np.sqrt(above / below)
    return result if result.ndim else float(result)


@closed_form(_amplitude)
def response(
    mass_ratio: float | None = None,
    tuning: float | None = None,
    damping: float | None = None,
    g: Any = None,
    *,
    symbolic: bool = False,
) -> Any:
    r"""Return the amplitude ``|x1 k1/F|`` of the main mass under a harmonic force of frequency g = Omega/omega1.

    Parameters
    ----------
    mass_ratio, tuning, damping : float
        As in `peaks`.
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
    above, below = _squares(*SYMBOLS)
    return sp.sqrt(above / below)


@spelt
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
    places = [t for t in roots if slope.deriv()(t) < 0 and middle + size * t > 0]
    rest = -middle / size
    places = [*places, rest] if slope(rest) < 0 or not places else places
    heights = ((float(np.sqrt(middle + size * t)), float(np.sqrt(above(t) / below(t)))) for t in places)
    return tuple(sorted(heights, key=lambda p: -p[1]))


@spelt
def variance(mass_ratio: float, tuning: float, damping: float) -> float:
    """Return the mean square of x1 under white noise of unit intensity as the force: the squared H2 norm.

    Parameters
    ----------
    mass_ratio, tuning, damping : float
        As in `peaks`.

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


@spelt
def decay_rate(mass_ratio: float, tuning: float, damping: float, main_damping: float = 0.0) -> float:
    """Return the decay rate of free vibration over omega1: the largest real part of an eigenvalue, negated.

    `main_damping` is ``c1/(2 m1 omega1)``, negative for a main mass that excites itself. Where eigenvalues coincide
    they are known to half the digits.

    Parameters
    ----------
    mass_ratio, tuning, damping : float
        As in `peaks`.
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


@spelt
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
    mu, f, zeta = finite(mu, "mu"), finite(f, "f"), finite(zeta, "zeta")
    main_damping = finite(main_damping, "main_damping")
    spring, damper = f**2 * np.array([[-mu, mu], [1, -1]]), 2 * zeta * f * np.array([[-mu, mu], [1, -1]])
    spring[0, 0] -= 1.0
    damper[0, 0] -= 2 * main_damping
    return np.block([[np.zeros((2, 2)), np.eye(2)], [spring, damper]])
