"""Laws of presliding by bristles: Dahl, LuGre, elasto-plastic. Their state z is the mean deflection of the bristles."""

import sympy as sp

from symfric.errors import SceneError
from symfric.model.laws.arguments import Parameter, parameters_of, ready_law, whole
from symfric.model.laws.law import Law
from symfric.model.laws.memory import SIDE, SLIP, Memory, state_symbols
from symfric.model.laws.requirements import Requirement
from symfric.model.symbols import SPEED, expression

(Z,) = state_symbols(1)
# part of the way to the deflection of steady sliding that is left when alpha becomes 1: what it makes in alpha is below
# rounding, and a deflection that has arrived does not cross it again and again by its own roundings
_SETTLED = sp.Float("1e-8")


@ready_law
def dahl(mu_c: Parameter, sigma: Parameter, exponent: Parameter = 1) -> Law:
    r"""Dahl's law: the friction of a spring that yields, and remembers where it turned.

    Parameters
    ----------
    mu_c : float or Expr
        Coefficient in steady sliding, > 0, dimensionless.
    sigma : float or Expr
        Slope of the coefficient over displacement from rest, > 0, 1/length.
    exponent : float or Expr
        Shape of the curve, at least 1, dimensionless; 1 is an exponential approach of the limit.

    Returns
    -------
    Law
        With one state, the deflection z in units of length, between ``-mu_c/sigma`` and ``mu_c/sigma``.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Notes
    -----
    :math:`\mu = \sigma z`, :math:`z' = w\,(1 - \sigma z\,\mathrm{sgn}(w)/\mu_c)^{n}`: P. R. Dahl, A solid friction
    model, Aerospace Corporation TOR-0158(3107-18)-1 (1968). With an exponent below 1 the limit is reached within a
    finite displacement and with a corner that has no series; for 0, a spring with a slider, there is `maxwell_slip`.
    After a reversal in steady sliding the coefficient is :math:`\mu_c(1 - 2e^{-\sigma x/\mu_c})` a distance x later,
    for n = 1. For large sigma motions through reversals tend to those of Coulomb's law with an error like
    :math:`\sigma^{-1/2}`: friction needs the distance :math:`\mu_c/\sigma` to turn. Stored energy
    :math:`\sigma z^2/2` per normal load; it dissipates whatever the motion.

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.dahl(0.3, 1000.0)
    >>> law.steady, law.stiffness
    (0.300000000000000, 1000.00000000000)
    """
    (mu_c, sigma), asked = parameters_of("dahl", {"mu_c": mu_c, "sigma": sigma})
    n = whole(expression(exponent, "exponent of dahl"))
    if n.is_number and n < 1:
        raise SceneError(
            f"exponent of dahl is {n}; it must be at least 1 (for 0, a spring with a slider in series, use "
            "sf.laws.maxwell_slip([sigma], [mu_c]))"
        )
    _, least = parameters_of("dahl", {}, {"exponent - 1": n - 1})
    rate = SLIP - sigma * SPEED * Z / mu_c if n == 1 else SLIP * (1 - sigma * SIDE * Z / mu_c) ** n
    memory = Memory((rate,), sigma * Z, sigma, sigma * Z**2 / 2)
    return Law(mu_c, mu_c, source="Dahl (1968)", memory=memory, requirements=(*asked, *least))


@ready_law
def lugre(
    mu_s: Parameter, mu_c: Parameter, v_s: Parameter, sigma0: Parameter, sigma1: Parameter = 0, sigma2: Parameter = 0
) -> Law:
    r"""LuGre law: bristles that bend like springs and slip at the Stribeck curve.

    Parameters
    ----------
    mu_s, mu_c : float or Expr
        Static and Coulomb coefficient, mu_s >= mu_c > 0, dimensionless.
    v_s : float or Expr
        Stribeck speed, > 0, in the unit of the slip velocity.
    sigma0 : float or Expr
        Stiffness of the bristles, > 0, 1/length.
    sigma1, sigma2 : float or Expr
        Their damping, and the viscous friction, >= 0, time/length.

    Returns
    -------
    Law
        With one state, the deflection z in units of length. ``law.memory.passive``, :math:`\sigma_2 -
        \sigma_1(\mu_s - \mu_c)/\mu_c`, tells whether the law dissipates whatever the motion: it must not be negative.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Notes
    -----
    :math:`\mu = \sigma_0 z + \sigma_1 z' + \sigma_2 w`, :math:`z' = w - \sigma_0|w|z/g(w)`,
    :math:`g = \mu_c + (\mu_s - \mu_c)e^{-(w/v_s)^2}`: Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Transactions
    on Automatic Control 40 (1995) 419. Steady sliding: :math:`g(v) + \sigma_2 v`. Under a load that cycles below the
    limit the bristles drift; `elasto_plastic` does not. The condition of passivity follows from the power that becomes
    heat, :math:`w^2(\sigma_1(1 - y) + \sigma_2) + g|w|y^2` with :math:`y = \sigma_0 z\,\mathrm{sgn}(w)/g \leq
    \mu_s/\mu_c`, of which the first term prevails at high speed; it is that of Barabanov and Ortega, IEEE Transactions
    on Automatic Control 45 (2000) 675.

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.lugre(1.5, 1.0, 0.001, 1e5, 300.0, 0.4)
    >>> round(law(0.001), 12), law.stiffness, law.memory.passive
    (1.184339720586, 100000.000000000, -149.600000000000)
    """
    (g, s0, s1, s2, mu_s, mu_c), asked = _stribeck("lugre", mu_s, mu_c, v_s, sigma0, sigma1, sigma2)
    rate = SLIP - s0 * SPEED * Z / g
    source = "Canudas de Wit, Olsson, Astrom and Lischinsky (1995)"
    memory = _bristles(rate, s0, s1, s2, mu_s, mu_c)
    return Law(g + s2 * SPEED, mu_s, source=source, memory=memory, requirements=asked)


