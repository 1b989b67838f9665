r"""Friction and damping of a contact damper from its decay, by linear equations.

The work of damper and contact is linear in zeta and mu_m, so that the balance of energy over two half cycles gives
both: a start for `symfric.identify`, which fits the motion itself. Proved in derivations/younes_ashour/record.py.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from symfric.errors import SceneError
from symfric.model.public_names import names_of
from symfric.model.symbols import numbers_of, positive
from symfric.spelling import spelt
from symfric.theory.transient import mean_friction

__all__ = ["DecayFit", "from_motion", "from_turning_points"]
_RESTING = 1e-9  # speed relative to the largest below which the rod of a record without noise rests


class DecayFit(NamedTuple):
    """Parameters of a contact damper that a decay gives.

    Attributes
    ----------
    mu_m : float
        Coefficient of friction at rest.
    zeta : float
        Damping ratio; negative if the decay asks for it, which speaks against the law or the record.
    f_n : float
        Natural frequency, Hz.
    misfit : float
        Largest difference of the balances of energy over the first energy, with these numbers.

    Examples
    --------
    >>> import symfric as sf
    >>> fit = sf.theory.decay_record.from_turning_points([0.010, 0.00706, 0.004, 0.00077], f_n=5.3)
    >>> round(fit.mu_m, 6)
    0.190005
    """

    mu_m: float
    zeta: float
    f_n: float
    misfit: float


@spelt
def from_turning_points(
    amplitudes: Any,
    *,
    f_n: float | None = None,
    t_d: float | None = None,
    r: float = 1.0,
    g: float = 9.81,
    v_c: float = 1.0,
) -> DecayFit:
    r"""Return friction and damping of a contact damper from the sizes of its turning points.

    Parameters
    ----------
    amplitudes : array_like, shape (n,)
        Distances from the middle, m, at the start, at rest, and at each turning point, n >= 3, alternately to the one
        side and the other; the last one, where it stays, is negative if it did not reach the middle any more.
    f_n : float, optional
        Natural frequency, Hz.
    t_d : float, optional
        Decay time, s, from the first to the last of the points; gives f_n = (n - 1)/(2 t_d) if that is not known.
    r, g, v_c : float
        Load of the contact over the weight; gravity, m/s^2; speed over which friction falls by a factor e, m/s, as in
        `symfric.scenes.contact_damper`.

    Returns
    -------
    DecayFit

    Raises
    ------
    SceneError
        If a number is missing or out of range, or the points do not tell friction from damping.

    Notes
    -----
    ``A_i - A_(i+1) = pi zeta a + (2 mu_m r g/omega^2) F(a omega/v_c)`` with ``a = (A_i + A_(i+1))/2`` and F of
    `symfric.theory.transient.mean_friction`: the balance of energy over the half cycle that leads from A_i to -A_(i+1)
    as a cosine about its middle. Exact without damping and with constant friction; else the error is small of second
    order in zeta and in what friction does to the cosine. By least squares where there are more than two half cycles.

    Examples
    --------
    >>> import symfric as sf
    >>> fit = sf.theory.decay_record.from_turning_points([10e-3, 7.064e-3, 3.996e-3, 0.770e-3], f_n=5.3)
    >>> f"mu_m {fit.mu_m:.2f}, zeta {fit.zeta:.3f}"
    'mu_m 0.19, zeta 0.009'
    """
    A = numbers_of(amplitudes, "amplitudes")
    if A.ndim != 1 or A.size < 3 or not np.all(np.isfinite(A)) or np.any(A[:-1] <= 0) or np.any(np.diff(A) >= 0):
        raise SceneError(
            "amplitudes are three or more turning points, each smaller than the one before, positive up to the last"
        )
    if (f_n is None) == (t_d is None):
        raise SceneError("give either f_n, the natural frequency, or t_d, the time from the first to the last point")
    frequency = (A.size - 1) / (2 * positive(t_d, "t_d")) if f_n is None else positive(f_n, "f_n")
    omega = 2 * np.pi * frequency
    a = 0.5 * (A[:-1] + A[1:])
    loads = positive(r, "r") * positive(g, "g")
    rows = np.column_stack([np.pi * a, 2 * loads / omega**2 * mean_friction(a * omega / positive(v_c, "v_c"))])
    zeta, mu_m = _solved(rows, -np.diff(A))
    misfit = np.max(np.abs(rows @ (zeta, mu_m) + np.diff(A)) * 2 * a) / A[0] ** 2
    return DecayFit(float(mu_m), float(zeta), frequency, float(misfit))


@spelt
def from_motion(
    t: Any, x: Any, u: Any = None, *, f_n: float | None = None, r: float = 1.0, g: float = 9.81, v_c: float = 1.0
) -> DecayFit:
    r"""Return friction and damping, and the natural frequency, of a contact damper from a record of its decay.

    Parameters
    ----------
    t, x : array_like, shape (n,)
        Times, s, increasing, and displacements, m, finely sampled.
    u : array_like, shape (n,), optional
        Velocities, m/s; by differences of x unless given.
    f_n : float, optional
        Natural frequency, Hz; from the record unless given.
    r, g, v_c : float
        As in `from_turning_points`.

    Returns
    -------
    DecayFit

    Raises
    ------
    SceneError
        If the record is too short, not increasing in time, or does not tell friction from damping.

    Notes
    -----
    The balance of energy up to each sample, linear in ``omega^2``, ``2 zeta omega`` and ``mu_m r g``:

    .. math:: \tfrac12 (u_0^2 - u^2) + \tfrac{\omega^2}{2}(x_0^2 - x^2)
        = 2\zeta\omega\int u^2\,dt + \mu_m r g \int |u|\,e^{-|u|/v_c}\,dt,

    (5) of Younes and Ashour with the power of the contact written out; by least squares over the samples. Exact for a
    record without noise but for its sampling: no model of the motion enters. Noise in u adds to the integral of its
    square.

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> run = sf.simulate(sf.scenes.contact_damper(f_n=5.3, mu_m=0.19, zeta=0.009))
    >>> t = np.linspace(0, run["stop_time"], 2001)
    >>> fit = sf.theory.decay_record.from_motion(t, *run(t))
    >>> f"mu_m {fit.mu_m:.5f}, zeta {fit.zeta:.5f}, f_n {fit.f_n:.4f}"
    'mu_m 0.19000, zeta 0.00900, f_n 5.3000'
    """
    t, x = numbers_of(t, "t"), numbers_of(x, "x")
    if t.ndim != 1 or t.size < 8 or x.shape != t.shape or not np.all(np.isfinite(x)) or np.any(np.diff(t) <= 0):
        raise SceneError("t and x are rows of eight or more numbers, the times increasing")
    u = np.gradient(x, t, edge_order=2) if u is None else numbers_of(u, "u")
    if u.shape != t.shape or not np.all(np.isfinite(u)):
        raise SceneError("u is a row of as many velocities as there are times")
    loads, v_c = positive(r, "r") * positive(g, "g"), positive(v_c, "v_c")
    moving = np.abs(u) > _RESTING * np.max(np.abs(u))
    end = min(int(np.flatnonzero(moving)[-1]) + 2, t.size) if np.any(moving) else t.size
    t, x, u = t[:end], x[:end], u[:end]
    viscous, contact = _works(t, x, u, v_c)
    left = 0.5 * (u[0] ** 2 - u**2)
    spring = 0.5 * (x[0] ** 2 - x**2)
    if f_n is None:
        square, drag, friction = _solved(np.column_stack([-spring, viscous, contact]), left)
        if not square > 0:
            raise SceneError("the record shows no spring: its displacement does not bring it back")
        omega = float(np.sqrt(square))
    else:
        omega = 2 * np.pi * positive(f_n, "f_n")
        left = left + omega**2 * spring
        drag, friction = _solved(np.column_stack([viscous, contact]), left)
        spring = np.zeros_like(spring)
    balance = viscous * drag + contact * friction - (left + (omega**2 * spring if f_n is None else 0.0))
    energy = 0.5 * (u[0] ** 2 + omega**2 * x[0] ** 2)
    misfit = float(np.max(np.abs(balance)) / energy)
    return DecayFit(float(friction / loads), float(drag / (2 * omega)), omega / (2 * np.pi), misfit)


def _works(t: np.ndarray, x: np.ndarray, u: np.ndarray, v_c: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the integrals of u^2 and of |u| exp(-|u|/v_c) up to each sample, by Simpson's rule."""
    h = np.diff(t)
    # velocity of the cubic through places and velocities
    middle = 1.5 * np.diff(x) / h - 0.25 * (u[:-1] + u[1:])

    def up_to(function: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        parts = h / 6 * (function(u[:-1]) + 4 * function(middle) + function(u[1:]))
        return np.concatenate([[0.0], np.cumsum(parts)])

    return up_to(np.square), up_to(lambda v: np.abs(v) * np.exp(-np.abs(v) / v_c))


def _solved(rows: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Return the least squares solution with columns scaled alike."""
    size = np.linalg.norm(rows, axis=0)
    if np.any(size == 0):
        raise SceneError("nothing moves, so that neither friction nor damping shows")
    solution, _, rank, _ = np.linalg.lstsq(rows / size, left, rcond=1e-10)
    if rank < size.size:
        raise SceneError("the decay does not tell friction from damping; give more half cycles or another start")
    return np.asarray(solution / size)


if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
