"""Friction laws: the coefficient of friction of a dry contact as a function of its sliding speed."""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.averaged_law import effective_coefficient
from symfric.model.numeric import numeric_function
from symfric.model.symbols import SPEED, expression, finite

_REGULARISATIONS = {  # by shape, what is done to a law
    "linear": "straight up to v_s, then the law moved by v_s",
    "arctan": "times (2/pi) atan(v/v_s), proposed after Thomsen (6)",
    "tanh": "times tanh(v/v_s)",
}
SHAPES = tuple(_REGULARISATIONS)


@dataclass(frozen=True)
class Law:
    """Coefficient of friction of one dry contact.

    The friction on the body is ``-sign(slip) * normal * kinetic(|slip|)`` while it slips, and anything up to
    ``normal * stick`` while it sticks.

    Attributes
    ----------
    kinetic : Expr
        mu(v) for sliding speed ``SPEED`` > 0, dimensionless.
    stick : Expr
        Largest |friction / normal force| that sticking can carry, dimensionless. Zero together with
        ``kinetic(0) = 0`` makes a smooth law, which never sticks.
    breaks : tuple of Expr
        Speeds at which `kinetic` changes its branch, increasing.
    source : str
        Document and equation, or the file of ``derivations/`` that establishes the formula.
    steep : tuple of Expr
        Those of the `breaks` where the law has no Taylor series, an infinite slope for example; solvers bridge them by
        a straight line over the nearest part in 1e9 of the speed.
    """

    kinetic: sp.Expr
    stick: sp.Expr
    breaks: tuple[sp.Expr, ...] = ()
    source: str = ""
    steep: tuple[sp.Expr, ...] = ()

    @alone(SYMBOLIC)
    def __post_init__(self):
        object.__setattr__(self, "kinetic", expression(self.kinetic, "the kinetic coefficient"))
        object.__setattr__(self, "stick", expression(self.stick, "the static coefficient"))
        object.__setattr__(self, "breaks", tuple(expression(b, "a break of the law") for b in self.breaks))
        if self.stick.is_number and self.stick < 0:
            raise SceneError(f"the static coefficient is {self.stick}; it must not be negative")
        speeds = [0, *self.breaks]
        for low, high in itertools.pairwise(speeds):
            if (high - low).is_number and high - low <= 0:
                raise SceneError(f"the breaks of a law must increase and be positive; {high} follows {low}")

    @property
    def free_symbols(self) -> set[sp.Symbol]:
        """Parameters of the law, without the speed itself."""
        found = self.kinetic.free_symbols | self.stick.free_symbols
        return set().union(found, *(b.free_symbols for b in self.breaks)) - {SPEED}

    @property
    def smooth(self) -> bool:
        """Whether friction passes through zero without a jump, so that the contact never sticks."""
        return bool(self.stick.is_zero) and bool(self.at_rest.is_zero)

    @property
    def at_rest(self) -> sp.Expr:
        """Kinetic coefficient in the limit of vanishing speed."""
        start = self.kinetic
        if isinstance(start, sp.Piecewise):
            start = start.args[0].expr
        if self.stick.is_zero and start.has(sp.Integral):
            return sp.Integer(0)  # the mean of an odd law over a symmetric vibration; quadrature leaves rounding
        return start.subs(SPEED, 0)

    def __call__(self, v):
        """Evaluate the law on numbers, odd in `v`; zero at v = 0.

        Parameters
        ----------
        v : float or array_like
            Relative velocity, any shape.

        Returns
        -------
        float or ndarray
            ``sign(v) * kinetic(|v|)``, same shape.

        Raises
        ------
        SceneError
            If the law still has symbols.
        """
        if self.free_symbols:
            names = ", ".join(sorted(s.name for s in self.free_symbols))
            raise SceneError(f"the law has no number for {names}; use law.where({{...}}) first")
        v = np.asarray(v, dtype=float)
        speed = np.where(v == 0, 1.0, np.abs(v))
        result = np.sign(v) * numeric_function((SPEED,), self.kinetic)(speed)
        return result if result.ndim else float(result)

    @alone(SYMBOLIC)
    def where(self, values: Mapping) -> "Law":
        """Return the law with numbers or expressions in place of its symbols, given by symbol or by name."""
        named = {s.name: s for s in self.free_symbols}
        mapping = {named.get(key, key) if isinstance(key, str) else key: value for key, value in values.items()}
        return self._mapped(lambda e: e.subs(mapping))

    def _mapped(self, change) -> "Law":
        breaks = tuple(change(b) for b in self.breaks)
        steep = tuple(change(b) for b in self.steep)
        return replace(self, kinetic=change(self.kinetic), stick=change(self.stick), breaks=breaks, steep=steep)

    @alone(SYMBOLIC)
    def regularised(self, v_s, shape: str = "linear") -> "Law":
        """Return a continuous law that replaces the jump at rest by a steep slope.

        Parameters
        ----------
        v_s : float or Expr
            Speed below which the contact counts as sticking, > 0, in the unit of the slip velocity.
        shape : {"linear", "arctan", "tanh"}
            "linear" rises to the static coefficient at v_s and continues with the kinetic law at ``v - v_s``;
            the others multiply the kinetic law by ``(2/pi) atan(v/v_s)`` or ``tanh(v/v_s)``.

        Notes
        -----
        The error of a motion is linear in v_s. Where the static coefficient differs from the kinetic one at rest,
        the linear shape falls from one to the other between v_s and 2 v_s. Here every law is moved as a whole, so that
        the minimum of the cubic law moves to v_m + v_s; Thomsen (6) keeps it at v_m and is another law,
        `sf.laws.thomsen_regularised`. The factor with the arctangent is the one proposed after (6).
        """
        v_s = expression(v_s, "the speed v_s of a regularisation")
        if v_s.is_number and v_s <= 0:
            raise SceneError(f"the speed v_s of a regularisation is {v_s}; it must be positive")
        if shape not in SHAPES:
            raise SceneError(f"no regularisation of shape {shape!r}; there are {', '.join(SHAPES)}")
        source = f"{self.source}, regularised: {_REGULARISATIONS[shape]}"
        zero = sp.Integer(0)
        if shape != "linear":
            step = sp.atan(SPEED / v_s) * 2 / sp.pi if shape == "arctan" else sp.tanh(SPEED / v_s)
            return Law(self.kinetic * step, zero, self.breaks, source)
        rest = self.at_rest
        jump = sp.simplify(rest - self.stick) != 0
        edge = 2 * v_s if jump else v_s
        pieces = [(self.stick * SPEED / v_s, v_s > SPEED)]
        if jump:
            pieces.append((self.stick + (rest - self.stick) * (SPEED / v_s - 1), edge > SPEED))
        breaks = (v_s, *((edge,) if jump else ()), *(edge + b for b in self.breaks))
        shifted = self.kinetic.subs(SPEED, SPEED - edge)
        pieces += shifted.args if isinstance(shifted, sp.Piecewise) else [(shifted, True)]
        return Law(sp.Piecewise(*pieces), zero, breaks, source)

    @alone(SYMBOLIC)
    def averaged(self, q) -> "Law":
        """Return the effective law under fast vibration of intensity q.

        Parameters
        ----------
        q : float or Expr
            Amplitude of the fast velocity, >= 0, in the unit of the slip velocity.

        Notes
        -----
        ``mubar(v) = <mu(v - q cos theta)>``, the mean over theta, Thomsen (41). Closed form for laws that are
        polynomials of the speed, Thomsen (47); an integral over theta, split where the relative velocity changes its
        sign or the law its branch, for the others. The slope just below v = q is infinite, Thomsen (47).

        Raises
        ------
        SceneError
            If q is negative, or if the law is such an integral itself.
        """
        q = expression(q, "the intensity q of the fast vibration")
        if q.is_number:
            if finite(q, "the intensity q of the fast vibration") < 0:
                raise SceneError(f"the intensity q of the fast vibration is {q}; it must not be negative")
            if q == 0:
                return self
        if self.kinetic.has(sp.Integral):
            raise SceneError(
                "the law is a mean over fast vibration already, without a closed form, and the mean of such a mean "
                "cannot be computed; average the law itself, once"
            )
        kinetic, breaks = effective_coefficient(self.kinetic, self.breaks, q)
        return Law(kinetic, sp.Integer(0), breaks, f"{self.source}, under fast vibration: Thomsen (41), (47)", breaks)


