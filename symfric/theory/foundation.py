"""Sprung foundation mass under a main mass that excites itself: how much it stabilises, and with what mount.

The main mass stands with its spring, omega1 = 1, on a foundation ``mu`` times as heavy, which a mount of stiffness
``kappa = k2/k1`` and damping ``gamma = c2/(2 m1 omega1)`` holds to the ground. Every formula is proved in
derivations/foundation.py.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import sympy as sp

from symfric.locks import SYMBOLIC, alone
from symfric.model.public_names import names_of
from symfric.model.symbols import finite, positive
from symfric.search import zero
from symfric.spelling import spelt
from symfric.theory.closed_form import closed_form, needed

__all__ = [
    "SYMBOLS",
    "Mount",
    "Symbols",
    "at_stiffness",
    "break_even",
    "decay_rate",
    "state_matrix",
    "widest_stability",
]


class Symbols(NamedTuple):
    """Letters of the formulas.

    Attributes
    ----------
    mu, kappa, gamma : Symbol
        Ratio of the masses, stiffness and damping of the mount.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.foundation.SYMBOLS.kappa
    kappa
    """

    mu: sp.Symbol
    kappa: sp.Symbol
    gamma: sp.Symbol


class Mount(NamedTuple):
    """A mount, and the value of the criterion that it reaches; numbers or formulas.

    Attributes
    ----------
    stiffness : float or Expr
        ``k2/k1``.
    damping : float or Expr
        ``c2/(2 m1 omega1)``.
    value : float or Expr

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.foundation.widest_stability(0.2).stiffness, 6)
    0.0
    """

    stiffness: float | sp.Expr
    damping: float | sp.Expr
    value: float | sp.Expr


IN_TUNE = 1e-12  # distance of d from 1 that is rounding
#: Symbols of the formulas: ratio of the masses mu, stiffness kappa and damping gamma of the mount.
SYMBOLS = Symbols(*sp.symbols("mu kappa gamma", positive=True))


def _widest(formulas: Mount, mass_ratio: float | None = None, *, least_stiffness: float = 0.0) -> Mount:
    ratio, least = _ratio(mass_ratio), positive(least_stiffness, "least_stiffness", zero=True)
    free = Mount(*(float(sp.sympify(e).subs(SYMBOLS.mu, sp.Rational(ratio)).evalf(17)) for e in formulas))
    return free if least <= free.stiffness else at_stiffness(ratio, least)


def _ratio(mass_ratio: float | None) -> float:
    return positive(needed(mass_ratio, "mass_ratio"), "mass_ratio")


@closed_form(_widest)
def widest_stability(mass_ratio: float | None = None, *, least_stiffness: float = 0.0, symbolic: bool = False) -> Mount:
    r"""Return how much negative damping of the main mass a sprung foundation can stabilise, and with what mount.

    Parameters
    ----------
    mass_ratio : float
        ``m2/m1`` > 0.
    least_stiffness : float
        Smallest stiffness ``k2/k1`` >= 0 that the mount may have; what stands on it must not sag.
    symbolic : bool
        Return the formulas in `SYMBOLS`, for any stiffness.

    Returns
    -------
    Mount
        The value is the least upper bound of ``-c1/(2 m1 omega1)``: a mount as near to this one as one likes stabilises
        a main mass that lies as little below it. At the bound itself eigenvalues are imaginary or zero.

    Raises
    ------
    SceneError
        If a number is missing or out of range.

    Notes
    -----
    For a heavy foundation, mu >= 1, the best stiffness is ``kappa = mu - 1``: foundation and main mass, each with the
    other one held, are in tune, both pairs of eigenvalues meet on the imaginary axis, and the bound is ``sqrt((1 -
    sqrt(1 - 1/mu))/2)``, with the damping mu times as large. For a light one, mu <= 1, no spring at all is best: the
    bound is ``sqrt(1 + mu)/2``, the damping as large. A stiffness above these costs some of it. With ``1 - p`` the
    squared frequency at the limit, the bound is the largest ``sqrt(B)/2`` of

    .. math:: B(p) = \frac{p\,\big(1 - p\,\mu\,(d - 1 + p)\big)}{\mu\,(d - 1 + p)(1 - p)},
        \qquad d = \frac{1 + \kappa}{\mu} > 1,\quad 0 < p < 1.

    Tondl's second device in the introduction of Thomsen; the first one is `symfric.theory.absorber`.

    Examples
    --------
    >>> import symfric as sf
    >>> mount = sf.theory.foundation.widest_stability(0.1)
    >>> f"{mount.stiffness:g} {mount.damping:.6f} {mount.value:.6f}"
    '0 0.524404 0.524404'
    """
    mu = SYMBOLS.mu
    heavy = sp.sqrt((1 - sp.sqrt(1 - 1 / mu)) / 2)
    return Mount(
        sp.Piecewise((mu - 1, mu >= 1), (0, True)),
        sp.Piecewise((mu * heavy, mu >= 1), (sp.sqrt(1 + mu) / 2, True)),
        sp.Piecewise((heavy, mu >= 1), (sp.sqrt(1 + mu) / 2, True)),
    )


@spelt
def at_stiffness(mass_ratio: float, stiffness: float) -> Mount:
    """Return the damping of a mount of given stiffness that stabilises the most, and how much that is.

    Parameters
    ----------
    mass_ratio : float
        ``m2/m1`` > 0.
    stiffness : float
        ``k2/k1`` >= 0.

    Returns
    -------
    Mount
        The value is the least upper bound of ``-c1/(2 m1 omega1)``.

    Raises
    ------
    SceneError
        If an argument is out of range.

    Notes
    -----
    The stationary points of B(p) in `widest_stability`, roots of a polynomial of degree 3; where ``d < 1``, the
    vibration is faster than the main mass alone and p negative. With ``b = 2 value`` and the frequency ``sqrt(1-p)`` at
    the limit the damping is ``gamma = mu b (d - 1 + p)/(2 p)``. Exactly in tune, ``d = 1``, the frequency at the limit
    is 1 whatever the damping, and the bound is ``sqrt(1/mu)/2``, to which softer mounts tend. It jumps there: a little
    above, a narrow range of dampings stabilises more. Without a spring, ``kappa = 0``, nothing holds the place of the
    two masses, an eigenvalue is zero, and the value is that of a very soft spring.

    Examples
    --------
    >>> import symfric as sf
    >>> mount = sf.theory.foundation.at_stiffness(0.1, 0.2)
    >>> f"{mount.damping:.6f} {mount.value:.6f}"
    '0.601405 0.313516'
    """
    mu, kappa = _ratio(mass_ratio), positive(stiffness, "stiffness", zero=True)
    e, d = 1 / mu, (1 + kappa) / mu
    if abs(d - 1) < IN_TUNE:
        return Mount(kappa, float(np.sqrt(mu) / 2), float(np.sqrt(e) / 2))
    if kappa == 0 and mu < 1:
        return Mount(0.0, float(np.sqrt(1 + mu) / 2), float(np.sqrt(1 + mu) / 2))  # at the end p = 1 of its range
    t = np.polynomial.Polynomial([d - 1, 1.0])
    p_ = np.polynomial.Polynomial([0.0, 1.0])
    above, below = p_ * (e - p_ * t), t * (1 - p_)
    slope = above.deriv() * below - above * below.deriv()
    stationary = [float(r.real) for r in np.atleast_1d(slope.roots()) if abs(r.imag) < 1e-9 * (1 + abs(r))]
    low, high = (0.0, 1.0) if d > 1 else (-np.inf, 0.0)
    best = max((above(p) / below(p), p) for p in stationary if low < p < high and above(p) / below(p) > 0)
    b, p = float(np.sqrt(best[0])), best[1]
    return Mount(kappa, mu * b * (d - 1 + p) / (2 * p), b / 2)


@alone(SYMBOLIC)
def break_even() -> float:
    """Return the mass ratio at which an absorber and a sprung foundation of equal mass stabilise equally much.

    Returns
    -------
    float
        Dimensionless.

    Notes
    -----
    The root of ``w (w - 1) = 1 - sqrt(1 - 1/mu)`` with ``w = sqrt(1 + mu)``, about 1.12; below it the foundation does
    more, far more where both are light, above it the absorber. Proved in derivations/foundation.py.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.foundation.break_even(), 6)
    1.124677
    """

    def gap(mu: float) -> float:
        w = np.sqrt(1 + mu)
        return float(w * (w - 1) - 1 + np.sqrt(1 - 1 / mu))

    return zero(gap, 1.0, 10.0, xtol=1e-15)


@spelt
def decay_rate(mass_ratio: float, stiffness: float, damping: float, main_damping: float = 0.0) -> float:
    """Return the decay rate of free vibration over omega1: the largest real part of an eigenvalue, negated.

    Parameters
    ----------
    mass_ratio, stiffness, damping : float
        ``m2/m1`` > 0, ``k2/k1`` and ``c2/(2 m1 omega1)`` of the mount.
    main_damping : float
        ``c1/(2 m1 omega1)`` of the main mass to the ground, negative where it excites itself.

    Returns
    -------
    float
        Over omega1; negative if a vibration grows.

    Raises
    ------
    SceneError
        If an argument is out of range.

    Notes
    -----
    Eigenvalues of `state_matrix`; its characteristic polynomial is derived in derivations/foundation.py.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.foundation.decay_rate(0.1, 0.2, 0.372, -0.2), 6)
    0.061139
    """
    return -float(np.max(np.linalg.eigvals(state_matrix(mass_ratio, stiffness, damping, main_damping)).real))


@spelt
def state_matrix(mass_ratio: float, stiffness: float, damping: float, main_damping: float = 0.0) -> np.ndarray:
    """Return the matrix of ``d/dt (x1, x2, u1, u2)``, time in units of 1/omega1.

    Parameters
    ----------
    mass_ratio, stiffness, damping, main_damping : float
        As in `decay_rate`.

    Returns
    -------
    ndarray, shape (4, 4)
        Dimensionless.

    Notes
    -----
    The equations of `symfric.scenes.sprung_foundation` without friction.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.foundation.state_matrix(0.5, 1.0, 0.25)[3].tolist()
    [2.0, -4.0, 0.0, -1.0]
    """
    mu, stiffness, damping = _ratio(mass_ratio), finite(stiffness, "stiffness"), finite(damping, "damping")
    main_damping = finite(main_damping, "main_damping")
    spring = np.array([[-1.0, 1.0], [1 / mu, -(1 + stiffness) / mu]])
    damper = np.diag([-2 * main_damping, -2 * damping / mu])
    return np.block([[np.zeros((2, 2)), np.eye(2)], [spring, damper]])


if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
