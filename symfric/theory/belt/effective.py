"""Mass on a moving belt under fast excitation: effective friction and its slope, Thomsen (43)-(53)."""

from typing import Any

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import flag
from symfric.model.laws import Law, cubic
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED
from symfric.theory.belt.scene import SYMBOLS, Symbols, numbers, on_belt

v_b, beta, gamma2, a, Omega, mu_s, mu_m, v_m = SYMBOLS
Q = a * Omega
ALPHA1 = -sp.Rational(3, 2) * (mu_s - mu_m) / v_m
ALPHA3 = (mu_s - mu_m) / (2 * v_m**3)
DAMPING = 2 * mu_s / (sp.pi * Q) + ALPHA1 + sp.Rational(3, 2) * ALPHA3 * Q**2


def shaken(scene: Scene | None = None) -> Symbols:
    """Return the scene's numbers with |a Omega| > 0."""
    given = numbers(scene)
    if not given.a * given.Omega != 0:
        raise SceneError("the scene has no excitation, a Omega = 0; give a and Omega values with where()")
    return given._replace(a=abs(given.a), Omega=abs(given.Omega))


def _falling(scene: Scene | None = None) -> Symbols:
    """Return the scene's numbers, or raise if friction does not fall with speed."""
    given = numbers(scene)
    if not given.mu_s > given.mu_m:
        raise SceneError("mu_m is not below mu_s: the effective damping falls with the intensity for ever")
    return given


@on_belt()
def law_coefficients(scene: Scene | None = None, *, symbolic: bool = False) -> tuple[Any, ...]:
    """Return alpha0, alpha1, alpha3 of ``mu = alpha0 sgn v + alpha1 v + alpha3 v^3``; Thomsen (43), (44).

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> alpha0, alpha1, alpha3 = sf.theory.belt.law_coefficients(belt)
    >>> round(alpha0, 6)
    0.4
    """
    return mu_s, ALPHA1, ALPHA3


@alone(SYMBOLIC)
def effective_friction(scene: Scene | None = None, *, symbolic: bool = False) -> Law:
    """Return the effective law under the scene's intensity a Omega > 0; Thomsen (47).

    Parameters
    ----------
    scene : Scene, optional
        A `sf.scenes.mass_on_belt` with the cubic law.
    symbolic : bool
        Return the formula in `SYMBOLS` instead of a number.

    Returns
    -------
    Law

    Examples
    --------
    >>> import symfric as sf
    >>> shaken = sf.scenes.mass_on_belt(v_b=0.2, a=0.005, Omega=50.0)
    >>> round(sf.theory.belt.effective_friction(shaken)(0.1), 6)
    0.066017
    """
    if flag(symbolic, "symbolic"):
        return cubic(mu_s, mu_m, v_m).averaged(Q)
    given = shaken(scene)
    return cubic(given.mu_s, given.mu_m, given.v_m).averaged(abs(given.a * given.Omega))


@on_belt(shaken)
def effective_damping(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the slope of the effective friction at rest, alpha1-hat, 1/speed; Thomsen (48)-(50).

    Notes
    -----
    ``2 mu_s/(pi q) + alpha1 + 3 alpha3 q^2/2``, q = a Omega; least at `least_damping_intensity`.

    Examples
    --------
    >>> import symfric as sf
    >>> shaken = sf.scenes.mass_on_belt(v_b=0.2, a=0.005, Omega=50.0)
    >>> round(sf.theory.belt.effective_damping(shaken), 6)
    0.624842
    """
    return DAMPING


@on_belt(shaken)
def effective_cubic(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the cubic coefficient of the effective friction at rest, alpha3-hat; Thomsen (48)-(50).

    Examples
    --------
    >>> import symfric as sf
    >>> shaken = sf.scenes.mass_on_belt(v_b=0.2, a=0.005, Omega=50.0)
    >>> round(sf.theory.belt.effective_cubic(shaken), 6)
    3.316244
    """
    return mu_s / (3 * sp.pi * Q**3) + ALPHA3


@on_belt(_falling)
def least_damping_intensity(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the intensity at which `effective_damping` is least, dimensionless.

    Raises
    ------
    SceneError
        If friction does not fall, so that there is none.

    Notes
    -----
    ``q^3 = 4 v_m^3/(3 pi (1 - mu_m/mu_s))``; the sentence after Thomsen (50) lacks v_m^3.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.least_damping_intensity(belt), 6)
    0.521062
    """
    return v_m * sp.cbrt(4 / (3 * sp.pi * (1 - mu_m / mu_s)))


@on_belt(shaken)
def quasi_equilibrium_position(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the mean position under fast excitation, ``gamma2 mubar(v_b)``, dimensionless; Thomsen (51).

    Examples
    --------
    >>> import symfric as sf
    >>> shaken = sf.scenes.mass_on_belt(v_b=0.2, a=0.005, Omega=50.0)
    >>> round(sf.theory.belt.quasi_equilibrium_position(shaken), 6)
    0.162184
    """
    return gamma2 * cubic(mu_s, mu_m, v_m).averaged(Q).kinetic.subs(SPEED, v_b)


@on_belt(shaken)
def effective_slope(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the slope ``mubar'(v_b)`` of the effective friction, 1/speed; Thomsen (47), (53).

    Notes
    -----
    The quasi-equilibrium is unstable where it is below ``-2 beta/gamma2``, Thomsen (52). It tends to +infinity as v_b
    rises to a Omega, and starts from (53) there: the formula holds from a Omega on.

    Examples
    --------
    >>> import symfric as sf
    >>> shaken = sf.scenes.mass_on_belt(v_b=0.2, a=0.005, Omega=50.0)
    >>> round(sf.theory.belt.effective_slope(shaken), 6)
    1.375903
    """
    return cubic(mu_s, mu_m, v_m).averaged(Q).kinetic.diff(SPEED).subs(SPEED, v_b)
