"""Rate-and-state friction of rock: a coefficient that depends on the speed and on the age of the contacts."""

from typing import Literal

import sympy as sp

from symfric.errors import SceneError
from symfric.model.arguments import flag, is_one_of
from symfric.model.laws.arguments import Parameter, parameters_of, ready_law
from symfric.model.laws.law import Law
from symfric.model.laws.memory import SIDE, SLIP, Memory, state_symbols
from symfric.model.symbols import SPEED, shortened

_LEAST = sp.Float("1e-20")  # of V0: speed below which the logarithm of the slip law is rounded off


@ready_law
def rate_and_state(
    mu0: Parameter,
    a: Parameter,
    b: Parameter,
    D_c: Parameter,
    V0: Parameter,
    law: Literal["aging", "slip"] = "aging",
    smooth: bool = True,
) -> Law:
    r"""Rate-and-state law of Dieterich and Ruina.

    Parameters
    ----------
    mu0 : float or Expr
        Coefficient in steady sliding at the speed V0, > 0, dimensionless.
    a, b : float or Expr
        Direct effect of the speed and effect of the state, > 0, dimensionless; with a < b friction falls with speed.
    D_c : float or Expr
        Distance over which the contacts renew, > 0, length.
    V0 : float or Expr
        Reference speed, > 0, in the unit of the slip velocity.
    law : {"aging", "slip"}
        How the state evolves: at rest too, or with slip alone.
    smooth : bool
        Whether the coefficient passes smoothly through zero velocity; if not, it is a logarithm, for slip that never
        stops.

    Returns
    -------
    Law
        With one state, :math:`z = \ln(V_0\theta/D_c)`, dimensionless: the logarithm of the age theta of the contacts,
        which therefore is always positive. Zero, where it starts unless given, is :math:`\theta = D_c/V_0`, the age in
        steady sliding at V0. Stiffness infinite: friction rises with the speed at once.

    Raises
    ------
    SceneError
        If a parameter is out of range, or the law is unknown.

    Notes
    -----
    :math:`\mu = a\,\mathrm{asinh}\left(\frac{w}{2V_0}e^{(\mu_0 + bz)/a}\right)`, or
    :math:`\mu_0 + a\ln(|w|/V_0) + bz` if not smooth; aging: :math:`\theta' = 1 - |w|\theta/D_c`, slip:
    :math:`\theta' = -(|w|\theta/D_c)\ln(|w|\theta/D_c)`. J. H. Dieterich, Journal of Geophysical Research 84 (1979)
    2161; A. L. Ruina, Journal of Geophysical Research 88 (1983) 10359; the smooth form: Rice, Lapusta and Ranjith,
    Journal of the Mechanics and Physics of Solids 49 (2001) 1865. Steady sliding: :math:`\mu_0 + (a - b)\ln(v/V_0)`.
    Under the normal load N a slider on a spring of stiffness below :math:`N(b - a)/D_c` is unstable without inertia. It
    dissipates whatever the motion.

    Examples
    --------
    >>> import symfric as sf
    >>> law = sf.laws.rate_and_state(0.6, 0.01, 0.015, 1e-5, 1e-6)
    >>> round(law(1e-6), 12), round(law(1e-5), 12)
    (0.6, 0.588487074535)
    """
    flag(smooth, "smooth")
    positive = {"mu0": mu0, "a": a, "b": b, "D_c": D_c, "V0": V0}
    (mu0, a, b, D_c, V0), asked = parameters_of("rate_and_state", positive)
    if not is_one_of(law, ("aging", "slip")):
        raise SceneError(f"law of rate_and_state is {shortened(law)}; there are aging, slip")
    (z,) = state_symbols(1)
    force = a * sp.asinh(SLIP / (2 * V0) * sp.exp((mu0 + b * z) / a))
    if not smooth:
        force = SIDE * (mu0 + a * sp.log(SPEED / V0) + b * z)
    if law == "aging":
        rate = (V0 * sp.exp(-z) - SPEED) / D_c
    else:
        rate = -SPEED / D_c * (z + sp.log((SLIP / V0) ** 2 + _LEAST**2) / 2)
    steady = mu0 + (a - b) * sp.log(SPEED / V0)
    memory = Memory((rate,), force, sp.oo, sp.S.Zero, slowest=_LEAST * V0)
    return Law(steady, mu0, source="Dieterich (1979), Ruina (1983)", memory=memory, requirements=asked)
