"""Closed forms of friction with memory: reversal and loop of Dahl's law, drift of LuGre, Iwan's backbone and loops.

They are derived from the laws in derivations/presliding.py.
"""

import math
from typing import TYPE_CHECKING

from symfric.errors import SceneError
from symfric.model.public_names import names_of
from symfric.model.symbols import finite, positive
from symfric.spelling import spelt

__all__ = [
    "dahl_loop",
    "dahl_reversal",
    "iwan_backbone",
    "iwan_dissipation",
    "lugre_drift",
]

_DEEP = 25  # last odd number of the continued fraction of the hyperbolic tangent: exact up to an argument of 1


def _numbers(**given: float) -> list[float]:
    """Return numbers; all but those called `x` and `chi` must be positive."""
    any_sign = ("x", "chi", "low")
    return [finite(value, name) if name in any_sign else positive(value, name) for name, value in given.items()]


@spelt
def dahl_reversal(mu_c: float, sigma: float, x: float) -> float:
    r"""Coefficient of Dahl's law a distance after a reversal of steady sliding.

    Parameters
    ----------
    mu_c : float
        Coefficient in steady sliding, > 0.
    sigma : float
        Stiffness, > 0, 1/length.
    x : float
        Distance since the reversal, >= 0, length.

    Returns
    -------
    float
        In the new direction of slip: it starts at -mu_c and tends to mu_c.

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    :math:`\mu_c(1 - 2e^{-\sigma x/\mu_c})`, the solution of :math:`d\mu/dx = \sigma(1 - \mu/\mu_c)` from -mu_c; see
    `sf.laws.dahl`.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.presliding.dahl_reversal(1.0, 10.0, 0.1), 14)
    0.26424111765712
    """
    mu_c, sigma, x = _numbers(mu_c=mu_c, sigma=sigma, x=x)
    if x < 0:
        raise SceneError(f"x is {x:g}; the distance since a reversal must not be negative")
    return mu_c * (1 - 2 * math.exp(-sigma * x / mu_c))


@spelt
def dahl_loop(mu_c: float, sigma: float, amplitude: float) -> float:
    r"""Energy that Dahl's law dissipates in a cycle between two displacements, per normal load.

    Parameters
    ----------
    mu_c, sigma : float
        As in `dahl_reversal`.
    amplitude : float
        Half the distance between the displacements, > 0, length.

    Returns
    -------
    float
        Area of the closed loop, length.

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    The loop turns at the coefficients :math:`\pm\mu_c\tanh(\sigma X/\mu_c)`, and its area is
    :math:`4\mu_c\,(X - (\mu_c/\sigma)\tanh(\sigma X/\mu_c))`; for large X that of Coulomb friction.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.presliding.dahl_loop(1.0, 10.0, 0.1), 12)
    0.095362337618
    """
    mu_c, sigma, X = _numbers(mu_c=mu_c, sigma=sigma, amplitude=amplitude)
    y = sigma * X / mu_c
    if y > 1:
        return 4 * mu_c * (X - mu_c / sigma * math.tanh(y))
    fraction = 0.0  # tanh y = y / (1 + y^2/(3 + y^2/(5 + ...))), so that nothing cancels
    for k in range(_DEEP, 1, -2):
        fraction = y**2 / (k + fraction)
    return 4 * mu_c * X * fraction / (1 + fraction)


@spelt
def lugre_drift(sigma0: float, low: float, high: float, mu_c: float = 1.0) -> float:
    r"""Displacement by which LuGre bristles creep in each cycle of a slowly varying load below the limit.

    Parameters
    ----------
    sigma0 : float
        Stiffness of the bristles, > 0, 1/length.
    low, high : float
        Ends of the load over the normal load, ``0 <= low < high < mu_c``, dimensionless.
    mu_c : float
        Coefficient; the static one is the same.

    Returns
    -------
    float
        Creep per cycle in the direction of the load, length; an elasto-plastic law with its breakaway above `high` has
        none.

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    Without inertia :math:`\sigma_0 z` is the load f, and :math:`dx = df/(\sigma_0(1 \mp f/\mu_c))` up and down, which
    adds up to :math:`(\mu_c/\sigma_0)\ln\frac{\mu_c^2 - f_1^2}{\mu_c^2 - f_2^2}`.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.presliding.lugre_drift(100.0, 0.2, 0.8), 16)
    0.0098082925301173
    """
    sigma0, low, high, mu_c = _numbers(sigma0=sigma0, low=low, high=high, mu_c=mu_c)
    if not 0 <= low < high < mu_c:
        raise SceneError(f"the load goes from {low:g} to {high:g}; it must increase between 0 and mu_c = {mu_c:g}")
    return mu_c / sigma0 * math.log1p((high - low) * (high + low) / ((mu_c - high) * (mu_c + high)))


@spelt
def iwan_backbone(R: float, chi: float, phi_max: float, x: float) -> float:
    r"""Coefficient of Iwan's law with a power-law density on first loading.

    Parameters
    ----------
    R : float
        Factor of the density, > 0.
    chi : float
        Its exponent, -1 < chi.
    phi_max : float
        Largest yield displacement, > 0, length.
    x : float
        Displacement from rest, length; the coefficient is odd in it.

    Returns
    -------
    float
        Coefficient of friction, in the unit of R length^(chi + 2).

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    Sliders of yield displacement phi have the density :math:`R\phi^\chi` up to phi_max: D. J. Segalman, Journal of
    Applied Mechanics 72 (2005) 752. :math:`F = R\,(\frac{X^{\chi+2}}{\chi+2} +
    X\,\frac{\phi_{max}^{\chi+1} - X^{\chi+1}}{\chi+1})` up to phi_max, constant beyond.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.presliding.iwan_backbone(1.0, -0.5, 1.0, 1.0), 12)
    0.666666666667
    """
    R, chi, phi_max, x = _numbers(R=R, chi=chi, phi_max=phi_max, x=x)
    if chi <= -1:
        raise SceneError(f"chi is {chi:g}; it must be above -1")
    X = min(abs(x), phi_max)
    sliding, held = X ** (chi + 2) / (chi + 2), X * (phi_max ** (chi + 1) - X ** (chi + 1)) / (chi + 1)
    return math.copysign(R * (sliding + held), x)


@spelt
def iwan_dissipation(R: float, chi: float, amplitude: float) -> float:
    r"""Energy that Iwan's law with a power-law density dissipates in a cycle, per normal load.

    Parameters
    ----------
    R, chi : float
        Factor and exponent of the density, as in `iwan_backbone`.
    amplitude : float
        Amplitude of the displacement, > 0, not beyond the largest yield displacement, length.

    Returns
    -------
    float
        Area of the closed loop, in the unit of R length^(chi + 3).

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    :math:`\int_0^X 4\phi(X - \phi)R\phi^\chi d\phi = 4RX^{\chi+3}/((\chi+3)(\chi+2))`: Segalman (2005).

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.presliding.iwan_dissipation(1.0, -0.5, 0.7), 14)
    0.43729430720181
    """
    R, chi, X = _numbers(R=R, chi=chi, amplitude=amplitude)
    if chi <= -1:
        raise SceneError(f"chi is {chi:g}; it must be above -1")
    return float(4 * R * X ** (chi + 3) / ((chi + 3) * (chi + 2)))


if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
