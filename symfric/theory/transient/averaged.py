"""Averaged decay of a free oscillator under exponential friction, such as a rod that a contact brakes."""

import itertools
import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import flag
from symfric.model.numeric import gauss_legendre
from symfric.model.scene import Scene
from symfric.model.symbols import finite, numbers_of, positive
from symfric.theory.closed_form import needed
from symfric.theory.transient.decay import damper_numbers


class DamperSymbols(NamedTuple):
    """Symbols of the averaged contact damper; A is the amplitude, v_c the speed over which its friction falls.

    Attributes
    ----------
    A, omega_n, mu_m, zeta, r, x0, v0, g, v_c : Symbol
        Amplitude; the others as the arguments of `sf.scenes.contact_damper`, omega_n for 2 pi f_n.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.transient.DAMPER.omega_n
    omega_n
    """

    A: sp.Symbol
    omega_n: sp.Symbol
    mu_m: sp.Symbol
    zeta: sp.Symbol
    r: sp.Symbol
    x0: sp.Symbol
    v0: sp.Symbol
    g: sp.Symbol
    v_c: sp.Symbol


#: Symbols of the decay of a rod that a contact brakes.
DAMPER = DamperSymbols(
    A=sp.Symbol("A", positive=True),
    omega_n=sp.Symbol("omega_n", positive=True),
    mu_m=sp.Symbol("mu_m", positive=True),
    zeta=sp.Symbol("zeta", nonnegative=True),
    r=sp.Symbol("r", positive=True),
    x0=sp.Symbol("x0", real=True),
    v0=sp.Symbol("v0", real=True),
    g=sp.Symbol("g", positive=True),
    v_c=sp.Symbol("v_c", positive=True),
)

_LEAST = 1e-290  # rate of decay that is none
_SIGNIFICANT = 45.0  # exponent beyond which a term is below rounding


@alone(SYMBOLIC)
def mean_friction(a: Any = None, *, literal: bool = False, symbolic: bool = False) -> Any:
    r"""Return the mean braking force of exponential friction under a harmonic motion, over that of Coulomb friction.

    Parameters
    ----------
    a : float or array_like
        Velocity amplitude over the speed v_c of the law, >= 0.
    literal : bool
        Of the law as printed, which grows in one direction: the mean of F(a) and F(-a), ``1 + (pi/2) L_1(a)``.
    symbolic : bool
        Return the formula in ``A``, ``omega_n`` and ``v_c`` of `DAMPER`.

    Returns
    -------
    float or ndarray or Expr

    Notes
    -----
    ``F(a) = int_0^{pi/2} sin p exp(-a sin p) dp = 1 + (pi/2)(L_1(a) - I_1(a))`` with the modified Struve function L_1;
    derivations/younes_ashour/amplitude.py. SymPy has no L_1, so the formula has the hypergeometric function that it is.
    The difference loses all digits for a above 30 (I_1 grows like e^a, F falls like 1/a^2), so numbers come from the
    integral, up to where the integrand is below e^-45, by Gauss-Legendre quadrature: 14 digits for every a.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.transient.mean_friction(0.5), 6)
    0.679633
    """
    flag(literal, "literal")
    if flag(symbolic, "symbolic"):
        return _mean_friction(DAMPER.A * DAMPER.omega_n / DAMPER.v_c, literal)
    a = numbers_of(a, "a")
    if literal:
        from scipy import special

        result = 1 + np.pi / 2 * special.modstruve(1, a)
        return result if result.ndim else float(result)
    end = np.arcsin(np.minimum(1.0, _SIGNIFICANT / np.maximum(a, _SIGNIFICANT)))[..., np.newaxis]
    nodes, weights = gauss_legendre()
    sine = np.sin(end * nodes)
    result = np.sum(end * weights * sine * np.exp(-a[..., np.newaxis] * sine), axis=-1)
    return result if result.ndim else float(result)


@alone(SYMBOLIC)
def amplitude_rate() -> sp.Expr:
    """Return A' of a contact damper with exponential friction, averaged over a cycle; a formula in `DAMPER`.

    Returns
    -------
    Expr

    Notes
    -----
    ``A' = -zeta omega_n A - (2/pi)(mu_m r g/omega_n) F(A omega_n/v_c)`` with F of `mean_friction`;
    derivations/younes_ashour/amplitude.py.

    Examples
    --------
    >>> import symfric as sf
    >>> sorted(s.name for s in sf.theory.transient.amplitude_rate().free_symbols)
    ['A', 'g', 'mu_m', 'omega_n', 'r', 'v_c', 'zeta']
    """
    d = DAMPER
    return -d.zeta * d.omega_n * d.A - 2 / sp.pi * d.mu_m * d.r * d.g / d.omega_n * mean_friction(symbolic=True)


