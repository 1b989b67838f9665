r"""A disc of uniform pressure that slides and spins: friction, torque, and the stop of both at once.

With the sliding speed v of the middle and ``W = R |omega|`` of the rim, X the larger and x the smaller one, everything
follows from the arithmetic-geometric mean of ``X`` and ``sqrt(X^2 - x^2)``, whose differences are positive sums: no
digits are lost for v << W, v >> W or v = W. Coulomb friction; derivations/plane.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.elliptic import geometric_mean
from symfric.model.results import Result
from symfric.model.symbols import expression, numbers_of, positive
from symfric.search import zero
from symfric.spelling import spelt

_EQUAL = 1e-19  # least (X^2 - x^2)/X^2, where the mean would vanish: below rounding of the result
_NEAR = 1e-9  # the same in expressions: solvers need power series, also on their way through v = W


class DiscFriction(NamedTuple):
    """Friction of a spinning disc.

    Attributes
    ----------
    force : float or ndarray
        Against the velocity of the middle.
    torque : float or ndarray
        Against the spin.
    """

    force: Any
    torque: Any


@dataclass(frozen=True)
class DiscStop(Result):
    """Where and when a sliding and spinning disc stops.

    Attributes
    ----------
    time, distance, angle : float
        From the start to rest; `distance` along the straight path of the middle, `angle` turned.
    ratio : float
        Limit of ``v/(R omega)`` at the stop; infinite without spin.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.theory.plane.disc_stop(0.5, 1.0, R=1.0, m=1.0, mu=1.0, g=1.0)
    >>> print(f"{found.time:.9f} {found.distance:.9f}")
    0.951610063 0.245874475
    """

    time: float
    distance: float
    angle: float
    ratio: float


@spelt
def spinning_disc_friction(v: Any, omega: Any, R: float = 1.0, load: float = 1.0) -> DiscFriction:
    r"""Return friction force and torque of a disc of uniform pressure that slides and spins.

    Parameters
    ----------
    v : float or array_like
        Speed of the middle; the force has its sign.
    omega : float or array_like
        Spin, rad/time; the torque has its sign.
    R : float
        Radius, > 0.
    load : float
        ``mu N``, force, >= 0.

    Returns
    -------
    DiscFriction
        ``(force, torque)``, both against the motion; zero at rest, where any pair inside the limit is possible.

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    P. Contensou (1963); R. I. Leine and C. Glocker, European Journal of Mechanics A 22 (2003) 193. For ``eps = v/(R
    omega) < 1``, with the modulus eps,

    .. math:: F = \frac{4\mu N}{3\pi\varepsilon}\big((\varepsilon^2 + 1)E + (\varepsilon^2 - 1)K\big), \quad
        T = \frac{4\mu N R}{9\pi}\big((4 - 2\varepsilon^2)E + (\varepsilon^2 - 1)K\big).

    They are written here as ``F = mu N v G`` and ``T = mu N R^2 omega H`` with G and H that are regular everywhere but
    at rest; F tends to ``mu N v/(R omega)`` for little sliding: friction is a damper then, and sticking ends at the
    slightest force.

    Examples
    --------
    >>> import symfric as sf
    >>> force, torque = sf.theory.plane.spinning_disc_friction(0.1, 1.0)
    >>> print(f"{force:.6f} {torque:.6f}")
    0.099875 0.661676
    """
    R, load = positive(R, "R"), positive(load, "load", zero=True)
    given, spin = numbers_of(v, "v"), numbers_of(omega, "omega") * R
    try:
        given, spin = np.broadcast_arrays(given, spin)
    except ValueError:
        raise SceneError(f"v has the shape {given.shape} and omega {spin.shape}; give shapes that broadcast") from None
    if not np.all(np.isfinite(given) & np.isfinite(spin)):
        raise SceneError("v or omega is not finite; give finite numbers")
    scale = np.maximum(np.abs(given), np.abs(spin))
    with np.errstate(invalid="ignore", divide="ignore"):
        G, H = _regular((given / scale) ** 2, (spin / scale) ** 2)
        force = np.where(scale > 0, load * G * (given / scale), 0.0)
        torque = np.where(scale > 0, load * R * H * (spin / scale), 0.0)
    return DiscFriction(force, torque) if force.ndim else DiscFriction(float(force), float(torque))


def _regular(v2: np.ndarray, W2: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return ``F/(mu N v)`` and ``T/(mu N R W)`` for squares of the speeds the larger of which is 1."""
    x2 = np.minimum(v2, W2)
    a, b = np.ones_like(x2), np.sqrt(np.maximum((1 - np.sqrt(x2)) * (1 + np.sqrt(x2)), _EQUAL))
    d, factor, tau = np.ones_like(x2), 1.0, np.zeros_like(x2)
    for n in range(12):
        a, b = (a + b) / 2, np.sqrt(a * b)
        d = (1.0 if n == 0 else x2) * d**2 / (4 * a)  # c_(n + 2)/x^2
        factor *= 2
        tau = tau + factor * d**2
    G = (3 - x2 - (1 + x2) * x2 * tau) / (3 * a)
    slow = 2 / (9 * a) * (1 + (1 - 2 * x2) * tau)
    fast = 2 / (9 * a) * (3 - 3 * x2 + x2**2 - (2 - x2) * x2**2 * tau)
    return G, np.where(v2 > W2, slow, fast)


