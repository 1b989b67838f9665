"""Linear stability of steady sliding of two slides in contact, Guida (23)-(27)."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import flag, is_one_of
from symfric.model.results import Result
from symfric.model.scenes.slides import READINGS
from symfric.model.symbols import positive, shortened


class SlidesSymbols(NamedTuple):
    """Symbols of the closed forms: mass and frequency ratio, damping ratios over omega1, slope of the friction."""

    r: sp.Symbol
    zeta: sp.Symbol
    s1: sp.Symbol
    d2: sp.Symbol
    mu: sp.Symbol


#: Symbols of the formulas for two slides: ratio of masses r, zeta, damping ratios s1 and d2, and the slope mu.
SYMBOLS = SlidesSymbols(*sp.symbols("r zeta s1 d2", positive=True), *sp.symbols("mu,", real=True))
r, zeta, s1, d2, mu = SYMBOLS
FIRST, SECOND = 2 * (s1 + mu), 2 * (d2 + r * mu)  # diagonal of B
DEFINITE = 4 * (s1 * d2 + mu * (r * s1 + d2))  # determinant of the unsymmetric B
STIFF = FIRST / zeta**2 + SECOND  # coefficient of s; FIRST + SECOND is that of s^3
HURWITZ = (FIRST + SECOND) * STIFF * DEFINITE + (1 - 1 / zeta**2) ** 2 * FIRST * SECOND


@dataclass(frozen=True, repr=False)
class SlopeLimits(Result):
    """Limits of the slope of the friction law for stable steady sliding of two slides.

    Attributes
    ----------
    definite : float
        mu above which the damping is positive definite: enough for stability.
    exact : float
        mu above which every eigenvalue has a negative real part; not above `definite`.

    Examples
    --------
    >>> import symfric as sf
    >>> pair = dict(r=0.5, zeta=2, s1=0.2, s2=0.3)
    >>> round(sf.theory.drive.slope_limits(**pair).to_dict()["definite"], 6)
    -0.15
    """

    definite: float
    exact: float

    def __repr__(self) -> str:
        return f"SlopeLimits(definite {self.definite:.6g}, exact {self.exact:.6g})"


@alone(SYMBOLIC)
def damping_matrix(*, symmetric: bool = True) -> sp.Matrix:
    """Return B of ``M eta'' + B eta' + K eta = 0`` in `SYMBOLS`, Guida (26).

    Parameters
    ----------
    symmetric : bool
        The second equation divided by r, so that M = diag(1, 1/r) and B is symmetric; otherwise M is the unit matrix,
        as (24) is written.

    Returns
    -------
    Matrix, shape (2, 2)

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.drive.damping_matrix()
    Matrix([
    [2*mu + 2*s1,             -2*mu],
    [      -2*mu, (2*d2 + 2*mu*r)/r]])
    """
    second = 1 / r if flag(symmetric, "symmetric") else sp.Integer(1)
    return sp.Matrix([[FIRST, -2 * mu], [-2 * r * mu * second, SECOND * second]])


@alone(SYMBOLIC)
def definite_condition() -> sp.Expr:
    """Return r times the determinant of the symmetric B in `SYMBOLS`.

    Returns
    -------
    Expr

    Notes
    -----
    ``4 (s1 d2 + mu (r s1 + d2))``: for mu < 0 it is positive exactly if B is positive definite. As a bound on mu it is
    Guida (27), ``s1 d2/(r s1 + d2) > -mu``.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.drive.definite_condition()
    4*d2*s1 + 4*mu*(d2 + r*s1)
    """
    return DEFINITE


@alone(SYMBOLIC)
def hurwitz_conditions() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return three expressions in `SYMBOLS`, all positive if and only if steady sliding is stable.

    Returns
    -------
    tuple of Expr

    Notes
    -----
    ``B11 + B22``, ``k B11 + B22`` and ``(B11 + B22)(k B11 + B22) D + (1 - k)^2 B11 B22`` with k = 1/zeta^2 and D of
    `definite_condition`: Routh-Hurwitz in the form of Lienard and Chipart. Proved in derivations/guida.

    Examples
    --------
    >>> import symfric as sf
    >>> len(sf.theory.drive.hurwitz_conditions())
    3
    """
    return FIRST + SECOND, STIFF, HURWITZ


@alone(SYMBOLIC)
def slope_limits(*, r: float, zeta: float, s1: float, s2: float, damping: str = "omega1") -> SlopeLimits:
    """Return the slopes of friction for the sufficient and for the exact condition of stable steady sliding.

    Parameters
    ----------
    r, zeta : float
        ``m1/m2`` and ``omega1/omega2``, positive.
    s1, s2 : float
        Damping ratios, positive.
    damping : {"omega1", "omega2"}
        What s2 refers to: with "omega1" it stands in the equations of motion as it is, ``d2 = s2``, as the source
        writes (24) and draws its figures; with "omega2", as (23) defines it, ``d2 = s2/zeta``.

    Returns
    -------
    SlopeLimits
        In ``mu = (dF/dw)/(2 m1 omega1)``; steady sliding is stable above `exact`.

    Notes
    -----
    Largest negative zeros of `definite_condition` and of any of `hurwitz_conditions`; all are positive at mu = 0.

    Examples
    --------
    >>> import symfric as sf
    >>> pair = dict(r=0.5, zeta=2, s1=0.2, s2=0.3)
    >>> limits = sf.theory.drive.slope_limits(**pair)
    >>> sorted(limits.to_dict())
    ['definite', 'exact']
    """
    values = ratios(r, zeta, s1, s2, damping)
    point = {symbol: sp.Rational(value) for symbol, value in zip(SYMBOLS, values, strict=False)}
    definite, *zeros = (_first_zero(e.subs(point)) for e in (DEFINITE, *hurwitz_conditions()))
    return SlopeLimits(definite, max(zeros))


def ratios(r: Any, zeta: Any, s1: Any, s2: Any, damping: str) -> tuple[float, float, float, float]:
    """Check r, zeta, s1 and s2; return r, zeta, s1 and d2 for one interpretation of s2."""
    given = {name: positive(value, name) for name, value in {"r": r, "zeta": zeta, "s1": s1, "s2": s2}.items()}
    if not is_one_of(damping, READINGS):
        raise SceneError(f"damping is {shortened(damping)}; s2 refers to 'omega1' (d2 = s2) or 'omega2' (d2 = s2/zeta)")
    d2 = given["s2"] / (given["zeta"] if damping == "omega2" else 1.0)
    return given["r"], given["zeta"], given["s1"], d2


def _first_zero(condition: sp.Expr) -> float:
    """Return the largest negative real zero of a polynomial in mu."""
    zeros = sp.Poly(condition, mu).sqf_part().nroots(n=25, maxsteps=500)
    return max(float(v) for v in zeros if v.is_real and v < 0)
