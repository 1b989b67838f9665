"""Vibration of the mass on a belt under fast excitation, also where it enters speeds below that of the fast motion."""

from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import NotFound
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import flag
from symfric.model.scene import Scene
from symfric.model.symbols import finite
from symfric.search import zero
from symfric.theory.belt.effective import Q, shaken
from symfric.theory.belt.scene import SYMBOLS, Symbols, value
from symfric.theory.belt.sliding import ETA, V_B1

v_b, beta, gamma2, a, Omega, mu_s, mu_m, v_m = SYMBOLS
AMPLITUDE = sp.Symbol("A", positive=True)
_PHASE = sp.Symbol("psi", positive=True)
_NODES = 400  # of the quadrature over each arc


@alone(SYMBOLIC)
def excited_growth(scene: Scene | None = None, amplitude: Any = None, *, symbolic: bool = False) -> float | sp.Expr:
    r"""Return the averaged growth A' of a vibration of amplitude A under fast excitation, dimensionless.

    Parameters
    ----------
    scene : Scene
        `symfric.scenes.mass_on_belt` with a Omega > 0.
    amplitude : float
        A >= 0, of the slow motion.
    symbolic : bool
        Return the formula in `SYMBOLS` and A, with an integral over the phase.

    Returns
    -------
    float or Expr

    Notes
    -----
    Thomsen (13) with the effective friction (47). Outside :math:`|v_r| < q = a\Omega` it is a cubic; inside, with w =
    v_b - A cos(psi), it is smaller by :math:`(2\mu_s/\pi) \arccos(w/q)`, which brakes:

    .. math:: A' = -\frac A2\Big(2\beta - \eta\Big(1 - \frac{v_b^2 + q^2/2}{v_m^2}\Big)
        + \frac{\eta A^2}{4 v_m^2}\Big) - \frac{2\gamma^2\mu_s}{\pi^2}
        \int_0^\pi \arccos\Big(\min\big(1, \max\big(-1, \tfrac{v_b - A\cos\psi}{q}\big)\big)\Big)
        \cos\psi\,d\psi

    Beyond the source; derivations/thomsen/energy.py.

    Examples
    --------
    >>> import symfric as sf
    >>> shaken = sf.scenes.mass_on_belt(v_b=0.2, a=0.005, Omega=50.0)
    >>> round(sf.theory.belt.excited_growth(shaken, 0.1), 6)
    -0.071432
    """
    if flag(symbolic, "symbolic"):
        ratio = sp.Min(1, sp.Max(-1, (v_b - AMPLITUDE * sp.cos(_PHASE)) / Q))
        braking = sp.Integral(sp.acos(ratio) * sp.cos(_PHASE), (_PHASE, 0, sp.pi))
        return _outside(AMPLITUDE) - 2 * gamma2 * mu_s / sp.pi**2 * braking
    given = shaken(scene)
    return float(_growth(given, np.array([finite(amplitude, "amplitude")]))[0])


