"""Points and bodies that move in a plane: gap and slip of a point, or a disc, against a line or a circle."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.symbols import TIME, counted, expression, listed, shortened

Vector = tuple[sp.Expr, sp.Expr]


class Touch(NamedTuple):
    """How a point stands to what it may touch.

    Attributes
    ----------
    gap : Expr
        Distance along the normal, positive while it is apart.
    slip : Expr
        Velocity of the point less that of the surface, along the tangent, which is the normal turned by -90 degrees;
        linear in the velocities u.
    normal : tuple of Expr
        Unit vector from the surface to the point.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, y, u, v = sp.symbols("x y u v", real=True)
    >>> gap, slip, normal = sf.mechanics.against_line(sf.mechanics.Point(x, y, q=[x, y], u=[u, v]))
    >>> gap, slip, normal
    (y, u, (0, 1))
    """

    gap: sp.Expr
    slip: sp.Expr
    normal: Vector


@dataclass(frozen=True)
class Point:
    """A point of a body that moves in a plane.

    Attributes
    ----------
    x, y : Expr
        Its place, of coordinates, time and parameters.
    q, u : sequences of Symbol
        The coordinates and velocities of the system.
    theta : Expr
        Angle by which its body is turned, counter-clockwise, if the point is the centre of a disc or of a circle.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> phi, omega = sp.symbols("phi omega", real=True)
    >>> bob = sf.mechanics.Point(sp.sin(phi), -sp.cos(phi), q=[phi], u=[omega])
    >>> bob.velocity
    (omega*cos(phi), omega*sin(phi))
    >>> bob.rate(phi**2), bob.spin
    (2*omega*phi, 0)
    """

    x: sp.Expr
    y: sp.Expr
    q: Sequence[sp.Symbol]
    u: Sequence[sp.Symbol]
    theta: sp.Expr = sp.S.Zero

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        _read(self, ("x", "y", "theta"), "a point")

    @property
    def velocity(self) -> Vector:
        """Rates of x and y, linear in u."""
        return self.rate(self.x), self.rate(self.y)

    @property
    def spin(self) -> sp.Expr:
        """Rate of theta."""
        return self.rate(self.theta)

    def rate(self, e: sp.Expr) -> sp.Expr:
        """Return the rate of an expression of coordinates and time.

        Parameters
        ----------
        e : Expr

        Returns
        -------
        Expr
            Linear in u.
        """
        return _rate(e, self.q, self.u)


@dataclass(frozen=True)
class Body:
    """A rigid body that moves in a plane.

    Attributes
    ----------
    x, y : Expr
        Place of its centre, of coordinates, time and parameters; often two of the coordinates.
    theta : Expr
        Angle by which it is turned, counter-clockwise.
    q, u : sequences of Symbol
        The coordinates and velocities of the system.

    Examples
    --------
    A rod of length 2 that stands on the floor with its lower end:

    >>> import sympy as sp
    >>> import symfric as sf
    >>> q = x, y, theta = sp.symbols("x y theta", real=True)
    >>> u = sp.symbols("u v omega", real=True)
    >>> rod = sf.mechanics.Body(x, y, theta, q=q, u=u)
    >>> sf.mechanics.against_line(rod.point(-1, 0)).gap
    y - sin(theta)
    >>> m, J = sp.symbols("m J", positive=True)
    >>> rod.kinetic(m, J)
    J*omega**2/2 + m*(u**2 + v**2)/2
    """

    x: sp.Expr
    y: sp.Expr
    theta: sp.Expr
    q: Sequence[sp.Symbol]
    u: Sequence[sp.Symbol]

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        _read(self, ("x", "y", "theta"), "a body")

    @alone(SYMBOLIC)
    def point(self, a: float | sp.Expr, b: float | sp.Expr) -> Point:
        """Return a point of the body.

        Parameters
        ----------
        a, b : float or Expr
            Its place from the centre, along the axes that turn with the body.

        Returns
        -------
        Point
        """
        a, b = expression(a, "a of a point"), expression(b, "b of a point")
        c, s = sp.cos(self.theta), sp.sin(self.theta)
        return Point(self.x + a * c - b * s, self.y + a * s + b * c, self.q, self.u, self.theta)

    @alone(SYMBOLIC)
    def direction(self, a: float | sp.Expr, b: float | sp.Expr) -> Vector:
        """Return a vector that turns with the body, such as the direction of one of its edges.

        Parameters
        ----------
        a, b : float or Expr
            Along the axes of the body.

        Returns
        -------
        tuple of Expr

        Examples
        --------
        >>> import sympy as sp
        >>> import symfric as sf
        >>> q, w = sp.symbols("theta omega", real=True)
        >>> sf.mechanics.Body(0, 0, q, q=[q], u=[w]).direction(1, 0)
        (cos(theta), sin(theta))
        """
        a, b = expression(a, "a of a direction"), expression(b, "b of a direction")
        c, s = sp.cos(self.theta), sp.sin(self.theta)
        return a * c - b * s, a * s + b * c

    @alone(SYMBOLIC)
    def kinetic(self, mass: float | sp.Expr, inertia: float | sp.Expr) -> sp.Expr:
        """Return the kinetic energy, for `symfric.mechanics.lagrange`.

        Parameters
        ----------
        mass : float or Expr
        inertia : float or Expr
            Moment of inertia about the centre, which must be the centre of mass.

        Returns
        -------
        Expr
        """
        v, w, spin = (_rate(e, self.q, self.u) for e in (self.x, self.y, self.theta))
        return sp.sympify(mass) * (v**2 + w**2) / 2 + sp.sympify(inertia) * spin**2 / 2


@alone(SYMBOLIC)
def against_line(
    point: Point,
    through: Point | tuple[Any, Any] = (0, 0),
    direction: tuple[Any, Any] = (1, 0),
    *,
    radius: float | sp.Expr = 0,
) -> Touch:
    """Return gap and slip of a point, or of a disc around it, against a straight line: floor, table, edge of a body.

    Parameters
    ----------
    point : Point
    through : Point or pair of Expr
        A point of the line; its motion along the line is that of the surface. A pair may depend on coordinates and
        time.
    direction : pair of Expr
        Along the line, of any length; the free side is on its left. May depend on coordinates and time, as that of
        `Body.direction`.
    radius : float or Expr
        Of a disc around the point, which turns with its body.

    Returns
    -------
    Touch
        With ``gap = n.(p - p0) - radius`` and ``slip = t.(p' - p0') + radius theta'``, where t is the unit vector along
        the line and n that on its left.

    Raises
    ------
    SceneError
        If an argument is no point or no pair, or the direction is zero.

    Examples
    --------
    A block on a table that moves up and down, and a ball on a slope:

    >>> import sympy as sp
    >>> import symfric as sf
    >>> x, y, theta, u, v, omega = sp.symbols("x y theta u v omega", real=True)
    >>> a, w, alpha, R = sp.symbols("a w alpha R", positive=True)
    >>> block = sf.mechanics.Point(x, y, q=[x, y], u=[u, v])
    >>> touch = sf.mechanics.against_line(block, through=(0, a * sp.sin(w * sf.TIME)))
    >>> touch.gap, touch.slip
    (-a*sin(t*w) + y, u)
    >>> ball = sf.mechanics.Body(x, y, theta, q=[x, y, theta], u=[u, v, omega])
    >>> touch = sf.mechanics.against_line(ball.point(0, 0), direction=(sp.cos(alpha), sp.sin(alpha)), radius=R)
    >>> touch.gap
    -R - x*sin(alpha) + y*cos(alpha)
    >>> touch.slip
    R*omega + u*cos(alpha) + v*sin(alpha)
    """
    point, p0 = _point(point, "point"), _place(through, point, "through")
    dx, dy = _pair(direction, "direction")
    length = sp.trigsimp(sp.sqrt(sp.trigsimp(dx**2 + dy**2)))
    if length.is_zero:
        raise SceneError("the direction of a line is zero; give its two components, as (1, 0)")
    t, n, radius = (dx / length, dy / length), (-dy / length, dx / length), expression(radius, "radius of a disc")
    gap = _dot(n, (point.x - p0.x, point.y - p0.y)) - radius
    return Touch(sp.expand(gap), sp.expand(_along(t, point, p0) + radius * point.spin), n)


@alone(SYMBOLIC)
def against_circle(
    point: Point, centre: Point | tuple[Any, Any], radius: float | sp.Expr, *, disc: float | sp.Expr = 0
) -> Touch:
    """Return gap and slip of a point, or of a disc around it, against the outside of a circle: roller, eccentric cam.

    Parameters
    ----------
    point : Point
    centre : Point or pair of Expr
        Of the circle, which turns with the body of a `Point`.
    radius : float or Expr
        Of the circle.
    disc : float or Expr
        Radius of a disc around the point, which turns with its body.

    Returns
    -------
    Touch
        With ``gap = d - radius - disc`` of the distance d between point and centre, and
        ``slip = t.(p' - c') + radius theta_c' + disc theta_p'``, where t is the normal turned by -90 degrees.

    Raises
    ------
    SceneError
        If an argument is no point or no pair.

    Examples
    --------
    A follower on an eccentric cam that turns at the rate w:

    >>> import sympy as sp
    >>> import symfric as sf
    >>> y, v = sp.symbols("y v", real=True)
    >>> e, R, w = sp.symbols("e R w", positive=True)
    >>> tip = sf.mechanics.Point(0, y, q=[y], u=[v])
    >>> cam = sf.mechanics.Body(0, 0, w * sf.TIME, q=[y], u=[v])
    >>> sf.mechanics.against_circle(tip, cam.point(0, e), R).gap
    -R + sqrt(e**2*sin(t*w)**2 + (-e*cos(t*w) + y)**2)
    """
    point, c = _point(point, "point"), _place(centre, _point(point, "point"), "centre")
    radius, disc = expression(radius, "radius of a circle"), expression(disc, "radius of a disc")
    apart = (point.x - c.x, point.y - c.y)
    distance = sp.sqrt(apart[0] ** 2 + apart[1] ** 2)
    n = (apart[0] / distance, apart[1] / distance)
    slip = _along((n[1], -n[0]), point, c) + radius * c.spin + disc * point.spin
    return Touch(distance - radius - disc, slip, n)


def _read(thing: Point | Body, names: tuple[str, ...], what: str) -> None:
    """Normalise the fields of a point or a body."""
    for name in names:
        object.__setattr__(thing, name, expression(getattr(thing, name), f"{name} of {what}"))
    for name in ("q", "u"):
        object.__setattr__(thing, name, tuple(listed(getattr(thing, name), name)))
    if len(thing.q) != len(thing.u):
        raise SceneError(
            f"{counted(len(thing.q), 'coordinate')} in q and {len(thing.u)} velocities in u of {what}; give one "
            "velocity for each"
        )
    for name in names:
        if wrong := getattr(thing, name).free_symbols & set(thing.u):
            raise SceneError(f"{name} of {what} contains the velocity {wrong.pop()}; a place depends on coordinates")


def _rate(e: sp.Expr, q: Sequence[sp.Symbol], u: Sequence[sp.Symbol]) -> sp.Expr:
    return sp.Add(sp.diff(e, TIME), *(sp.diff(e, a) * b for a, b in zip(q, u, strict=True)))


def _point(given: Any, what: str) -> Point:
    if not isinstance(given, Point):
        raise SceneError(f"{what} is {shortened(given)}; give a sf.mechanics.Point, as body.point(a, b)")
    return given


def _place(given: Any, beside: Point, what: str) -> Point:
    """Return a point given as itself or as a pair of expressions of the coordinates of another."""
    return given if isinstance(given, Point) else Point(*_pair(given, what), beside.q, beside.u)


def _pair(given: Any, what: str) -> Vector:
    entries = listed(given, what)
    if len(entries) != 2:
        raise SceneError(f"{what} is {shortened(given)}; give its two components, as (1, 0)")
    return expression(entries[0], f"{what}[0]"), expression(entries[1], f"{what}[1]")


def _dot(a: Vector, b: Vector) -> sp.Expr:
    return a[0] * b[0] + a[1] * b[1]


def _along(t: Vector, point: Point, other: Point) -> sp.Expr:
    """Return the relative velocity of two points along a unit vector."""
    (vx, vy), (wx, wy) = point.velocity, other.velocity
    return _dot(t, (vx - wx, vy - wy))
