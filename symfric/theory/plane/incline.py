r"""A block on an incline with Coulomb friction: speed, time and place in closed form over the direction of its motion.

The direction is the angle theta between the velocity and the line of steepest descent, 0 down, pi up. With ``p = g sin
alpha`` down the slope and the friction ``d = mu g cos alpha``: :math:`v' = p\cos\theta - d`, :math:`\theta' =
-p\sin\theta/v`. The second has no limit as v vanishes; over theta instead of the time it is regular.
"""

import math
from dataclasses import dataclass

from symfric.errors import NotFound, SceneError
from symfric.model.results import Result
from symfric.model.symbols import finite, positive
from symfric.spelling import spelt


@dataclass(frozen=True)
class InclineState(Result):
    """A block on an incline at one instant.

    Attributes
    ----------
    time : float
        From the start.
    downslope, cross : float
        Place, from the start: down the line of steepest descent, and across it, to the side of the motion.
    speed, direction : float
        Of the motion; the angle from the line of steepest descent, rad.

    Examples
    --------
    >>> import math
    >>> import symfric as sf
    >>> slope = math.radians(20)
    >>> rest = sf.theory.plane.incline_stop(slope, 1.5 * math.tan(slope), speed=1.0)
    >>> sorted(rest.to_dict())
    ['cross', 'direction', 'downslope', 'speed', 'time']
    """

    time: float
    downslope: float
    cross: float
    speed: float
    direction: float


@spelt
def incline_stop(
    slope: float, mu: float, speed: float, direction: float = math.pi / 2, g: float = 9.81
) -> InclineState:
    r"""Return when, where and with which direction a block on an incline stops.

    Parameters
    ----------
    slope : float
        Angle alpha of the incline, 0 <= alpha < pi/2.
    mu : float
        Kinetic coefficient of friction.
    speed : float
        At the start, >= 0.
    direction : float
        At the start, 0 <= theta <= pi from the line of steepest descent.
    g : float
        Gravity, > 0.

    Returns
    -------
    InclineState
        With the speed 0; the direction is 0, down the slope, unless the block goes straight up or the table is level.

    Raises
    ------
    NotFound
        If the friction is not above the pull, ``mu <= tan alpha``, and the block does not go straight up: it slides on.
    SceneError
        If a number is out of range.

    Notes
    -----
    :math:`T = v_0\frac{d + p\cos\theta_0}{d^2 - p^2}`, :math:`x = v_0^2\big(\frac{c^4}{2(d - p)} - \frac{s^4}{2(d +
    p)}\big)`, :math:`y = 2v_0^2 sc\big(\frac{c^2}{2d - p} + \frac{s^2}{2d + p}\big)` with s, c the sine and cosine of
    :math:`\theta_0/2`; derivations/plane. For the stop, the side that the static coefficient decides is trivial: the
    block that stops is held by the kinetic one already.

    Examples
    --------
    >>> import math
    >>> import symfric as sf
    >>> slope = math.radians(20)
    >>> rest = sf.theory.plane.incline_stop(slope, 1.5 * math.tan(slope), speed=1.0)
    >>> print(f"{rest.time:.12f} {rest.downslope:.12f} {rest.cross:.12f}")
    0.357651914393 0.059608652399 0.111766223248
    """
    p, d, v, theta = _given(slope, mu, speed, direction, g)
    if theta == math.pi and d + p > 0:
        return InclineState(v / (d + p), -(v**2) / (2 * (d + p)), 0.0, 0.0, math.pi)
    if not d > p:
        raise NotFound(
            f"the block does not stop: mu = {mu:g} is not above tan(slope) = {math.tan(slope):g}; see incline_motion"
        )
    s, c = math.sin(theta / 2), math.cos(theta / 2)
    time = v * ((d + p) * c**2 + (d - p) * s**2) / ((d - p) * (d + p))
    down = v**2 * (c**4 / (2 * (d - p)) - s**4 / (2 * (d + p)))
    cross = 2 * v**2 * s * c * (c**2 / (2 * d - p) + s**2 / (2 * d + p))
    return InclineState(time, down, cross, 0.0, 0.0 if p else theta)


