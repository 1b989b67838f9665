"""Decay of a free oscillator by friction: exact stop under Coulomb friction, and averaged decay time."""

import itertools
import math
import numbers
from fractions import Fraction
from functools import partial
from typing import NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import scenes
from symfric.model.numeric import gauss_legendre
from symfric.model.offering import offer
from symfric.model.scene import Scene
from symfric.model.symbols import finite
from symfric.theory.decay import Decisions, EnergyBalance, damper_numbers, decisions, energy_balance

__all__ = [
    "DAMPER",
    "SYMBOLS",
    "DamperSymbols",
    "Decisions",
    "EnergyBalance",
    "TransientSymbols",
    "amplitude_rate",
    "averaged_decay_time",
    "damper_numbers",
    "decisions",
    "energy_balance",
    "half_cycles",
    "mean_friction",
    "stop_position",
    "stop_time",
]


class TransientSymbols(NamedTuple):
    """Symbols of `symfric.scenes.coulomb_oscillator`.

    Attributes
    ----------
    delta, delta_s, x0, omega_n : Symbol
        As the arguments of `sf.scenes.coulomb_oscillator`.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.transient.SYMBOLS.delta
    delta
    """

    delta: sp.Symbol
    delta_s: sp.Symbol
    x0: sp.Symbol
    omega_n: sp.Symbol


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


#: Symbols of the decay of an oscillator with Coulomb friction.
SYMBOLS = TransientSymbols(
    delta=sp.Symbol("delta", positive=True),
    delta_s=sp.Symbol("delta_s", positive=True),
    x0=sp.Symbol("x0", real=True),
    omega_n=sp.Symbol("omega_n", positive=True),
)
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

_SIGNIFICANT = 45.0  # exponent beyond which a term is below rounding


@alone(SYMBOLIC)
def half_cycles(delta=None, delta_s=None, x0=1, *, symbolic: bool = False) -> int | sp.Expr:
    r"""Return the number of half cycles of a mass on a spring on a rough floor until it stays at rest.

    Parameters
    ----------
    delta : number or Scene
        Kinetic friction over stiffness, a length; or `symfric.scenes.coulomb_oscillator`, whose values are then taken.
    delta_s : number, optional
        Static friction over stiffness, at least `delta`; equal to it unless given.
    x0 : number
        Displacement at which the mass is released from rest.
    symbolic : bool
        Return the formula in `SYMBOLS`.

    Returns
    -------
    int or Expr

    Raises
    ------
    NotFound
        If nothing ever stops it: `delta` is 0.
    SceneError
        If a number is missing or out of range, or the scene is another one or starts with a velocity.

    Notes
    -----
    ``N = max(0, ceil((|x0| - delta_s)/(2 delta)))``, the first n with ``|x0| - 2 n delta <= delta_s``;
    derivations/handbook/stop.py.

    A turning point that just reaches the static bound is a stop, so equality must be decided, and is, exactly: ints,
    fractions and exact SymPy numbers are taken as they are, and a float stands for the simplest fraction (that of the
    least denominator) which rounds to it. So 0.1 is 1/10, the float of 1/3 is 1/3, and every p/q with
    ``p q < 2^52`` comes back from its float, for no fraction with a smaller denominator lies within its rounding. The
    bits of the float instead would put 1/3 below a third and find a half cycle more.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.transient.half_cycles(0.1, x0=1.0)
    5
    """
    return _count(SYMBOLS) if symbolic else _half_cycles(_exact(_given(delta, delta_s, x0)))


@alone(SYMBOLIC)
def stop_position(delta=None, delta_s=None, x0=1, *, symbolic: bool = False) -> float | Fraction | sp.Expr:
    """Return the final position of the mass of `half_cycles`, in the unit of x0; same arguments.

    Parameters
    ----------
    delta : float or Scene
        Friction force over stiffness, or a `sf.scenes.coulomb_oscillator`.
    delta_s : float, optional
        The same for static friction.
    x0 : float
        Start.
    symbolic : bool
        Return the formula in `SYMBOLS` instead of a number.

    Returns
    -------
    float, Fraction or Expr
        A Fraction if every number given is an int, a Fraction or a SymPy rational.

    Notes
    -----
    ``(-1)^N (x0 - 2 N delta sgn x0)``; derivations/handbook/stop.py.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.transient.stop_position(0.03), 6)
    0.02
    """
    if symbolic:
        return _rest(SYMBOLS, _count(SYMBOLS))
    given = _given(delta, delta_s, x0)
    exact = _exact(given)
    result = _rest(exact, _half_cycles(exact))
    rational = all(isinstance(v, numbers.Rational) for v in given)
    return Fraction(result.p, result.q) if rational else float(result)


