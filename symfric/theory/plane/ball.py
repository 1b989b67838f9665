"""A ball that slides on a level table until it rolls."""

import math
from dataclasses import dataclass

from symfric.model.results import Result
from symfric.model.symbols import finite, pair, positive
from symfric.spelling import spelt

Pair = tuple[float, float]


@dataclass(frozen=True)
class BallRolls(Result):
    """When and where a sliding ball starts to roll.

    Attributes
    ----------
    time : float
        From the start.
    place : (float, float)
        Of the middle, from where it was.
    velocity : (float, float)
        Of the middle, kept from then on.
    distance : float
        Length of the path, a parabola.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.theory.plane.ball_rolls((7.0, 0.0), r=1.0, mu=0.2, g=10.0)
    >>> f"{found.time:.6f} {found.velocity[0]:.6f} {found.place[0]:.6f}"
    '1.000000 5.000000 6.000000'
    """

    time: float
    place: Pair
    velocity: Pair
    distance: float


@spelt
def ball_rolls(
    velocity: Pair, spin: Pair = (0.0, 0.0), *, r: float, mu: float, g: float = 9.81, inertia: float = 0.4
) -> BallRolls:
    r"""Return when and where a ball on a level table starts to roll without sliding.

    Parameters
    ----------
    velocity : (float, float)
        Of the middle at the start, along x and y; z points up.
    spin : (float, float)
        Angular velocity about the axes x and y at the start; that about z has no effect on a point contact.
    r : float
        Radius, > 0.
    mu, g : float
        Coefficient of friction, gravity, > 0.
    inertia : float
        ``J/(m r^2)``, > 0; 2/5 for a solid ball, 2/3 for a shell.

    Returns
    -------
    BallRolls

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    The slip of the contact ``s = (v_x - r omega_y, v_y + r omega_x)`` obeys ``s' = -mu g (1 + 1/inertia) s/|s|``: its
    direction is constant, so that friction is too, and the path is a parabola, G. Coriolis (1835).

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.theory.plane.ball_rolls((1.0, 0.0), (-20.0, 0.0), r=0.1, mu=0.2)
    >>> f"{found.velocity[0]:.6f} {found.velocity[1]:.6f}"
    '0.714286 0.571429'
    """
    vx, vy = (finite(value, "velocity") for value in pair(velocity, "velocity"))
    ox, oy = (finite(value, "spin") for value in pair(spin, "spin"))
    r, mu, g, kappa = (positive(v, n) for n, v in {"r": r, "mu": mu, "g": g, "inertia": inertia}.items())
    sx, sy = vx - r * oy, vy + r * ox
    slip = math.hypot(sx, sy)
    if slip == 0:
        return BallRolls(0.0, (0.0, 0.0), (vx, vy), 0.0)
    time = slip / (mu * g * (1 + 1 / kappa))
    share = 1 / (1 + 1 / kappa)  # of the slip that the velocity loses
    end = vx - share * sx, vy - share * sy
    place = (vx + end[0]) / 2 * time, (vy + end[1]) / 2 * time
    direction = sx / slip, sy / slip
    return BallRolls(time, place, end, _length((vx, vy), direction, mu * g, time))


def _length(v: Pair, direction: Pair, brake: float, time: float) -> float:
    """Return the length of a path with a constant acceleration `brake` against `direction`."""
    along = v[0] * direction[0] + v[1] * direction[1]
    across = abs(v[0] * direction[1] - v[1] * direction[0])

    def primitive(w: float) -> float:
        return (w * math.hypot(w, across) + (across**2 * math.asinh(w / across) if across else 0.0)) / 2

    return (primitive(along) - primitive(along - brake * time)) / brake