@alone(SYMBOLIC)
def excited_amplitude(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the amplitude of the slow motion of self-excited vibration under fast excitation, dimensionless.

    Parameters
    ----------
    scene : Scene
        `symfric.scenes.mass_on_belt` with a Omega > 0.
    symbolic : bool
        Return the closed form that holds while the vibration stays outside ``|v_r| < a Omega``.

    Returns
    -------
    float or Expr

    Raises
    ------
    NotFound
        If steady sliding is stable: see `unstable_speeds`.
    SceneError
        If the scene is another one or has no excitation.

    Notes
    -----
    ``2 sqrt(v_b1^2 - v_b^2 - (a Omega)^2/2)``, after Thomsen (56), as long as it is at most ``v_b - a Omega``, which
    holds for belt speeds from ``(a Omega + sqrt(20 v_b1^2 - 14 (a Omega)^2))/5`` on; first order in eta, as (20).
    On slower belts the mass enters ``|v_r| < a Omega``, where the effective friction drops towards 0 and brakes it at
    once. That is no small force any more, so that the mean over a cycle, `excited_growth`, is low by a tenth or two:
    the amplitude is then half the range of the periodic solution of (40) with (47), from a return map of one unknown.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.mass_on_belt(v_b=0.41, a=0.004, Omega=50.0)
    >>> round(sf.theory.belt.excited_amplitude(scene), 6)
    0.159304
    >>> round(sf.theory.belt.excited_amplitude(scene.where({"v_b": 0.3})), 4)
    0.124
    """
    outside = 2 * sp.sqrt(V_B1**2 - v_b**2 - Q**2 / 2)
    if flag(symbolic, "symbolic"):
        return outside
    given = shaken(scene)
    q = given.a * given.Omega
    if not (value(ETA, given) > 2 * given.beta and q < given.v_b):
        raise NotFound(f"no self-excited vibration at v_b = {given.v_b:g} and a Omega = {q:g}: see unstable_speeds")
    square = value(V_B1**2 - v_b**2 - Q**2 / 2, given)
    if square <= 0:
        raise NotFound(f"no self-excited vibration at v_b = {given.v_b:g}: the belt is faster than unstable_speeds")
    amplitude = 2 * float(np.sqrt(square))
    return amplitude if amplitude <= given.v_b - q else _entering(given, amplitude)


def _entering(given: Symbols, high: float) -> float:
    """Return half the range of the cycle of the slow motion, of at most about the amplitude `high`."""
    from scipy.integrate import solve_ivp

    q, v = given.a * given.Omega, given.v_b
    rest = _effective(given, v)

    def field(_t: float, y: np.ndarray) -> tuple[float, float]:
        return y[1], -y[0] - 2 * given.beta * y[1] + given.gamma2 * (_effective(given, v - y[1]) - rest)

    def other_side(place: float) -> float:
        def turn(_t: float, y: np.ndarray) -> float:
            return float(y[1])

        vars(turn).update(terminal=True, direction=1.0 if place > 0 else -1.0)  # as `solve_ivp` takes them
        run = solve_ivp(field, (0, 50), [place, 0.0], "DOP853", events=turn, rtol=1e-11, atol=1e-13)
        return float(run.y_events[0][0][0])

    def growth(place: float) -> float:
        return other_side(other_side(place)) - place

    top = 2 * high + q
    while growth(top) > 0:
        top *= 2
    place = zero(growth, 1e-3 * (v - q), top, xtol=1e-13, rtol=1e-12)
    return 0.5 * (place - other_side(place))


def _effective(given: Symbols, w: float) -> float:
    """Return the effective friction (47) for a relative velocity, odd."""
    q, size = given.a * given.Omega, abs(w)
    fall = given.mu_s - given.mu_m
    smooth = -1.5 * fall / given.v_m * size + 0.5 * fall / given.v_m**3 * (size**3 + 1.5 * q**2 * size)
    jump = given.mu_s * (2 / np.pi * np.arcsin(size / q) if size < q else 1.0)
    return float(np.sign(w) * (jump + smooth))


def _outside(amplitude: sp.Expr) -> sp.Expr:
    """Return the growth by damper and cubic friction alone."""
    slope = 2 * beta - ETA * (1 - (v_b**2 + Q**2 / 2) / v_m**2)
    return -amplitude / 2 * (slope + ETA * amplitude**2 / (4 * v_m**2))


def _growth(given: Symbols, amplitude: np.ndarray) -> np.ndarray:
    """Return the averaged growth for amplitudes, shape (n,)."""
    x, weights = np.polynomial.legendre.leggauss(_NODES)
    q, v = given.a * given.Omega, given.v_b
    size = np.maximum(amplitude, 1e-300)
    inner, outer = (np.arccos(np.clip((v + side * q) / size, -1.0, 1.0)) for side in (1, -1))  # w = -q and w = q
    t = np.pi / 4 * (x + 1)
    psi = outer[:, None] + (inner - outer)[:, None] * np.sin(t) ** 2  # the integrand starts and ends as a root
    w = np.clip((v - amplitude[:, None] * np.cos(psi)) / q, -1.0, 1.0)
    density = np.sin(2 * t) * weights * np.pi / 4
    between = (inner - outer) * np.sum(np.arccos(w) * np.cos(psi) * density, axis=1)
    reversed_ = np.pi * np.sin(inner)  # from psi = 0 to `inner` the slip is beyond -q, and the angle is pi
    eta = value(ETA, given)
    slope = 2 * given.beta - eta * (1 - (v**2 + q**2 / 2) / given.v_m**2)
    cubic = -amplitude / 2 * (slope + eta * amplitude**2 / (4 * given.v_m**2))
    return np.asarray(cubic - 2 * given.gamma2 * given.mu_s / np.pi**2 * (reversed_ - between))
