"""Expansion of Krylov, Bogoliubov and Mitropolsky for ``x'' + x + h(x, x') = 0`` with a polynomial h, exactly.

``x = A cos psi + e u1(A, psi) + e^2 u2(A, psi)``, ``A' = e f1 + e^2 f2 + e^3 f3``, ``psi' = 1 + e g1 + e^2 g2``: e
counts the powers of h. The second correction of a stationary amplitude takes f3; the harmonics u1 and u2 add to it.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.model.symbols import SPEED
from symfric.theory.slow_flow import SlowFlow

if TYPE_CHECKING:
    from symfric.theory.averaging import AveragedOscillator

Wave: TypeAlias = dict[int, Any]  # harmonic to coefficient
ORDER = 3  # highest power of e
_A = sp.Symbol("A", positive=True)


@dataclass(frozen=True, eq=False)
class Expansion:
    """Coefficients of the expansion, SymPy expressions in A and `coefficients`.

    Attributes
    ----------
    coefficients : tuple of Symbol
        Of the monomials of h.
    rates, frequencies : tuples of Expr
        f1, f2, f3 and g1, g2, g3.
    position, velocity : dict of int to tuple of Expr
        Series in e of the extreme of x at psi = 0 and pi, and of x' at psi = pi/2 and 3 pi/2, keyed by quarter.
    """

    coefficients: tuple[sp.Symbol, ...]
    rates: tuple[sp.Expr, ...]
    frequencies: tuple[sp.Expr, ...]
    position: dict[int, tuple[sp.Expr, ...]]
    velocity: dict[int, tuple[sp.Expr, ...]]


@lru_cache(maxsize=32)
def expansion(monomials: tuple[tuple[int, int], ...]) -> Expansion:
    """Expand for ``h = sum c_k x^m x'^n`` over the given (m, n).

    Notes
    -----
    Waves are dicts from harmonic k to the coefficient of exp(i k psi); series are lists of waves over powers of e. The
    first harmonic of what is left at each power gives f and g, the others give u.
    """
    symbols = tuple(sp.Symbol(f"c_{m}_{n}") for m, n in monomials)
    ring = sp.ring([_A, *symbols], sp.QQ_I)[0]
    A, *c = ring.gens
    i, half = ring(sp.I), ring(sp.Rational(1, 2))
    x = [{1: A * half, -1: A * half}] + [{} for _ in range(ORDER)]
    f, g = [ring(0)] * (ORDER + 1), [ring(0)] * (ORDER + 1)
    g[0] = ring(1)
    for k in range(1, ORDER + 1):
        left = _residual(x, f, g, monomials, c, i, k)
        plus, minus = left.get(1, ring(0)), left.get(-1, ring(0))
        f[k] = i * (plus - minus) * half
        g[k] = ((plus + minus) * half).exquo(A)
        x[k] = {n: -v * ring(sp.Rational(1, 1 - n * n)) for n, v in left.items() if abs(n) != 1 and v}
    speed = _rate_of(x, f, g, i)
    return Expansion(
        symbols,
        tuple(v.as_expr() for v in f[1:]),
        tuple(v.as_expr() for v in g[1:]),
        {quarter: _extreme(x, quarter, A, i) for quarter in (0, 2)},
        {quarter: _extreme(speed, quarter, A, i) for quarter in (1, 3)},
    )


def _residual(x: list[Wave], f: list[Any], g: list[Any], monomials: Any, c: list[Any], i: Any, k: int) -> Wave:
    """Return the coefficient of e^k in ``x'' + x + e h`` with the terms known so far."""
    speed = _rate_of(x, f, g, i)
    left = _sum(_rate_of(speed, f, g, i)[k], x[k])
    for (m, n), factor in zip(monomials, c, strict=True):
        product: list[Wave] = [{0: factor}, *({} for _ in range(ORDER))]
        for wave in [x] * m + [speed] * n:
            product = _product(product, wave)
        left = _sum(left, product[k - 1])
    return left


def _rate_of(series: list[Wave], f: list[Any], g: list[Any], i: Any) -> list[Wave]:
    """Return the time derivative ``A' d/dA + psi' d/dpsi`` of a series of waves."""
    result: list[Wave] = [{} for _ in series]
    for a, wave in enumerate(series):
        for n, v in wave.items():
            slope = v.diff(0)
            for b in range(len(series) - a):
                change = f[b] * slope + g[b] * (i * n) * v
                if change:
                    result[a + b][n] = result[a + b].get(n, 0) + change
    return result


def _sum(one: Wave, two: Wave) -> Wave:
    return {n: one.get(n, 0) + two.get(n, 0) for n in one.keys() | two.keys()}


def _product(one: list[Wave], two: list[Wave]) -> list[Wave]:
    result: list[Wave] = [{} for _ in one]
    for a, left in enumerate(one):
        for b, right in enumerate(two[: len(one) - a]):
            target = result[a + b]
            for m, v in left.items():
                for n, w in right.items():
                    target[m + n] = target.get(m + n, 0) + v * w
    return result


def _extreme(series: list[Wave], quarter: int, A: Any, i: Any) -> tuple[sp.Expr, ...]:
    """Return the series of the extreme near ``psi = quarter pi/2`` to e^2; its shift there is -u1'/u0''."""

    def at(wave: Wave, derivative: int) -> Any:
        turns = [i**n for n in range(4)]
        return sum((v * ((1, i * n, -n * n)[derivative]) * turns[(n * quarter) % 4] for n, v in wave.items()), 0 * A)

    base, first, second = (at(series[k], 0) for k in range(3))
    shift = at(series[1], 1)
    bent = at(series[0], 2)  # +A or -A
    side = 1 if bent == A else -1
    return base.as_expr(), first.as_expr(), (second - side * (shift**2).exquo(2 * A)).as_expr()


