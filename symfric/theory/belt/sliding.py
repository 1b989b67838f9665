"""Mass on a moving belt without excitation: steady sliding and its onset, Thomsen (7)-(19)."""

from typing import Any

import sympy as sp

from symfric.errors import NotFound
from symfric.model.laws import cubic
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED
from symfric.theory.belt.scene import SYMBOLS, Symbols, numbers, on_belt, value

v_b, beta, gamma2, a, Omega, mu_s, mu_m, v_m = SYMBOLS
ETA = sp.Rational(3, 2) * gamma2 * (mu_s - mu_m) / v_m
V_B1 = v_m * sp.sqrt(1 - 2 * beta / ETA)


def vibrating(scene: Scene | None = None, order: int = 1) -> Symbols:
    """Return the scene's numbers, or raise if steady sliding is stable at every speed."""
    given = numbers(scene)
    eta = value(ETA, given)
    if not eta > 2 * given.beta:
        raise NotFound(
            f"steady sliding is stable at every belt speed: the friction difference eta = {eta:.6g} does not exceed "
            f"2 beta = {2 * given.beta:.6g}"
        )
    return given


@on_belt()
def friction_difference(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the friction difference eta, dimensionless; Thomsen (10).

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.friction_difference(belt), 6)
    0.45
    """
    return ETA


@on_belt()
def equilibrium_position(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the position of steady sliding, ``gamma2 mu(v_b)``, dimensionless; Thomsen (7).

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.equilibrium_position(belt), 6)
    0.3148
    """
    return gamma2 * cubic(mu_s, mu_m, v_m).kinetic.subs(SPEED, v_b)


@on_belt()
def damping_slope(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return ``mu'(v_b) + 2 beta/gamma2``; steady sliding is unstable where it is negative, Thomsen (17).

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.damping_slope(belt), 6)
    -0.278
    """
    return cubic(mu_s, mu_m, v_m).kinetic.diff(SPEED).subs(SPEED, v_b) + 2 * beta / gamma2


@on_belt()
def damping_polynomial(scene: Scene | None = None, *, symbolic: bool = False) -> tuple[Any, ...]:
    """Return h1, h2, h3 of the damping force ``h1 u + h2 u^2 + h3 u^3`` in pure slip, dimensionless; Thomsen (18).

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> h1, h2, h3 = sf.theory.belt.damping_polynomial(belt)
    >>> round(h1, 6)
    -0.278
    """
    return 2 * beta - ETA * (1 - (v_b / v_m) ** 2), -ETA * v_b / v_m**2, ETA / (3 * v_m**2)


@on_belt(vibrating)
def onset_speed(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the belt speed v_b1 below which steady sliding is unstable, dimensionless.

    Raises
    ------
    NotFound
        If steady sliding is stable at every speed, ``2 beta >= eta``.

    Notes
    -----
    ``v_b1 = v_m sqrt(1 - 2 beta/eta)``, Thomsen (19).

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.onset_speed(belt), 6)
    0.440959
    >>> sf.theory.belt.onset_speed(symbolic=True)
    v_m*sqrt(-4*beta*v_m/(3*gamma2*(-mu_m + mu_s)) + 1)
    """
    return V_B1
