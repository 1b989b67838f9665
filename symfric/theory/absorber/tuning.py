"""Optimal tuning and damping of a tuned mass damper for several criteria."""

from typing import Any, NamedTuple

import sympy as sp

from symfric.model.symbols import positive
from symfric.theory.absorber.response import SYMBOLS
from symfric.theory.closed_form import closed_form, needed


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


def _tuned(formulas: Tuned, mass_ratio: Any = None) -> Tuned:
    mu = sp.Rational(positive(needed(mass_ratio, "mass_ratio"), "mass_ratio"))  # exact: small ratios cancel
    return Tuned(*(float(sp.sympify(e).subs(SYMBOLS.mu, mu).evalf(17)) for e in formulas))


@closed_form(_tuned)
def fixed_points(mass_ratio: float | None = None, *, symbolic: bool = False) -> Tuned:
    """Return Den Hartog's tuning and damping; its value is the height of the two points that all dampings share.

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
    return Tuned(1 / (1 + mu), sp.sqrt(3 * mu / (8 * (1 + mu))), sp.sqrt((2 + mu) / mu))


@closed_form(_tuned)
def least_peak(mass_ratio: float | None = None, *, symbolic: bool = False) -> Tuned:
    r"""Return the tuning and damping of the least largest `response`, and that response: the exact H-infinity optimum.

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
    return Tuned(*(sp.sqrt(e) for e in (tuning, damping, height)))


@closed_form(_tuned)
def least_variance(mass_ratio: float | None = None, *, symbolic: bool = False) -> Tuned:
    """Return the tuning and damping of the least `variance`, and that variance: the H2 optimum.

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
    return Tuned(sp.sqrt((2 + mu) / 2) / (1 + mu), damping, value)


@closed_form(_tuned)
def fastest_decay(mass_ratio: float | None = None, *, symbolic: bool = False) -> Tuned:
    """Return the tuning and damping of the largest `decay_rate`, and that rate over omega1.

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
    return Tuned(*formulas)


@closed_form(_tuned)
def widest_stability(mass_ratio: float | None = None, *, symbolic: bool = False) -> Tuned:
    """Return the tuning and damping that stabilise the largest negative damping of the main mass, and that damping.

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
    return Tuned(1 / w, sp.sqrt((w - 1) / (2 * w)), sp.sqrt(w * (w - 1) / 2))
