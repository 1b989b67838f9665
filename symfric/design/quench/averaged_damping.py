r"""Damping and power of a shaken contact as CasADi functions of belt speed and intensity, for any law.

With ``w = v - q cos(theta)`` and < > the mean over theta, the effective friction ``<sgn(w) mu(|w|)>``, Thomsen (41),
has the slope

.. math:: \bar\mu'(v) = \langle\mu'(|w|)\rangle + \frac{2\mu(0)}{\pi\sqrt{q^2 - v^2}}\,[v < q],

whose last term comes from the jump at w = 0. The fast velocity ``x' = q cos(theta)`` spends the mean power
``c q^2/2 - N <q cos(theta) sgn(w) mu(|w|)>``; for the cubic law that is `symfric.theory.belt.mean_power`.
"""

import itertools
from dataclasses import dataclass
from typing import TypeAlias

import casadi as ca
import numpy as np
import sympy as sp

from symfric.codegen.point_function import PointFunction
from symfric.design.quench.belt_scene import Belt
from symfric.locks import SYMBOLIC, alone
from symfric.lower.law_features import narrow
from symfric.lower.printer import Printer, Switches
from symfric.model.averaged_law import pieces_between
from symfric.model.numeric import gauss_legendre
from symfric.model.symbols import SPEED

Pair: TypeAlias = tuple[ca.Function, ca.Function]  # inside and outside
NARROW = 0.05  # distance of features of the law, relative to the highest speed, below which they split the quadrature
SMALLEST = 1e-30  # least (q^2 - v^2)/q^2, so that the slope, infinite at v = q, stays finite


@dataclass(frozen=True, eq=False)
class Averaged:
    """The shaken contact as CasADi functions of (v, q).

    Attributes
    ----------
    inside, outside : Function ``(v, q) -> (damping, power, friction, share)``
        Damping ``c + N mubar'``, mean power of the fast motion, mubar, and its share ``mubar(v)/mu(v)`` of the friction
        without excitation, for v <= q and for v >= q; at v = q the damping inside is infinite.
    dampings : (PointFunction, PointFunction)
        ``(v, q) -> damping`` alone, inside and outside, for searches that need nothing else.
    unshaken : Function ``v -> damping``
        Without excitation, v > 0.
    levels : tuple of float
        Relative velocities where the law has a kink or a narrow feature, increasing; the average has them at
        |level +- q|.
    kinks : tuple of float
        Those of them where it has a kink.
    falls_steeply : bool
        Whether the slope of the law at rest is minus infinity; then so is the damping outside at v = q.
    scale : float
        Size of a damping, for tolerances.
    """

    inside: ca.Function
    outside: ca.Function
    dampings: tuple[PointFunction, PointFunction]
    unshaken: ca.Function
    levels: tuple[float, ...]
    kinks: tuple[float, ...]
    falls_steeply: bool
    scale: float


@alone(SYMBOLIC)
def average_belt(belt: Belt, speeds: tuple[float, float], q_max: float) -> Averaged:
    """Build the functions, with as many quadrature nodes as the law needs up to the intensity q_max (at most 192)."""
    kinks = [float(b) for b in belt.law.breaks]
    breaks = sorted({*kinks, *narrow(belt.law, 0.0, speeds[1] + q_max, NARROW * speeds[1])})
    whole = [_compiled(e) for e in pieces_between(belt.law.kinetic, belt.law.breaks)]
    pieces = [whole[np.searchsorted(kinks, v, side="right")] for v in (0.0, *breaks)]
    rest, slope = (float(e) for e in pieces[0](0.0))
    steep = not np.isfinite(slope)
    v = ca.SX.sym("v")
    unshaken = ca.Function("unshaken", [v], [belt.damping + belt.normal * _on_branch(pieces, breaks, v, 1)])
    grid = np.linspace(speeds[0], speeds[1], 65)[None, :]
    grid = grid[grid > 0][None, :]
    scale = abs(belt.damping) + float(np.max(np.abs(np.array(unshaken(grid)) - belt.damping), initial=0.0))
    scale = scale or belt.normal * rest / q_max
    nodes = 24
    coarse = _functions(belt, pieces, breaks, rest, nodes)
    while nodes < 192:
        fine = _functions(belt, pieces, breaks, rest, 2 * nodes)
        if _distance(coarse, fine, speeds, q_max, steep, breaks) < 1e-10 * scale:
            break
        coarse, nodes = fine, 2 * nodes
    levels, bends = (tuple(sorted({-b for b in e} | set(e) | {0.0})) for e in (breaks, kinks))
    return Averaged(
        *coarse, (_damping_of(coarse[0]), _damping_of(coarse[1])), unshaken, levels, bends, steep and slope < 0, scale
    )


def _damping_of(function: ca.Function) -> PointFunction:
    """Return a function of the first output alone."""
    v, q = ca.SX.sym("v"), ca.SX.sym("q")
    return PointFunction(ca.Function("damping", [v, q], [function(v, q)[0]]))


