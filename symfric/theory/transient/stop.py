"""Exact stop of a free oscillator under Coulomb friction: number of half cycles, position and time."""

import math
import numbers
from fractions import Fraction
from typing import Any, NamedTuple

import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import scenes
from symfric.model.arguments import flag
from symfric.model.scene import Scene
from symfric.model.symbols import finite


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


#: Symbols of the decay of an oscillator with Coulomb friction.
SYMBOLS = TransientSymbols(
    delta=sp.Symbol("delta", positive=True),
    delta_s=sp.Symbol("delta_s", positive=True),
    x0=sp.Symbol("x0", real=True),
    omega_n=sp.Symbol("omega_n", positive=True),
)


@alone(SYMBOLIC)
def half_cycles(delta: Any = None, delta_s: Any = None, x0: Any = 1, *, symbolic: bool = False) -> int | sp.Expr:
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
    if flag(symbolic, "symbolic"):
        return _count(SYMBOLS)
    return _half_cycles(_exact(_given(delta, delta_s, x0)))


@alone(SYMBOLIC)
def stop_position(
    delta: Any = None, delta_s: Any = None, x0: Any = 1, *, symbolic: bool = False
) -> float | Fraction | sp.Expr:
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
    if flag(symbolic, "symbolic"):
        return _rest(SYMBOLS, _count(SYMBOLS))
    given = _given(delta, delta_s, x0)
    exact = _exact(given)
    result = _rest(exact, _half_cycles(exact))
    rational = all(isinstance(v, numbers.Rational) for v in given)
    return Fraction(result.p, result.q) if rational else float(result)


@alone(SYMBOLIC)
def stop_time(
    delta: Any = None, delta_s: Any = None, x0: Any = 1, omega_n: Any = 1, *, symbolic: bool = False
) -> float | sp.Expr:
    """Return the time at which the mass of `half_cycles` stops, ``N pi/omega_n``; derivations/handbook/stop.py.

    Parameters
    ----------
    delta, delta_s, x0
        As in `stop_position`.
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
    if flag(symbolic, "symbolic"):
        return _count(SYMBOLS) * sp.pi / SYMBOLS.omega_n
    exact = _exact(_given(delta, delta_s, x0, omega_n))
    return float(_half_cycles(exact) * sp.pi / exact.omega_n)


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


def _given(delta: Any, delta_s: Any, x0: Any, omega_n: Any = 1) -> TransientSymbols:
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


def _rational(value: Any, what: str) -> sp.Expr:
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