@alone(SYMBOLIC)
def coulomb(mu_s, mu_k=None) -> Law:
    """Constant kinetic coefficient mu_k, static coefficient mu_s >= mu_k (equal unless given)."""
    return Law(mu_s if mu_k is None else mu_k, mu_s, source="handbook (19.104)")


@alone(SYMBOLIC)
def lorentz(mu_d, v_c, mu_s=None, b=0) -> Law:
    r""":math:`\mu_d/(1 + (v/v_c)^2) + b v`; static coefficient mu_s, mu_d unless given."""
    kinetic = mu_d / (1 + (SPEED / v_c) ** 2) + b * SPEED
    return Law(kinetic, mu_d if mu_s is None else mu_s, source="handbook (19.105), (19.106)")


@alone(SYMBOLIC)
def gauss(mu_d, v_c, mu_s=None, b=0) -> Law:
    r""":math:`\mu_d \exp(-(v/v_c)^2) + b v`; static coefficient mu_s, mu_d unless given."""
    kinetic = mu_d * sp.exp(-((SPEED / v_c) ** 2)) + b * SPEED
    return Law(kinetic, mu_d if mu_s is None else mu_s, source="handbook (19.105), (19.107)")


@alone(SYMBOLIC)
def square_root(mu_d, alpha, mu_s=None, b=0) -> Law:
    r""":math:`\mu_d + \alpha\sqrt v + b v`; it falls with speed only for alpha < 0."""
    kinetic = mu_d + alpha * sp.sqrt(SPEED) + b * SPEED
    return Law(kinetic, mu_d if mu_s is None else mu_s, source="handbook (19.105), (19.108)")