@alone(SYMBOLIC)
def stop_time(delta=None, delta_s=None, x0=1, omega_n=1, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the time at which the mass of `half_cycles` stops, ``N pi/omega_n``; derivations/handbook/stop.py.

    Parameters
    ----------
    delta : float or Scene
        Friction force over stiffness, or a `sf.scenes.coulomb_oscillator`.
    delta_s : float, optional
        The same for static friction.
    x0 : float
        Start.
    omega_n : float
        Natural frequency.
    symbolic : bool
        Return the formula in `SYMBOLS` instead of a number.

    Returns
    -------
    float or Expr

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.transient.stop_time(0.1, omega_n=2.0), 6)
    7.853982
    """
    if symbolic:
        return _count(SYMBOLS) * sp.pi / SYMBOLS.omega_n
    exact = _exact(_given(delta, delta_s, x0, omega_n))
    return float(_half_cycles(exact) * sp.pi / exact.omega_n)


@alone(SYMBOLIC)
def mean_friction(a=None, *, literal: bool = False, symbolic: bool = False) -> float | np.ndarray | sp.Expr:
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
    if symbolic:
        return _mean_friction(DAMPER.A * DAMPER.omega_n / DAMPER.v_c, literal)
    a = np.asarray(a, dtype=float)
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
    f_n=None, mu_m=None, *, zeta=0.0, r=1.0, x0=0.01, v0=0.0, g=9.81, v_c=1.0, symbolic: bool = False
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
        If there is no friction: the amplitude then never reaches zero.
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
    if symbolic:
        d = DAMPER
        return sp.Integral(-1 / amplitude_rate(), (d.A, 0, sp.sqrt(d.x0**2 + (d.v0 / d.omega_n) ** 2)))
    given = {"mu_m": mu_m, "zeta": zeta, "r": r, "x0": x0, "v0": v0, "g": g, "v_c": v_c}
    if not isinstance(f_n, Scene):
        return _averaged(mean_friction, f_n=f_n, **given)
    if given != {"mu_m": None, "zeta": 0.0, "r": 1.0, "x0": 0.01, "v0": 0.0, "g": 9.81, "v_c": 1.0}:
        raise SceneError("mu_m, zeta, x0, ... are those of the scene; change them with scene.where({...})")
    numbers, literal = damper_numbers(f_n)
    mean = partial(mean_friction, literal=literal)
    return _averaged(mean, **{k: numbers[k] for k in ("f_n", *given)})


def _averaged(mean, *, f_n, mu_m, zeta, r, x0, v0, g, v_c) -> float:
    """Return the time of the averaged decay with the mean braking `mean(a)`."""
    omega = 2 * np.pi * _positive(f_n, "f_n")
    v_c = _positive(v_c, "v_c")
    friction = _positive(mu_m, "mu_m", zero=True) * _positive(r, "r", zero=True) * _positive(g, "g", zero=True)
    viscous = _positive(zeta, "zeta", zero=True) * omega
    start = math.hypot(finite(x0, "x0"), finite(v0, "v0") / omega) * omega / v_c
    if start == 0:
        return 0.0
    if friction == 0:
        raise NotFound("without friction the amplitude never falls to zero; give mu_m, r and g above 0")
    braking = 2 / np.pi * friction / v_c
    return _decay_time(lambda a: 1 / (viscous * a + braking * mean(a)), start)


def _decay_time(integrand, start: float) -> float:
    """Integrate from 0 to `start` decade by decade, so that every scale of the integrand is resolved."""
    from scipy import integrate

    decades = max(0, math.ceil(math.log10(start)))
    edges = [0.0, *(10.0**k for k in range(decades)), start]
    pieces = itertools.pairwise(edges)
    return sum(integrate.quad(integrand, *piece, epsabs=0.0, epsrel=1e-12, limit=200)[0] for piece in pieces)


def _mean_friction(a: sp.Expr, literal: bool) -> sp.Expr:
    half = sp.Rational(1, 2)
    struve = 2 * a**2 / (3 * sp.pi) * sp.hyper([1], [3 * half, 5 * half], a**2 / 4)
    return 1 + sp.pi / 2 * (struve if literal else struve - sp.besseli(1, a))


def _count(o: TransientSymbols) -> sp.Expr:
    return sp.Max(0, sp.ceiling((sp.Abs(o.x0) - o.delta_s) / (2 * o.delta)))


def _rest(o: TransientSymbols, n: int | sp.Expr) -> sp.Expr:
    return (-1) ** n * (o.x0 - 2 * n * o.delta * sp.sign(o.x0))


def _half_cycles(given: TransientSymbols) -> int:
    if abs(given.x0) <= given.delta_s:
        return 0
    if given.delta == 0:
        raise NotFound("delta is 0: without friction the mass never stops")
    result = _count(given)
    if not result.is_Integer:
        raise SceneError(f"SymPy cannot decide whether {result} is a tie; give rational numbers")
    return int(result)


def _given(delta, delta_s, x0, omega_n=1) -> TransientSymbols:
    """Return the arguments as given, or the values of a scene if one is given."""
    if not isinstance(delta, Scene):
        return TransientSymbols(delta, delta if delta_s is None else delta_s, x0, omega_n)
    if delta_s is not None or x0 != 1 or omega_n != 1:
        raise SceneError("delta_s, x0 and omega_n are those of the scene; change them with scene.where({...})")
    model = scenes.coulomb_oscillator(1.0)
    if (delta.system, delta.contacts) != (model.system, model.contacts):
        raise SceneError(
            "the exact stop holds for sf.scenes.coulomb_oscillator; this scene has other equations (sf.simulate with "
            "sf.StopTime() takes any)"
        )
    x, u = model.system.states
    start = delta.numbers()
    if start[u] != 0:
        raise SceneError(f"the scene starts with u = {start[u]:g}; the exact stop holds for a release from rest")
    named = {s.name: v for s, v in delta.values.items()}
    return TransientSymbols(named["delta"], named["delta_s"], start[x], named["omega_n"])


def _exact(given: TransientSymbols) -> TransientSymbols:
    """Return the oscillator's numbers as exact ones, checked."""
    if given.delta is None:
        raise SceneError("no delta; give numbers or a scene, or ask for the formula with symbolic=True")
    exact = TransientSymbols(*(_rational(v, name) for v, name in zip(given, TransientSymbols._fields, strict=True)))
    if exact.delta < 0:
        raise SceneError(f"delta is {given.delta}; it must not be negative")
    if exact.delta_s < exact.delta:
        raise SceneError(f"delta_s is {given.delta_s}, below delta = {given.delta}; static friction is the larger one")
    if exact.omega_n <= 0:
        raise SceneError(f"omega_n is {given.omega_n}; it must be positive")
    return exact