@alone(SYMBOLIC)
def averaged_decay_time(
    f_n: float | Scene | None = None,
    mu_m: float | None = None,
    *,
    zeta: float = 0.0,
    r: float = 1.0,
    x0: float = 0.01,
    v0: float = 0.0,
    g: float = 9.81,
    v_c: float = 1.0,
    symbolic: bool = False,
) -> float | sp.Expr:
    r"""Return the time in which the averaged amplitude of a contact damper falls to zero, s.

    Parameters
    ----------
    f_n : float or Scene
        Natural frequency, Hz; or `symfric.scenes.contact_damper`, whose values and start are then taken.
    mu_m : float
        Coefficient of friction at rest.
    zeta, r : float
        Damping ratio; normal load over weight.
    x0, v0 : float
        Start, m and m/s.
    g, v_c : float
        Gravity, m/s^2; speed over which friction falls by a factor e, m/s.
    symbolic : bool
        Return the integral in `DAMPER`.

    Returns
    -------
    float or Expr

    Raises
    ------
    NotFound
        If there is no friction, or too little of it at the start: the amplitude then never reaches zero.
    SceneError
        If a number is missing or out of range.

    Notes
    -----
    ``int_0^{A_0} dA/(-A')`` with `amplitude_rate` and ``A_0^2 = x0^2 + (v0/omega_n)^2``;
    derivations/younes_ashour/amplitude.py.
    The true motion stops at a turning point, by half cycles; where in the band within +-delta the last one falls is a
    matter of chance with mean zero, so amplitude zero is the unbiased end, and the true time differs by half of a half
    cycle at most, as far as friction and damping are weak.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.transient.averaged_decay_time(10.0, 0.1, zeta=0.005), 6)
    1.059833
    """
    if flag(symbolic, "symbolic"):
        d = DAMPER
        return sp.Integral(-1 / amplitude_rate(), (d.A, 0, sp.sqrt(d.x0**2 + (d.v0 / d.omega_n) ** 2)))
    given: dict[str, Any] = {"mu_m": mu_m, "zeta": zeta, "r": r, "x0": x0, "v0": v0, "g": g, "v_c": v_c}
    if not isinstance(f_n, Scene):
        return _averaged(mean_friction, f_n=f_n, **given)
    if given != {"mu_m": None, "zeta": 0.0, "r": 1.0, "x0": 0.01, "v0": 0.0, "g": 9.81, "v_c": 1.0}:
        raise SceneError("mu_m, zeta, x0, ... are those of the scene; change them with scene.where({...})")
    numbers, literal = damper_numbers(f_n)
    mean = partial(mean_friction, literal=literal)
    return _averaged(mean, **{k: numbers[k] for k in ("f_n", *given)})


def _averaged(mean: Callable[[float], Any], *, x0: float, v0: float, **given: float | None) -> float:
    """Return the time of the averaged decay with the mean braking `mean(a)`."""
    f_n, v_c = (positive(needed(given[name], name), name) for name in ("f_n", "v_c"))
    mu_m, r, g, zeta = (positive(needed(given[name], name), name, zero=True) for name in ("mu_m", "r", "g", "zeta"))
    omega = 2 * np.pi * f_n
    friction, viscous = mu_m * r * g, zeta * omega
    start = math.hypot(finite(x0, "x0"), finite(v0, "v0") / omega) * omega / v_c
    if start == 0:
        return 0.0
    if friction == 0:
        raise NotFound("without friction the amplitude never falls to zero; give mu_m, r and g above 0")
    braking = 2 / np.pi * friction / v_c
    if not viscous * start + braking * mean(start) > _LEAST:
        raise NotFound("friction and damping are too small at the start for a decay within a finite time")
    return _decay_time(lambda a: 1 / (viscous * a + braking * mean(a)), start)


def _decay_time(integrand: Callable[[float], float], start: float) -> float:
    """Integrate from 0 to `start` decade by decade, so that every scale of the integrand is resolved."""
    from scipy import integrate

    decades = max(0, math.ceil(math.log10(start)))
    edges = [0.0, *(10.0**k for k in range(decades)), start]
    pieces = itertools.pairwise(edges)
    return float(sum(integrate.quad(integrand, *piece, epsabs=0.0, epsrel=1e-12, limit=200)[0] for piece in pieces))


def _mean_friction(a: sp.Expr, literal: bool) -> sp.Expr:
    half = sp.Rational(1, 2)
    struve = 2 * a**2 / (3 * sp.pi) * sp.hyper([1], [3 * half, 5 * half], a**2 / 4)
    return 1 + sp.pi / 2 * (struve if literal else struve - sp.besseli(1, a))
