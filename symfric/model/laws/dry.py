"""Dry friction laws without memory: the coefficient of friction depends on the sliding speed alone."""

import itertools
from collections.abc import Sequence

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.laws.arguments import Parameter, parameters_of, ready_law
from symfric.model.laws.law import Law
from symfric.model.symbols import SPEED, expression, listed
from symfric.model.tables import broken_line


@ready_law
def coulomb(mu_s: Parameter, mu_k: Parameter | None = None) -> Law:
    """Constant kinetic coefficient mu_k, static coefficient mu_s >= mu_k (equal unless given).

    Parameters
    ----------
    mu_s : float or Expr
        Static coefficient, dimensionless.
    mu_k : float or Expr, optional
        Kinetic coefficient; mu_s unless given.

    Returns
    -------
    Law

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.coulomb(0.4, 0.3)
    >>> law(2.0), law(-2.0), law.stick
    (0.3, -0.3, 0.400000000000000)
    """
    return Law(mu_s if mu_k is None else mu_k, mu_s, source="handbook (19.104)")


@ready_law
def lorentz(mu_d: Parameter, v_c: Parameter, mu_s: Parameter | None = None, b: Parameter = 0) -> Law:
    r""":math:`\mu_d/(1 + (v/v_c)^2) + b v`; static coefficient mu_s, mu_d unless given.

    Parameters
    ----------
    mu_d : float or Expr
        Kinetic coefficient in the limit of no speed, dimensionless.
    v_c : float or Expr
        Speed at which half of mu_d is left.
    mu_s : float or Expr, optional
        Static coefficient; mu_d unless given.
    b : float or Expr
        Slope added at all speeds, 1 over the unit of the speed.

    Returns
    -------
    Law

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.laws.lorentz(0.4, 0.1)(0.1), 6)
    0.2
    """
    (v_c,), asked = parameters_of("lorentz", {"v_c": v_c})
    kinetic = mu_d / (1 + (SPEED / v_c) ** 2) + b * SPEED
    return Law(kinetic, mu_d if mu_s is None else mu_s, source="handbook (19.105), (19.106)", requirements=asked)


@ready_law
def gauss(mu_d: Parameter, v_c: Parameter, mu_s: Parameter | None = None, b: Parameter = 0) -> Law:
    r""":math:`\mu_d \exp(-(v/v_c)^2) + b v`; static coefficient mu_s, mu_d unless given.

    Parameters
    ----------
    mu_d : float or Expr
        Kinetic coefficient in the limit of no speed, dimensionless.
    v_c : float or Expr
        Speed at which a part 1/e of mu_d is left.
    mu_s : float or Expr, optional
        Static coefficient; mu_d unless given.
    b : float or Expr
        Slope added at all speeds, 1 over the unit of the speed.

    Returns
    -------
    Law

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.laws.gauss(0.4, 0.1)(0.1), 6)
    0.147152
    """
    (v_c,), asked = parameters_of("gauss", {"v_c": v_c})
    kinetic = mu_d * sp.exp(-((SPEED / v_c) ** 2)) + b * SPEED
    return Law(kinetic, mu_d if mu_s is None else mu_s, source="handbook (19.105), (19.107)", requirements=asked)


@ready_law
def square_root(mu_d: Parameter, alpha: Parameter, mu_s: Parameter | None = None, b: Parameter = 0) -> Law:
    r""":math:`\mu_d + \alpha\sqrt v + b v`; it falls with speed only for alpha < 0.

    Parameters
    ----------
    mu_d : float or Expr
        Kinetic coefficient in the limit of no speed, dimensionless.
    alpha : float or Expr
        Factor of the square root of the speed.
    mu_s : float or Expr, optional
        Static coefficient; mu_d unless given.
    b : float or Expr
        Slope added at all speeds, 1 over the unit of the speed.

    Returns
    -------
    Law

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.laws.square_root(0.4, -0.1, b=0.05)(0.25), 6)
    0.3625
    """
    kinetic = mu_d + alpha * sp.sqrt(SPEED) + b * SPEED
    return Law(kinetic, mu_d if mu_s is None else mu_s, source="handbook (19.105), (19.108)")


@ready_law
def stribeck(mu_s: Parameter, mu_k: Parameter, v_s: Parameter, b: Parameter = 0) -> Law:
    r"""Exponential Stribeck law :math:`\mu_k + (\mu_s - \mu_k) e^{-v/v_s} + b v`; static coefficient mu_s.

    Parameters
    ----------
    mu_s, mu_k : float or Expr
        Static coefficient and kinetic one at high speed, dimensionless.
    v_s : float or Expr
        Speed over which friction falls by a factor e.
    b : float or Expr
        Slope added at all speeds, 1 over the unit of the speed.

    Returns
    -------
    Law

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.stribeck(0.5, 0.38, 0.12)
    >>> round(law(0.05), 6)
    0.459109
    >>> law.kinetic
    0.38 + 0.12*exp(-8.33333333333333*v)
    """
    (v_s,), asked = parameters_of("stribeck", {"v_s": v_s})
    drop = (mu_s - mu_k) * sp.exp(-SPEED / v_s)
    return Law(mu_k + drop + b * SPEED, mu_s, source="handbook (19.105), figure 19.15", requirements=asked)