@alone(SYMBOLIC)
def disc_expressions(u: Any, w: Any, omega: Any, R: Any) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return force and torque of a sliding and spinning disc as expressions, for the forces of a scene.

    Parameters
    ----------
    u, w : Expr
        Components of the velocity of the middle.
    omega : Expr
        Spin.
    R : Expr or float
        Radius, > 0.

    Returns
    -------
    tuple of Expr
        ``(F_u, F_w, T)`` on the disc per ``mu N``: to be multiplied by it and added to the forces of u, w and omega.

    Raises
    ------
    SceneError
        If an argument is no expression.

    Notes
    -----
    `spinning_disc_friction` from square roots alone, with a branch at ``v = R |omega|``: 13 digits, and 8 within a
    millionth of that ratio, where the exact ones have no power series and a rounded corner of 1e-9 takes their place.
    They have no value at rest: a disc stops sliding and spinning at once, `disc_stop`, and a run ends there.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> u, w, om = sp.symbols("u w omega", real=True)
    >>> forces = sf.theory.plane.disc_expressions(u, w, om, 1.0)
    >>> [round(float(f.subs({u: 0.1, w: 0.0, om: 1.0})), 6) for f in forces]
    [-0.099875, 0.0, -0.661676]
    """
    named = {"u": u, "w": w, "omega": omega, "R": R}
    u, w, omega, R = (expression(value, f"the argument {name}") for name, value in named.items())
    v2, W2 = u**2 + w**2, (R * omega) ** 2
    pieces = [_regular_expressions(*order) for order in ((W2, v2), (v2, W2))]
    G = sp.Piecewise((pieces[0].G, W2 > v2), (pieces[1].G, True))
    H = sp.Piecewise((pieces[0].fast, W2 > v2), (pieces[1].slow, True))
    return -G * u, -G * w, -H * R**2 * omega


class _Regular(NamedTuple):
    G: sp.Expr
    slow: sp.Expr
    fast: sp.Expr


def _regular_expressions(X2: sp.Expr, x2: sp.Expr) -> _Regular:
    """Return ``F/(mu N v)``, and ``T/(mu N R W)`` for ``v > W`` and ``v < W``, of the larger and smaller square."""
    X = sp.sqrt(X2)
    apart = (X2 - x2) / X2
    b2 = sp.sqrt(apart**2 + sp.Float(_NEAR) ** 2)  # no power series exists at v = W itself
    r = 1 - b2  # x2/X2
    mean, squares = geometric_mean(sp.sqrt(b2), r)
    tau = 2 * squares
    return _Regular(
        (3 - r - (1 + r) * r * tau) / (3 * mean * X),
        2 / (9 * mean * X) * (1 + (1 - 2 * r) * tau),
        2 / (9 * mean * X) * (3 - 3 * r + r**2 - (2 - r) * r**2 * tau),
    )


@spelt
def disc_stop_ratio(inertia: float = 0.5) -> float:
    r"""Return the ratio ``v/(R omega)`` with which a sliding and spinning disc stops.

    Parameters
    ----------
    inertia : float
        ``J/(m R^2)``, > 0.

    Returns
    -------
    float
        0 from 2/3 on: the disc spins last, as a ring does; infinite up to 1/4: it slides last. In between the same for
        every start that has both.

    Raises
    ------
    SceneError
        If the inertia is not positive.

    Notes
    -----
    ``F(eps) inertia = eps T(eps)/R``: a fixed point of the ratio, which every motion tends to. Z. Farkas, G. Bartels,
    T. Unger and D. E. Wolf, Physical Review Letters 90 (2003) 248302; the bounds from ``F = eps``, ``T = 2/3`` for
    little sliding and ``F = 1``, ``T = 1/(4 eps)`` for little spin.

    Examples
    --------
    >>> import symfric as sf
    >>> f"{sf.theory.plane.disc_stop_ratio():.10f}"
    '0.6530017892'
    """
    kappa = positive(inertia, "inertia")
    if kappa >= 2 / 3 or kappa <= 0.25:
        return 0.0 if kappa >= 2 / 3 else math.inf
    angle = zero(lambda a: _turning(a, kappa) / (math.sin(a) * math.cos(a)), 1e-12, math.pi / 2 - 1e-12, rtol=1e-15)
    return math.tan(angle)


@spelt
def disc_stop(
    v: float, omega: float, *, R: float, m: float, mu: float, g: float = 9.81, inertia: float = 0.5
) -> DiscStop:
    r"""Return when and where a disc on a level table stops sliding and spinning.

    Parameters
    ----------
    v, omega : float
        Speed and spin at the start, >= 0.
    R, m : float
        Radius and mass, > 0; the mass has no effect.
    mu, g : float
        Coefficient of friction, gravity, > 0.
    inertia : float
        ``J/(m R^2)``, > 0; 1/2 for a uniform disc.

    Returns
    -------
    DiscStop

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    ``m v' = -F``, ``J omega' = -T`` with `spinning_disc_friction`, in polar form ``v = rho sin a``, ``R omega = rho cos
    a`` and with the time scaled by rho, ``dt = rho ds``: regular up to the stop, where rho falls exponentially with s
    and a tends to `disc_stop_ratio`. Twelve digits.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.plane.disc_stop(1.0, 0.0, R=0.1, m=1.0, mu=0.5, g=10.0).distance
    0.1
    """
    named = {"R": R, "m": m, "mu": mu, "g": g, "inertia": inertia}
    R, _, mu, g, kappa = (positive(value, name) for name, value in named.items())
    v, spin = positive(v, "v", zero=True), positive(omega, "omega", zero=True) * R
    drag = mu * g
    if v == 0 or spin == 0:
        ratio = 0.0 if spin else math.inf
        decay = drag if v else drag * 2 / 3 / kappa  # of v or of R omega
        start = max(v, spin)
        way = start**2 / (2 * decay)
        return DiscStop(start / decay, way if v else 0.0, way / R if spin else 0.0, ratio)
    time, distance, turned = _stopping(v, spin, kappa)
    return DiscStop(time / drag, distance / drag, turned / drag / R, disc_stop_ratio(kappa))


def _turning(angle: float, kappa: float) -> float:
    """Return ``da/ds`` over ``mu g``."""
    force, torque = spinning_disc_friction(math.sin(angle), math.cos(angle))
    return -force * math.cos(angle) + torque / kappa * math.sin(angle)


def _stopping(v: float, spin: float, kappa: float) -> tuple[float, float, float]:
    """Return time, distance and way of the rim to the stop, all times ``mu g``."""
    from scipy.integrate import solve_ivp

    start = math.hypot(v, spin)

    def rates(_s: float, y: np.ndarray) -> list[float]:
        log_rho, angle = y[:2]
        sine, cosine = math.sin(angle), math.cos(angle)
        force, torque = spinning_disc_friction(sine, cosine)
        fall = -force * sine - torque / kappa * cosine
        rho = math.exp(log_rho)
        turn = -force * cosine + torque / kappa * sine
        return [fall, turn, rho, rho**2 * sine, rho**2 * cosine]

    end = 45.0 * max(1.0, 1.5 * kappa)  # rho falls by exp(-F) at least with one unit of s
    run = solve_ivp(rates, (0.0, end), [0.0, math.atan2(v, spin), 0, 0, 0], "DOP853", rtol=3e-14, atol=1e-16)
    time, distance, rim = (float(e) for e in run.y[2:, -1])
    return time * start, distance * start**2, rim * start**2
