"""Mass on a moving belt without excitation: vibration in pure slip and with stick-slip, Thomsen (20)-(30)."""

from typing import Any

import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.model.arguments import is_one_of
from symfric.model.scene import Scene
from symfric.model.symbols import shortened
from symfric.theory.belt.scene import SYMBOLS, Symbols, on_belt, value
from symfric.theory.belt.sliding import ETA, V_B1, vibrating

v_b, beta, gamma2, a, Omega, mu_s, mu_m, v_m = SYMBOLS
V_B0 = 2 / sp.sqrt(5) * V_B1
A0 = 2 * v_m * sp.sqrt(1 - (v_b / v_m) ** 2 - 2 * beta / ETA)
KAPPA = ETA * (1 - (v_b / v_m) ** 2 / 3) - 2 * beta  # (release position - equilibrium)/v_b
EXCESS = 5 * sp.pi / 4 * ETA / v_m**2 * (V_B0**2 - v_b**2)  # growth of the arc's radius over one period


def _order(order: int) -> int:
    if not is_one_of(order, (1, 2)):
        raise SceneError(f"order is {shortened(order)}; the amplitudes are given to order 1 or 2")
    return order


@on_belt(vibrating)
def stick_speed(scene: Scene | None = None, order: int = 1, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the belt speed v_b0 below which the vibration sticks, dimensionless.

    Raises
    ------
    NotFound
        If steady sliding is stable at every speed.

    Notes
    -----
    ``v_b0 = sqrt(4/5) v_b1``: Thomsen (21), printed there with 4/3, which contradicts its own numbers. Order 2
    multiplies by ``1 + 3461 eta^2 v_b1^4/(120000 v_m^4)``, from the second-order expansion of the largest velocity.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.stick_speed(belt), 6)
    0.394405
    """
    factor = 1 + sp.Rational(3461, 120000) * ETA**2 * V_B1**4 / v_m**4
    return V_B0 * (1 if _order(order) == 1 else factor)


def slipping(scene: Scene | None = None, order: int = 1) -> Symbols:
    """Return the scene's numbers, or raise if it does not vibrate in pure slip."""
    given = vibrating(scene)
    low, high = value(stick_speed(order=order, symbolic=True), given), value(V_B1, given)
    if not low <= given.v_b <= high:
        there = "stick-slip" if given.v_b < low else "steady sliding, stable"
        raise NotFound(
            f"no vibration in pure slip at v_b = {given.v_b:g}: it exists from {low:.6g} to {high:.6g} ({there})"
        )
    return given


def sticking(scene: Scene | None = None, order: int = 1) -> Symbols:
    """Return the scene's numbers, or raise if its vibration does not stick."""
    given = vibrating(scene)
    top = value(stick_speed(order=order, symbolic=True), given)
    if not given.v_b < top:
        raise NotFound(f"no stick-slip vibration at v_b = {given.v_b:g}: the mass sticks below v_b0 = {top:.6g} only")
    return given


@on_belt(slipping)
def pure_slip_amplitude(scene: Scene | None = None, order: int = 1, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the amplitude A0 of vibration in pure slip, dimensionless; for order 2 the half range of x.

    Raises
    ------
    NotFound
        If the belt speed is outside [v_b0, v_b1]: stick-slip below, steady sliding above.

    Notes
    -----
    ``A0 = 2 sqrt(v_b1^2 - v_b^2)``, Thomsen (20). Order 2 multiplies by ``1 + eta^2 (v_b1^2 - v_b^2)(207 v_b^2 + 17
    v_b1^2)/(192 v_m^4)``, the Krylov-Bogoliubov-Mitropolsky expansion of `symfric.theory.second_order`.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.42)
    >>> round(sf.theory.belt.pure_slip_amplitude(belt), 6)
    0.268659
    """
    wide = (V_B1**2 - v_b**2) * (207 * v_b**2 + 17 * V_B1**2)
    return A0 * (1 if _order(order) == 1 else 1 + ETA**2 * wide / (192 * v_m**4))


@on_belt(slipping)
def pure_slip_frequency(scene: Scene | None = None, order: int = 1, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the frequency of vibration in pure slip over the natural one.

    Raises
    ------
    NotFound
        If the belt speed is outside [v_b0, v_b1].

    Notes
    -----
    1, Thomsen (16); order 2 adds ``-eta^2 (v_b1^2 - v_b^2)(29 v_b^2 + 3 v_b1^2)/(48 v_m^4)``.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.42)
    >>> round(sf.theory.belt.pure_slip_frequency(belt), 6)
    1.0
    """
    wide = (V_B1**2 - v_b**2) * (29 * v_b**2 + 3 * V_B1**2)
    return sp.Integer(1) - (0 if _order(order) == 1 else ETA**2 * wide / (48 * v_m**4))


