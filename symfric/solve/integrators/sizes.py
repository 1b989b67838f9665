"""Sizes of the states of a motion, for the absolute tolerances of the integrators."""

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symfric.lower.automaton import Automaton, arguments_of
from symfric.lower.mode_layout import ModeLayout
from symfric.solve.integrators.mode_functions import mode_integrator

_PART = 1e-3  # time scale of equations without one, relative to the horizon
_TIMES = 16  # times at which forces that depend on time are evaluated
_NODES, _COARSE, _MOST = 64, 1e-7, 20_000  # of a rough motion: nodes, tolerance, steps
_ROUNDS = 2  # rough motions, each with the sizes of the one before


@dataclass(frozen=True)
class Sizing:
    """Functions from which the sizes are determined.

    Attributes
    ----------
    look : casadi.Function
        ``(y, t, p, m) -> (rate, what its change with the state adds in a unit of time, its slopes in y, integrands,
        their slopes)``.
    later : casadi.Function or None
        ``(y, t, p, m) -> (rate, its derivative by time alone)`` where the equations depend on time.
    n_q : int
    layout : ModeLayout
    horizon : float
    """

    look: ca.Function
    later: ca.Function | None
    n_q: int
    layout: ModeLayout
    horizon: float


def make_sizing(automaton: Automaton, field: ca.Function, n_integrals: int, horizon: float) -> Sizing:
    """Build the functions from the rates of an automaton; the first rows of `field` are integrands."""
    y, t, p, m = arguments_of(field)
    rate, _, rows = field(y, t, p, m)
    rows = rows[:n_integrals]
    slopes = ca.jacobian(rate, y)
    out = [ca.densify(e) for e in (rate, slopes @ rate, slopes, rows, ca.jacobian(rows, y))]
    look, later = ca.Function("look", [y, t, p, m], out), None
    if ca.depends_on(rate, t):
        later = ca.Function("later", [y, t, p, m], [ca.densify(rate), ca.densify(ca.jacobian(rate, t))])
    return Sizing(look, later, automaton.n_q, automaton.layout, horizon)


def first_sizes(sizing: Sizing, y: np.ndarray, t: float, p: np.ndarray, m: np.ndarray) -> np.ndarray:
    """Return the sizes of the states and of the appended integrals, none of them zero.

    A coordinate is as large as its velocity and its acceleration make it within a radian of the fastest vibration, and
    so is its velocity within this time; contacts that stick are tried slipping either way. A vibration is what the
    forces of the coordinates alone would do: those of the velocities, which only decay, may be faster by far. Forces
    that come with time act as long as they last. What does not move at all is as large as the others.
    """
    n, layout = sizing.n_q, sizing.layout
    q, u, z = np.abs(y[:n]), np.abs(y[n : 2 * n]), np.abs(y[2 * n :])
    looks, fast, decay, rates = [], [0.0], [0.0], [0.0]
    for way in (-1.0, 1.0) if np.any(m[layout.sticking]) else (1.0,):
        slips = m.copy()
        slips[layout.sticking] = 0.0
        slips[layout.directions] = np.where(m[layout.sticking] > 0, way, m[layout.directions])
        rate, change, slopes, rows, row_slopes = (np.array(e) for e in sizing.look(y, t, p, slips))
        rates.append(_fastest(slopes))
        fast.append(math.sqrt(_fastest(slopes[n : 2 * n, :n])) or rates[-1])
        decay.append(_fastest(slopes[2 * n :, 2 * n :]))
        sudden, lasting = _to_come(sizing, y, t, p, slips)
        looks.append((_size(rate), _size(change), sudden, lasting, _size(rows), _finite(np.abs(row_slopes))))
    time = min(1 / max(fast), sizing.horizon) if max(fast) > 0 else _PART * sizing.horizon
    soon, sooner = (time / max(1.0, time * max(e)) for e in (decay, rates))
    for rate, change, sudden, lasting, _, _ in looks:
        lasting = np.minimum(lasting, time)
        now = time * (rate[n : 2 * n] + sooner * change[n : 2 * n]) + (sudden * lasting)[n : 2 * n]
        u = np.maximum(u, now)
        q = np.maximum(q, time * u)
        z = np.maximum(z, np.minimum(soon, lasting[2 * n :]) * sudden[2 * n :] + soon * rate[2 * n :])
    q, u, z = filled(q), np.maximum(u, filled(q) / time), filled(z)
    sizes = np.concatenate([q, u, z])
    totals = [time * (rows + slopes @ sizes) for *_, rows, slopes in looks]
    return np.concatenate([sizes, filled(np.max(totals, axis=0))])


def rough_motion(field: ca.Function, n_integrals: int, horizon: float) -> ca.Function:
    """Return the integrator of a rough motion over the horizon, for `sizes_along`."""
    return mode_integrator(field, n_integrals, "cvodes", math.inf, _COARSE, horizon, 0, _NODES, _MOST)


def sizes_along(
    rough: ca.Function, sizes: np.ndarray, y: np.ndarray, p: np.ndarray, m: np.ndarray, horizon: float
) -> np.ndarray:
    """Return the largest magnitudes along a rough motion; the given sizes where nothing moves or the motion fails.

    What the forces are at the start says little where it is a layer: bristles that are straight yet are bent within a
    time in which the body hardly moves.
    """
    state = np.append(y, np.zeros(sizes.size - y.size))
    for _ in range(_ROUNDS):
        try:
            scaled = np.array(rough(x0=state / sizes, p=np.concatenate([p, m, sizes, [0.0, horizon]]))["xf"])
        except RuntimeError:
            return sizes
        most = np.maximum(np.max(np.abs(scaled), axis=1) * sizes, np.abs(state))
        if not np.all(np.isfinite(most)):
            return sizes
        sizes = np.where(most > 0, most, sizes)
    return sizes


def _to_come(sizing: Sizing, y: np.ndarray, t: float, p: np.ndarray, m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the change of the rates with explicit time, and its time scale."""
    if sizing.later is None:
        return np.zeros(y.size), np.full(y.size, sizing.horizon)
    looks = [sizing.later(y, t + sizing.horizon * k / _TIMES, p, m) for k in range(_TIMES + 1)]
    rates, slopes = (_finite(np.column_stack([np.array(look[i]) for look in looks])) for i in (0, 1))
    sudden, quick = np.max(np.abs(rates - rates[:, :1]), axis=1), np.max(np.abs(slopes), axis=1)
    return sudden, sudden / np.where(quick > 0, quick, 1.0)


def _fastest(slopes: np.ndarray) -> float:
    """Return the largest rate of linear equations, zero if there is none."""
    return float(np.max(np.abs(np.linalg.eigvals(slopes)), initial=0.0)) if np.all(np.isfinite(slopes)) else 0.0


def _size(e: np.ndarray) -> np.ndarray:
    return _finite(np.abs(e.ravel()))


def _finite(e: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(e), e, 0.0)


def filled(sizes: np.ndarray) -> np.ndarray:
    """Return sizes with the largest in place of zeros, 1 if there is none."""
    return np.where(sizes > 0, sizes, np.max(sizes, initial=0.0) or 1.0)
