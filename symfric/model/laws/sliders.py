"""Laws of springs with sliders in parallel: generalised Maxwell slip, Iwan; and their smooth relative, Bouc-Wen.

Every spring with a slider in series (an element of Jenkins) is stretched by the slip until it reaches its limit, and
then slides, exactly: see `symfric.lower.slider_sets`.
"""

import itertools
from collections.abc import Sequence

import sympy as sp

from symfric.errors import SceneError
from symfric.model.laws.arguments import Parameter, parameters_of, ready_law, whole
from symfric.model.laws.law import Law
from symfric.model.laws.memory import SLIP, Memory, state_symbols
from symfric.model.laws.requirements import Requirement
from symfric.model.symbols import SPEED, expression, listed, shortened

_MOST_ELEMENTS = 1000  # of Iwan's law
_NEAR = sp.Float("1e-9")  # of the limit: where powers of |z| that are not whole are rounded off


@ready_law
def maxwell_slip(stiffness: Sequence[Parameter], limits: Sequence[Parameter], b: Parameter = 0) -> Law:
    r"""Generalised Maxwell slip: springs with sliders in series, several such elements in parallel.

    Parameters
    ----------
    stiffness : sequence of float or Expr, length n
        Slope of the coefficient over displacement of every element, > 0, 1/length; the normal load times it is a
        stiffness. A spring that does not depend on the load is the ``stiffness`` of a `Contact` with a dry law.
    limits : sequence of float or Expr, length n
        Coefficient at which its slider moves, > 0, dimensionless.
    b : float or Expr
        Viscous friction beside the elements, >= 0, time/length.

    Returns
    -------
    Law
        With n states, the elongations of the springs in units of length.

    Raises
    ------
    SceneError
        If a parameter is out of range, or the lengths differ.

    Notes
    -----
    :math:`\mu = \sum k_i z_i + b w`, :math:`z_i' = w` until :math:`k_i|z_i|` reaches the limit, 0 from there until the
    slip turns: W. D. Iwan, Journal of Applied Mechanics 33 (1966) 893; Al-Bender, Lampaert and Swevers, IEEE
    Transactions on Automatic Control 50 (2005) 1883. First loading is :math:`F(x) = \sum\min(k_i x, l_i)`, and every
    branch after a reversal the same curve at twice the size, :math:`F_r \pm 2F(|x - x_r|/2)`, until it meets an
    earlier one (Masing's rules). It dissipates whatever the motion.

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.maxwell_slip([100, 50], [0.1, 0.2])
    >>> round(law(1.0), 12), law.stiffness
    (0.3, 150)
    """
    stiffness, limits = listed(stiffness, "stiffness"), listed(limits, "limits")
    if len(stiffness) != len(limits) or not stiffness:
        raise SceneError(f"maxwell_slip has {len(stiffness)} stiffnesses and {len(limits)} limits; give one pair each")
    positive = {f"stiffness[{i}]": e for i, e in enumerate(stiffness)}
    positive |= {f"limits[{i}]": e for i, e in enumerate(limits)}
    (*both, b), asked = parameters_of("maxwell_slip", positive, {"b": b})
    k, most = both[: len(stiffness)], both[len(stiffness) :]
    return _elements(k, most, b, "Iwan (1966), Al-Bender, Lampaert and Swevers (2005)", asked)


@ready_law
def iwan(R: Parameter, chi: Parameter, phi_max: Parameter, elements: int = 40) -> Law:
    r"""Iwan's law with a power-law density of sliders, as an assembly of elements.

    Parameters
    ----------
    R : float or Expr
        Factor of the density, > 0.
    chi : float or Expr
        Its exponent, above -1; between -1 and 0 for joints.
    phi_max : float or Expr
        Displacement at which the last slider moves, > 0, length.
    elements : int
        Their number n, at least 1.

    Returns
    -------
    Law
        With one state for each element, as `maxwell_slip`.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Notes
    -----
    Sliders with the density :math:`R\phi^\chi`, :math:`0 < \phi < \phi_{max}`, that move at the displacement phi: D. J.
    Segalman, Journal of Applied Mechanics 72 (2005) 752. The range is divided at :math:`\phi_{max}(i/n)^2`; every part
    becomes one element with its stiffness and its limit, so that those of the whole are exact. The energy dissipated in
    a cycle of amplitude X, :math:`4RX^{\chi+3}/((\chi+3)(\chi+2))`, then has a relative error of at most
    :math:`(\chi+3)(\tfrac13 + \tfrac{\chi+2}{2})\,\phi_{max}/(n^2X)`. See `sf.theory.presliding` for the closed forms.

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.iwan(1.0, -0.5, 1.0, elements=20)
    >>> round(law(1.0), 12), round(float(law.stiffness), 12)
    (0.666666666667, 2.0)
    """
    chi = expression(chi, "chi of iwan")
    if chi.is_number and not chi > -1:
        raise SceneError(f"chi of iwan is {chi}; it must be above -1")
    if not isinstance(elements, int) or isinstance(elements, bool) or not 1 <= elements <= _MOST_ELEMENTS:
        raise SceneError(
            f"elements of iwan is {shortened(elements)}; give a whole number from 1 to {_MOST_ELEMENTS}, each of which "
            "is a state"
        )
    (R, phi_max, _), asked = parameters_of("iwan", {"R": R, "phi_max": phi_max, "chi + 1": chi + 1})
    edges = [phi_max * sp.Rational(i, elements) ** 2 for i in range(elements + 1)]
    k, most = ([R * (b**n - a**n) / n for a, b in itertools.pairwise(edges)] for n in (chi + 1, chi + 2))
    return _elements(k, most, sp.S.Zero, "Segalman (2005)", asked)