@alone(SYMBOLIC)
def stribeck(mu_s, mu_k, v_s, b=0) -> Law:
    r"""Exponential Stribeck law :math:`\mu_k + (\mu_s - \mu_k) e^{-v/v_s} + b v`; static coefficient mu_s."""
    return Law(mu_k + (mu_s - mu_k) * sp.exp(-SPEED / v_s) + b * SPEED, mu_s, source="handbook (19.105), figure 19.15")


@alone(SYMBOLIC)
def cubic(mu_s, mu_m, v_m) -> Law:
    r"""Smallest coefficient mu_m at speed v_m: :math:`\mu_s - \tfrac32(\mu_s-\mu_m)(s - s^3/3)`, s = v/v_m."""
    s = SPEED / v_m
    kinetic = mu_s - sp.Rational(3, 2) * (mu_s - mu_m) * (s - s**3 / 3)
    return Law(kinetic, mu_s, source="Thomsen (5)")


@alone(SYMBOLIC)
def thomsen_regularised(mu_s, mu_m, v_m, v_s) -> Law:
    r"""Cubic law without a jump at rest: straight up to mu_s at the speed v_s, smallest coefficient mu_m at v_m.

    Parameters
    ----------
    mu_s, mu_m : float or Expr
        Static and smallest coefficient, dimensionless.
    v_m, v_s : float or Expr
        Speed of the smallest coefficient, and speed below which the contact counts as sticking, 0 < v_s < v_m, in the
        unit of the slip velocity.

    Returns
    -------
    Law
        Smooth at rest: the contact never sticks.

    Raises
    ------
    SceneError
        If v_s is not between 0 and v_m.

    Notes
    -----
    :math:`\mu_s v/v_s` for :math:`v < v_s`, beyond it :math:`\mu_s - \tfrac32(\mu_s-\mu_m)(s - s^3/3)` with
    :math:`s = (v - v_s)/(v_m - v_s)`: Thomsen (6), printed there with u_s for mu_s. ``cubic(...).regularised(v_s)``
    does not compress the speed and has its minimum at v_m + v_s; at v_s = .01 their periods differ by 7e-4.

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.thomsen_regularised(0.4, 0.25, 0.5, 0.01)
    >>> round(law(0.01), 12), round(law(0.5), 12)
    (0.4, 0.25)
    """
    mu_s, mu_m, v_m, v_s = (expression(e, "a parameter of the law") for e in (mu_s, mu_m, v_m, v_s))
    if v_s.is_number and (v_s <= 0 or (v_m.is_number and v_s >= v_m)):
        raise SceneError(f"the speed v_s is {v_s}; it must be above 0 and below v_m = {v_m}")
    s = (SPEED - v_s) / (v_m - v_s)
    sliding = mu_s - sp.Rational(3, 2) * (mu_s - mu_m) * (s - s**3 / 3)
    return Law(sp.Piecewise((mu_s * SPEED / v_s, v_s > SPEED), (sliding, True)), sp.Integer(0), (v_s,), "Thomsen (6)")


@alone(SYMBOLIC)
def exponential(mu_m, v_c=1.0) -> Law:
    r""":math:`\mu_m e^{-v/v_c}`, static coefficient mu_m; v_c = 1 m/s in the source."""
    return Law(mu_m * sp.exp(-SPEED / v_c), mu_m, source="Younes and Ashour (3)")


@alone(SYMBOLIC)
def piecewise_linear(mu_s, speeds, values, last_slope=None) -> Law:
    """Straight lines through (speeds, values), continued beyond the last one.

    Parameters
    ----------
    mu_s : float or Expr
        Static coefficient.
    speeds, values : sequences of the same length
        Speeds, starting with 0 and increasing, and the kinetic coefficient at each.
    last_slope : float or Expr, optional
        Slope beyond the last speed; the slope of the last segment unless given.
    """
    speeds, values = list(speeds), list(values)
    if len(speeds) != len(values):
        raise SceneError(f"{len(speeds)} speeds and {len(values)} values; give one value for each speed")
    if not speeds or not sp.sympify(speeds[0]).is_zero:
        raise SceneError("the first speed of a piecewise-linear law must be 0")
    slopes = [(values[i + 1] - values[i]) / (speeds[i + 1] - speeds[i]) for i in range(len(speeds) - 1)]
    if last_slope is None and not slopes:
        raise SceneError("a piecewise-linear law with one speed needs last_slope")
    if last_slope is not None:
        slopes.append(last_slope)
        breaks = tuple(speeds[1:])
    else:
        breaks = tuple(speeds[1:-1])
    lines = [values[i] + slope * (SPEED - speeds[i]) for i, slope in enumerate(slopes)]
    pieces = [(line, b > SPEED) for line, b in zip(lines, breaks, strict=False)] + [(lines[-1], True)]
    return Law(sp.Piecewise(*pieces) if breaks else lines[0], mu_s, breaks, source="Guida (2)")


@alone(SYMBOLIC)
def custom(kinetic, mu_s, breaks=()) -> Law:
    """Any expression of ``sf.SPEED``; a Piecewise in it must be continuous and name its speeds in `breaks`."""
    return Law(kinetic, mu_s, tuple(breaks), source="user")