def _compiled(expr: sp.Expr) -> ca.Function:
    """Return ``v -> (mu, mu')`` of one branch."""
    v = ca.SX.sym("v")
    mu = Printer({SPEED: v}, set(), Switches())(expr)
    return ca.Function("mu", [v], [mu, ca.jacobian(mu, v)])


def _on_branch(pieces: list[ca.Function], breaks: list[float], v: ca.SX, order: int) -> ca.SX:
    """Return the law (order 0) or its slope (1) at a speed."""
    result = pieces[-1](v)[order]
    for piece, b in zip(reversed(pieces[:-1]), reversed(breaks), strict=True):
        result = ca.if_else(v < b, piece(v)[order], result)
    return result


def _functions(
    belt: Belt, pieces: list[ca.Function], breaks: list[float], rest: float, nodes: int
) -> tuple[ca.Function, ca.Function]:
    v, q = ca.SX.sym("v"), ca.SX.sym("q")
    functions = []
    for name, inside in (("inside", True), ("outside", False)):
        slope, weighted, mean = _means(pieces, breaks, v, q, inside, nodes)
        if inside and rest != 0:
            gap = ca.fmax((q - v) * (q + v), SMALLEST * q * q)
            slope += 2 * rest / (np.pi * ca.sqrt(gap))
        damping = belt.damping + belt.normal * slope
        power = 0.5 * belt.damping * q * q - belt.normal * q * weighted
        share = mean / _on_branch(pieces, breaks, v, 0)
        names = ["damping", "power", "friction", "share"]
        functions.append(ca.Function(name, [v, q], [damping, power, mean, share], ["v", "q"], names))
    return functions[0], functions[1]


def _means(
    pieces: list[ca.Function], breaks: list[float], v: ca.SX, q: ca.SX, inside: bool, nodes: int
) -> tuple[ca.SX, ...]:
    """Return the means of mu'(|w|), cos(theta) sgn(w) mu(|w|) and sgn(w) mu(|w|), arc by arc between kinks."""
    levels = [*(-b for b in reversed(breaks)), 0.0, *breaks] if inside else list(breaks)
    angles = [ca.SX(0), *(_angle((v - level) / q) for level in levels), ca.SX(np.pi)]
    x, weights = gauss_legendre(nodes)
    clustered = ca.DM(x**2 * (3 - 2 * x)).T  # nodes cluster at both ends of an arc, where the law varies most
    density = ca.DM(weights * 6 * x * (1 - x) / np.pi)
    slope = weighted = mean = ca.SX(0)
    for k, (low, high) in enumerate(itertools.pairwise(angles)):
        branch, sign = (k, 1) if not inside else _place(k, len(breaks))
        cosine = ca.cos(low + (high - low) * clustered)
        speed = ca.fmax(sign * (v - q * cosine), 1e-15 * q)  # not negative by rounding
        mu, derivative = pieces[branch](speed)
        slope += (high - low) * ca.mtimes(derivative, density)
        mean += (high - low) * sign * ca.mtimes(mu, density)
        weighted += (high - low) * sign * ca.mtimes(cosine * mu, density)
    return slope, weighted, mean


def _place(k: int, n: int) -> tuple[int, int]:
    """Return branch and sign of the k-th arc, in the order of w, of a law with n breaks."""
    return (n - k, -1) if k <= n else (k - n - 1, 1)


def _angle(cosine: ca.SX) -> ca.SX:
    """Return acos, clipped; the derivative is zero beyond the ends and finite at them."""
    clipped = ca.fmin(ca.fmax(cosine, -1 + 1e-16), 1 - 1e-16)
    return ca.if_else(cosine >= 1, 0, ca.if_else(cosine <= -1, np.pi, ca.acos(clipped)))


def _distance(
    coarse: Pair, fine: Pair, speeds: tuple[float, float], q_max: float, steep: bool, breaks: list[float]
) -> float:
    """Return the largest difference of two quadratures over intensities and belt speeds."""
    intensities = q_max * np.array([1e-3, 0.03, 0.3, 1.0])
    pairs: list[tuple[int, np.ndarray, np.ndarray]] = []
    outside = [1.03, 1.3, 3.0, 10.0] if steep else [1.0, 1.03, 1.3, 3.0, 10.0]
    for side, shares in enumerate((np.linspace(0, 0.97, 8), np.array(outside))):
        whole, share = np.meshgrid(intensities, shares)
        pairs.append((side, (share * whole).ravel(), whole.ravel()))
    at = np.array([(v, q) for b, q in itertools.product(breaks, intensities) for v in (b, abs(b - q), b + q)])
    at = at[np.abs(at[:, 0] - at[:, 1]) > 0.03 * at[:, 1]] if len(at) else at.reshape(0, 2)
    for side in (0, 1):
        v, q = at[(at[:, 0] > at[:, 1]) == bool(side)].T
        pairs.append((side, v, q))
    largest = 0.0
    for side, v, q in pairs:
        seen = (v >= speeds[0]) & (v <= speeds[1])
        if seen.any():
            one, two = (np.array(f[side](v[seen][None], q[seen][None])[0]) for f in (coarse, fine))
            largest = max(largest, float(np.max(np.abs(one - two))))
    return largest