@ready_law
def elasto_plastic(
    mu_s: Parameter,
    mu_c: Parameter,
    v_s: Parameter,
    sigma0: Parameter,
    sigma1: Parameter = 0,
    sigma2: Parameter = 0,
    *,
    z_ba: Parameter,
) -> Law:
    r"""Elasto-plastic law: LuGre bristles that are purely elastic up to a deflection, and do not drift below it.

    Parameters
    ----------
    mu_s, mu_c, v_s, sigma0, sigma1, sigma2 : float or Expr
        As in `lugre`.
    z_ba : float or Expr
        Deflection at which the bristles begin to slip, ``0 < z_ba < mu_c/sigma0``, length.

    Returns
    -------
    Law
        With one state, the deflection z in units of length; passive as `lugre`.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Notes
    -----
    :math:`z' = w(1 - \alpha\,\mathrm{sgn}(w)\,\sigma_0 z/g(w))`; :math:`\alpha` is 0 where the bristles unload or
    :math:`|z| \leq z_{ba}`, 1 beyond :math:`z_m = g(w)/\sigma_0`, and
    :math:`\tfrac12 + \tfrac12\sin\pi\frac{|z| - (z_m + z_{ba})/2}{z_m - z_{ba}}` between: Dupont, Hayward, Armstrong
    and Altpeter, IEEE Transactions on Automatic Control 47 (2002) 787.

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.elasto_plastic(1.2, 1.0, 0.01, 100.0, z_ba=0.008)
    >>> law.stiffness
    100.000000000000
    """
    (g, s0, s1, s2, mu_s, mu_c), asked = _stribeck("elasto_plastic", mu_s, mu_c, v_s, sigma0, sigma1, sigma2)
    z_ba = expression(z_ba, "z_ba of elasto_plastic")
    if (mu_c / s0 - z_ba).is_number and z_ba >= mu_c / s0:
        raise SceneError(f"z_ba of elasto_plastic is {z_ba}; it must be below mu_c/sigma0 = {mu_c / s0}")
    _, yields = parameters_of("elasto_plastic", {"z_ba": z_ba, "mu_c/sigma0 - z_ba": mu_c / s0 - z_ba})
    bent, most = SIDE * Z, g / s0  # deflection in the direction of slip, and that of steady sliding
    between = (1 + sp.sin(sp.pi * (bent - (most + z_ba) / 2) / (most - z_ba))) / 2
    settled = most - _SETTLED * (most - z_ba)
    alpha = sp.Piecewise((0, bent <= z_ba), (between, bent < settled), (1, True))
    rate = SLIP - alpha * SPEED * Z / most
    source = "Dupont, Hayward, Armstrong and Altpeter (2002)"
    memory = _bristles(rate, s0, s1, s2, mu_s, mu_c)
    return Law(g + s2 * SPEED, mu_s, source=source, memory=memory, requirements=(*asked, *yields))


def _stribeck(
    law: str, mu_s: Parameter, mu_c: Parameter, v_s: Parameter, sigma0: Parameter, sigma1: Parameter, sigma2: Parameter
) -> tuple[tuple[sp.Expr, ...], tuple[Requirement, ...]]:
    """Return the Stribeck curve, stiffness, two kinds of damping and two coefficients, and what they must satisfy."""
    positive = {"mu_s": mu_s, "mu_c": mu_c, "v_s": v_s, "sigma0": sigma0}
    (mu_s, mu_c, v_s, s0, s1, s2), asked = parameters_of(law, positive, {"sigma1": sigma1, "sigma2": sigma2})
    if (mu_s - mu_c).is_number and mu_s < mu_c:
        raise SceneError(f"mu_s of {law} is {mu_s}; it must not be below mu_c = {mu_c}")
    _, falls = parameters_of(law, {}, {"mu_s - mu_c": mu_s - mu_c})
    curve = mu_c + (mu_s - mu_c) * sp.exp(-((SPEED / v_s) ** 2))
    return (curve, s0, s1, s2, mu_s, mu_c), (*asked, *falls)


def _bristles(rate: sp.Expr, s0: sp.Expr, s1: sp.Expr, s2: sp.Expr, mu_s: sp.Expr, mu_c: sp.Expr) -> Memory:
    force = s0 * Z + s1 * rate + s2 * SLIP
    return Memory((rate,), force, s0, s0 * Z**2 / 2, s2 - s1 * (mu_s - mu_c) / mu_c)