@on_belt(vibrating)
def largest_pure_slip_amplitude(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the amplitude of pure slip where sticking starts, A0 at v_b0, dimensionless.

    Notes
    -----
    Equal to v_b0: Thomsen (22), printed there with 4/3 for 4/5. It is not the largest amplitude of all: at v_b0
    `stick_slip_amplitude` exceeds it.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.largest_pure_slip_amplitude(belt), 6)
    0.394405
    """
    return V_B0


@on_belt()
def release_position(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the position ``gamma2 mu_s - 2 beta v_b`` at which sticking ends, dimensionless; Thomsen (25).

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.release_position(belt), 6)
    0.38
    """
    return gamma2 * mu_s - 2 * beta * v_b


@on_belt(sticking)
def slip_arc(scene: Scene | None = None, *, symbolic: bool = False) -> tuple[Any, ...]:
    """Return A1 and theta1 of the slip ``x = A1 sin(tau + theta1) + xbar`` after release at tau = 0; Thomsen (26).

    Notes
    -----
    Starts from `release_position` with the belt's velocity: ``A1 sin theta1 = v_b kappa``, ``A1 cos theta1 = v_b`` with
    ``kappa = eta (1 - (v_b/v_m)^2/3) - 2 beta``.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> A1, theta1 = sf.theory.belt.slip_arc(belt)
    >>> round(A1, 6)
    0.210359
    """
    return v_b * sp.sqrt(1 + KAPPA**2), sp.atan(KAPPA)


@on_belt(sticking)
def stick_slip_amplitude(scene: Scene | None = None, order: int = 1, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the amplitude of stick-slip vibration, dimensionless; for order 2 the half range of x.

    Raises
    ------
    NotFound
        If the belt speed is above v_b0.

    Notes
    -----
    Order 1 is Thomsen (27), (28): ``A1 = v_b sqrt(1 + (eta (1 - (v_b/v_m)^2/3) - 2 beta)^2)``, the amplitude of an
    undamped slip arc. It lacks a term of first order in eta, what the damping force adds along the arc. Order 2 has it:
    ``v_b (1 + (5 pi/8)(eta/v_m^2)(v_b0^2 - v_b^2))``, from ``r' = -h(r cos psi) cos psi`` integrated from the release
    at psi = 0 to the largest (pi/2) and smallest position (3 pi/2); it meets the amplitude of pure slip at v_b0.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.stick_slip_amplitude(belt), 6)
    0.210359
    """
    return v_b * sp.sqrt(1 + KAPPA**2) if _order(order) == 1 else v_b * (1 + EXCESS / 2)


@on_belt(sticking)
def slow_belt_amplitude(scene: Scene | None = None, order: int = 1, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the amplitude of stick-slip vibration on a slow belt, dimensionless.

    Notes
    -----
    v_b, Thomsen (30), whose error is of order ``v_b (eta - 2 beta)^2`` as an expansion of (28), not ``v_b eta beta``.
    Order 2 is the limit of `stick_slip_amplitude` at order 2, ``v_b (1 + (pi/2)(eta - 2 beta))``.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.slow_belt_amplitude(belt), 6)
    0.2
    """
    return v_b if _order(order) == 1 else v_b * (1 + sp.pi / 2 * (ETA - 2 * beta))


@on_belt(sticking)
def stick_slip_frequency(scene: Scene | None = None, order: int = 1, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the frequency of stick-slip vibration over the natural one.

    Raises
    ------
    NotFound
        If the belt speed is above v_b0.

    Notes
    -----
    ``2 pi/(slip time + stick time)``, Thomsen (29). Order 1 takes the undamped arc of `slip_arc`: slip for ``2 pi - 2
    theta1``, stick over ``2 v_b kappa``. Order 2 lets the radius of the arc grow to ``v_b (1 + d)`` with ``d = (5 pi/4)
    (eta/v_m^2)(v_b0^2 - v_b^2)``, so that sticking starts at ``psi = 2 pi - acos(1/(1 + d))``, a distance
    ``v_b sqrt(d^2 + 2 d)`` below the equilibrium. The values 0.86 and 0.83 given after (29) do not follow from
    the model.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.stick_slip_frequency(belt), 6)
    0.996554
    """
    early, before = sp.atan(KAPPA), KAPPA
    if _order(order) == 2:
        grown = sp.Max(EXCESS, 0)
        early, before = sp.acos(1 / (1 + grown)), sp.sqrt(grown**2 + 2 * grown)
    return 2 * sp.pi / (2 * sp.pi - sp.atan(KAPPA) - early + KAPPA + before)