@ready_law
def cubic(mu_s: Parameter, mu_m: Parameter, v_m: Parameter) -> Law:
    r"""Smallest coefficient mu_m at speed v_m: :math:`\mu_s - \tfrac32(\mu_s-\mu_m)(s - s^3/3)`, s = v/v_m.

    Parameters
    ----------
    mu_s, mu_m : float or Expr
        Static and smallest coefficient, dimensionless.
    v_m : float or Expr
        Speed of the smallest coefficient.

    Returns
    -------
    Law

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> law = sf.laws.cubic(0.4, 0.25, 0.5)
    >>> round(law(0.5), 6)
    0.25
    >>> v_m = sp.Symbol("v_m", positive=True)
    >>> sf.laws.cubic(0.4, 0.25, v_m).where({"v_m": 0.5}) == law
    True
    """
    (v_m,), asked = parameters_of("cubic", {"v_m": v_m})
    s = SPEED / v_m
    kinetic = mu_s - sp.Rational(3, 2) * (mu_s - mu_m) * (s - s**3 / 3)
    return Law(kinetic, mu_s, source="Thomsen (5)", requirements=asked)


@ready_law
def thomsen_regularised(mu_s: Parameter, mu_m: Parameter, v_m: Parameter, v_s: Parameter) -> Law:
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
    _, asked = parameters_of("thomsen_regularised", {"v_s": v_s, "v_m - v_s": v_m - v_s})
    s = (SPEED - v_s) / (v_m - v_s)
    sliding = mu_s - sp.Rational(3, 2) * (mu_s - mu_m) * (s - s**3 / 3)
    kinetic = sp.Piecewise((mu_s * SPEED / v_s, v_s > SPEED), (sliding, True))
    return Law(kinetic, sp.Integer(0), (v_s,), "Thomsen (6)", requirements=asked)


@ready_law
def exponential(mu_m: Parameter, v_c: Parameter = 1.0) -> Law:
    r""":math:`\mu_m e^{-v/v_c}`, static coefficient mu_m; v_c = 1 m/s in the source.

    Parameters
    ----------
    mu_m : float or Expr
        Coefficient at rest, dimensionless.
    v_c : float or Expr
        Speed over which friction falls by a factor e.

    Returns
    -------
    Law

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.laws.exponential(0.4)(1.0), 6)
    0.147152
    """
    (v_c,), asked = parameters_of("exponential", {"v_c": v_c})
    return Law(mu_m * sp.exp(-SPEED / v_c), mu_m, source="Younes and Ashour (3)", requirements=asked)


@ready_law
def piecewise_linear(
    mu_s: Parameter, speeds: Sequence[Parameter], values: Sequence[Parameter], last_slope: Parameter | None = None
) -> Law:
    """Straight lines through (speeds, values), continued beyond the last one.

    Parameters
    ----------
    mu_s : float or Expr
        Static coefficient.
    speeds, values : sequences of the same length
        Speeds, starting with 0 and increasing, and the kinetic coefficient at each.
    last_slope : float or Expr, optional
        Slope beyond the last speed; the slope of the last segment unless given.

    Returns
    -------
    Law

    Raises
    ------
    SceneError
        If there is not one value for each speed, the first speed is not 0, or the speeds do not increase.

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.piecewise_linear(0.05, [0, 2], [0.05, 0.014], last_slope=0.0012)
    >>> law(1.0), law.breaks
    (0.032, (2,))
    """
    speeds, values = listed(speeds, "speeds"), listed(values, "values")
    for name, given in (("speeds", speeds), ("values", values)):
        for i, entry in enumerate(given):
            expression(entry, f"{name}[{i}]")
    if len(speeds) != len(values):
        raise SceneError(f"{len(speeds)} speeds and {len(values)} values; give one value for each speed")
    if not speeds or not sp.sympify(speeds[0]).is_zero:
        raise SceneError("the first speed of a piecewise-linear law must be 0")
    for low, high in itertools.pairwise(speeds):
        if sp.sympify(high - low).is_nonpositive:
            raise SceneError(f"the speeds of a piecewise-linear law must increase; {high} follows {low}")
    slopes = [(values[i + 1] - values[i]) / (speeds[i + 1] - speeds[i]) for i in range(len(speeds) - 1)]
    if last_slope is None and not slopes:
        raise SceneError("a piecewise-linear law with one speed needs last_slope")
    if last_slope is not None:
        slopes.append(last_slope)
        breaks = tuple(speeds[1:])
    else:
        breaks = tuple(speeds[1:-1])
    lines = [values[i] + slope * (SPEED - speeds[i]) for i, slope in enumerate(slopes)]
    steps = {f"the step from {a} to {b} of the speeds": sp.sympify(b - a) for a, b in itertools.pairwise(speeds)}
    _, asked = parameters_of("piecewise_linear", steps)
    return Law(broken_line(SPEED, breaks, lines), mu_s, breaks, source="Guida (2)", requirements=asked)


@alone(SYMBOLIC)
def custom(kinetic: sp.Expr, mu_s: Parameter, breaks: Sequence[Parameter] = ()) -> Law:
    """Any expression of ``sf.SPEED``; a Piecewise in it must be continuous and name its speeds in `breaks`.

    Parameters
    ----------
    kinetic : Expr
        Coefficient for sliding speeds ``sf.SPEED`` > 0.
    mu_s : float or Expr
        Static coefficient.
    breaks : sequence of float or Expr
        Speeds at which a Piecewise changes its branch, increasing.

    Returns
    -------
    Law

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> law = sf.laws.custom(0.6 + 0.55 * sp.exp(-sf.SPEED / 0.1), mu_s=1.2)
    >>> round(law(0.1), 6)
    0.802334
    """
    return Law(kinetic, mu_s, listed(breaks, "breaks"), source="user")