@spelt
def incline_motion(
    slope: float, mu: float, speed: float, direction: float, later: float, g: float = 9.81
) -> InclineState:
    r"""Return the state of a block on an incline when its motion has turned to a given direction.

    Parameters
    ----------
    slope, mu, speed, direction, g
        As in `incline_stop`; ``0 < slope``, ``0 < direction < pi``, ``0 < speed``.
    later : float
        The later direction, ``0 < later <= direction``.

    Returns
    -------
    InclineState

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    With ``k = d/p`` and ``z = tan(theta/2)``: :math:`v = C z^{k-1}(1 + z^2)/2`, :math:`dt = -\frac{C}{2p}z^{k-2}(1 +
    z^2)\,dz`; place and time are differences of powers of z, of logarithms where an exponent vanishes. Any
    friction, also blocks that do not stop; derivations/plane.

    Examples
    --------
    >>> import math
    >>> import symfric as sf
    >>> slope = math.radians(20)
    >>> found = sf.theory.plane.incline_motion(slope, math.tan(slope), 1.0, math.pi / 2, 1e-6)
    >>> f"{found.speed:.9f}"
    '0.500000000'
    """
    p, d, v, theta = _given(slope, mu, speed, direction, g)
    end = finite(later, "later")
    if not (p > 0 and v > 0 and 0 < end <= theta < math.pi):
        raise SceneError("incline_motion takes slope > 0, speed > 0 and 0 < later <= direction < pi")
    k, z0, z1 = d / p, math.tan(theta / 2), math.tan(end / 2)
    # in r = z/z0, so that no power of z0 overflows: v = v0 r^(k-1) (1 + z^2)/(1 + z0^2)
    start, log = 2 * v / (1 + z0**2), math.log(z1 / z0)

    def between(exponent: float) -> float:
        """Return the integral of r^(exponent - 1) from z1/z0 to 1."""
        return -math.expm1(exponent * log) / exponent if exponent else -log

    time = start / (2 * p) * (between(k - 1) / z0 + z0 * between(k + 1)) * z0
    down = start**2 / (4 * p) * (between(2 * k - 2) - z0**4 * between(2 * k + 2))
    cross = start**2 / (2 * p) * z0 * (between(2 * k - 1) + z0**2 * between(2 * k + 1))
    return InclineState(time, down, cross, start / 2 * math.exp((k - 1) * log) * (1 + z1**2), end)


@spelt
def incline_least_speed(slope: float, mu: float, speed: float, direction: float, g: float = 9.81) -> float:
    r"""Return the least speed of a block that turns on an incline on which it does not stop.

    Parameters
    ----------
    slope, mu, speed, direction, g
        As in `incline_motion`.

    Returns
    -------
    float
        Of the later motion.

    Raises
    ------
    NotFound
        If the block stops, or its speed falls for ever: ``mu >= tan alpha``.
    SceneError
        If a number is out of range.

    Notes
    -----
    The speed is least where ``cos theta = k = mu/tan alpha``. A block that goes up at a small angle delta from the line
    of steepest descent passes a speed of the order :math:`\delta^{1+k}` there, and turns around within a time of the
    same order: a solver in Cartesian velocities takes steps as small as that, while the direction changes by pi.

    Examples
    --------
    >>> import math
    >>> import symfric as sf
    >>> slope = math.radians(20)
    >>> up = math.pi - 1e-4
    >>> f"{sf.theory.plane.incline_least_speed(slope, 0.5 * math.tan(slope), 1.0, up):.3e}"
    '6.204e-07'
    """
    p, d, v, theta = _given(slope, mu, speed, direction, g)
    if not d < p:
        raise NotFound(
            f"the speed falls to zero or for ever: mu = {mu:g} is not below tan(slope) = {math.tan(slope):g}"
        )
    turning = math.acos(d / p)
    return v if theta <= turning else incline_motion(slope, mu, speed, direction, turning, g).speed


def _given(slope: float, mu: float, speed: float, direction: float, g: float) -> tuple[float, float, float, float]:
    """Return pull, friction, speed and direction."""
    alpha = positive(slope, "slope", zero=True)
    if not alpha < math.pi / 2:
        raise SceneError(f"slope is {alpha:g}; it is an angle in rad below pi/2")
    theta = finite(direction, "direction")
    if not 0 <= theta <= math.pi:
        raise SceneError(f"direction is {theta:g}; it is an angle between 0, down the slope, and pi, up")
    g = positive(g, "g")
    return (
        g * math.sin(alpha),
        positive(mu, "mu", zero=True) * g * math.cos(alpha),
        positive(speed, "speed", zero=True),
        theta,
    )