def _elements(
    k: list[sp.Expr], most: list[sp.Expr], b: sp.Expr, source: str, requirements: tuple[Requirement, ...]
) -> Law:
    z = state_symbols(len(k))
    force = sp.Add(*(a * e for a, e in zip(k, z, strict=True))) + b * SLIP
    stored = sp.Add(*(a * e**2 / 2 for a, e in zip(k, z, strict=True)))
    limits = tuple(limit / a for limit, a in zip(most, k, strict=True))
    total = sp.Add(*most)
    memory = Memory((SLIP,) * len(k), force, sp.Add(*k), stored, limits=limits)
    return Law(total + b * SPEED, total, source=source, memory=memory, requirements=requirements)


@ready_law
def bouc_wen(alpha: Parameter, beta: Parameter, gamma: Parameter, n: Parameter) -> Law:
    r"""Bouc-Wen law: a smooth hysteresis between a spring and a slider.

    Parameters
    ----------
    alpha : float or Expr
        Slope of the coefficient over displacement from rest, > 0, 1/length.
    beta, gamma : float or Expr
        Shape of the loop, beta + gamma > 0, 1/length; ``law.memory.passive`` is ``beta - |gamma|``, and the law
        dissipates whatever the motion if it is not negative.
    n : float or Expr
        Sharpness of the yielding, at least 1, dimensionless.

    Returns
    -------
    Law
        With one state, the coefficient of friction z itself, dimensionless.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Notes
    -----
    :math:`\mu = z`, :math:`z' = \alpha w - \beta|w||z|^{n-1}z - \gamma w|z|^n`: Y.-K. Wen, Journal of the Engineering
    Mechanics Division 102 (1976) 249. Steady sliding: :math:`(\alpha/(\beta+\gamma))^{1/n}`. Stored energy
    :math:`z^2/(2\alpha)` per normal load; what is dissipated is :math:`|w||z|^{n+1}(\beta \pm \gamma)/\alpha`. For an n
    that is not whole |z| is :math:`\sqrt{z^2 + \delta^2}`, which has a series at z = 0, with delta 1e-9 of the limit.

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.bouc_wen(100.0, 500.0, 500.0, 1)
    >>> round(law(1.0), 12), law.stiffness
    (0.1, 100.000000000000)
    """
    beta, gamma = expression(beta, "beta of bouc_wen"), expression(gamma, "gamma of bouc_wen")
    n = whole(expression(n, "n of bouc_wen"))
    if n.is_number and n < 1:
        raise SceneError(f"n of bouc_wen is {n}; it must be at least 1")
    if (beta + gamma).is_number and not beta + gamma > 0:
        raise SceneError(f"beta + gamma of bouc_wen is {beta + gamma}; it must be positive")
    positive = {"alpha": alpha, "beta + gamma": beta + gamma}
    (alpha, *_), asked = parameters_of("bouc_wen", positive, {"n - 1": n - 1})
    (z,) = state_symbols(1)
    most = (alpha / (beta + gamma)) ** (1 / n)
    size = sp.Abs(z) if n.is_Integer else sp.sqrt(z**2 + (_NEAR * most) ** 2)
    if n.is_Integer and n % 2 == 0:
        along, across = size ** (n - 1) * z, z**n
    elif n.is_Integer:
        along, across = z**n, size**n
    else:
        along, across = size ** (n - 1) * z, size**n
    rate = alpha * SLIP - beta * SPEED * along - gamma * SLIP * across
    memory = Memory((rate,), z, alpha, z**2 / (2 * alpha), beta - sp.Abs(gamma))
    return Law(most, most, source="Wen (1976)", memory=memory, requirements=asked)