def _rational(value, what: str) -> sp.Expr:
    """Return a number as it is if it is exact; a float as the simplest fraction that rounds to it."""
    number = finite(value, what)
    if isinstance(value, sp.Expr) and not value.has(sp.Float):
        return value
    if isinstance(value, numbers.Rational):
        return sp.Rational(int(value.numerator), int(value.denominator))
    fraction = _simplest(number)
    return sp.Rational(fraction.numerator, fraction.denominator)


def _simplest(value: float) -> Fraction:
    """Return the fraction of the least denominator among those that round to `value`."""
    if value.is_integer():
        return Fraction(value)
    size = abs(value)
    low, high = ((Fraction(size) + Fraction(math.nextafter(size, end))) / 2 for end in (0.0, math.inf))
    return _between(low, high) * (1 if value > 0 else -1)


def _between(low: Fraction, high: Fraction) -> Fraction:
    """Return the fraction of the least denominator in [low, high], by their common continued fraction."""
    whole = math.ceil(low)
    if whole <= high:
        return Fraction(whole)
    whole -= 1
    return whole + 1 / _between(1 / (high - whole), 1 / (low - whole))


def _positive(value, what: str, zero: bool = False) -> float:
    """Return a finite number, checked to be positive or not negative."""
    if value is None:
        raise SceneError(f"no {what}; give a number, or ask for the formula with symbolic=True")
    number = finite(value, what)
    if number < 0 or (number == 0 and not zero):
        raise SceneError(f"{what} is {number:g}; it must {'not be negative' if zero else 'be positive'}")
    return number


offer(__name__)