def second_order(oscillator: "AveragedOscillator") -> SlowFlow:
    """Return the slow flow to second order of an oscillator of `averaging`; see `average`."""
    h = _small_part(oscillator)
    q, u, omega = oscillator.q, oscillator.u, oscillator.omega
    polynomial = sp.Poly(h, q, u)
    terms = [((m, n), c) for (m, n), c in polynomial.terms() if m + n > 0]
    series = expansion(tuple(power for power, _ in terms))
    # time in units of 1/omega: x'' + x + sum c omega^(n - 2) x^m x'^n
    scaled = [c * omega ** (n - 2) for (_, n), c in terms]
    put = dict(zip(series.coefficients, scaled, strict=True))
    rate = omega * sp.Add(*(sp.expand(e.subs(put)) for e in series.rates))
    frequency = omega * (1 + sp.Add(*(sp.expand(e.subs(put)) for e in series.frequencies[:2])))
    numbers = {s: float(sp.sympify(e).subs(oscillator.values)) for s, e in put.items()}
    amplitudes, stable = _cycles(series, numbers, oscillator)
    positive = tuple(e for f in oscillator.frictions for e in (f.W, f.pull))
    return SlowFlow(_A, rate, frequency, amplitudes, stable, 2, dict(oscillator.values), positive)


def _small_part(oscillator: "AveragedOscillator") -> sp.Expr:
    """Return h in pure slip as a polynomial in q, measured from the equilibrium, and u."""
    q, u = oscillator.q, oscillator.u
    h = -oscillator.rest
    for friction in oscillator.frictions:
        contact = friction.contact
        if contact.law.breaks:
            raise SceneError(
                f"the law of contact {contact.name!r} has branches; order 2 takes polynomials in pure slip"
            )
        if friction.W.is_zero:
            raise SceneError(f"contact {contact.name!r} has no sliding speed; order 2 takes vibration in pure slip")
        load = (contact.normal * contact.profile).subs(q, oscillator.position + q)
        # the slip is side (W + flip |J| u); -J side = -flip |J|
        law = contact.law.kinetic.subs(SPEED, friction.W + friction.flip * friction.pull * u)
        h += friction.flip * friction.pull * load * law / oscillator.mass
    h = sp.expand(h)
    if not h.is_polynomial(q, u):
        raise SceneError(f"the small forces {h} are no polynomial of {q} and {u}; order 2 takes polynomials only")
    return h


def _cycles(
    series: Expansion, numbers: dict[Any, Any], oscillator: "AveragedOscillator"
) -> tuple[np.ndarray, np.ndarray]:
    """Return the half ranges of the cycles in pure slip, and whether they are stable."""
    f1, f2, f3 = (sp.Poly(e.subs(numbers), _A) for e in series.rates)
    slope, bend, slope_2 = f1.diff(), f1.diff().diff(), f2.diff()
    amplitudes, stable = [], []
    for root in np.roots([complex(v).real for v in f1.all_coeffs()]) if f1.degree() > 0 else []:
        if abs(root.imag) > 1e-9 * abs(root) or root.real <= 0:
            continue
        A = sp.Float(float(root.real))
        first = -f2(A) / slope(A)
        second = -(f3(A) + slope_2(A) * first + bend(A) * first**2 / 2) / slope(A)
        high, low = (_value(series.position[k], numbers, A, first, second) for k in (0, 2))
        speeds = [_value(series.velocity[k], numbers, A, first, second) for k in (1, 3)]
        if _slips_one_way(oscillator, speeds):
            amplitudes.append((high - low) / 2)
            stable.append(float(slope(A)) < 0)
    ranking = np.argsort(amplitudes)
    return np.array(amplitudes, dtype=float)[ranking], np.array(stable, dtype=bool)[ranking]


def _value(series: Any, numbers: Any, A: Any, first: Any, second: Any) -> float:
    """Evaluate a series in e at ``A + e first + e^2 second`` to e^2."""
    e0, e1, e2 = (sp.sympify(e).subs(numbers) for e in series)
    total = e0 + e0.diff(_A) * (first + second) + e0.diff(_A, 2) * first**2 / 2 + e1 + e1.diff(_A) * first + e2
    return float(sp.re(total.subs(_A, A)))


def _slips_one_way(oscillator: "AveragedOscillator", speeds: Any) -> bool:
    omega = float(oscillator.omega.subs(oscillator.values))
    for friction in oscillator.frictions:
        W, pull = (float(e.subs(oscillator.values)) for e in (friction.W, friction.pull))
        if min(W + friction.flip * pull * omega * v for v in speeds) <= 0:
            return False
    return True
