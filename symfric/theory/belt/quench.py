"""Mass on a moving belt under fast excitation: quenching of its vibration and what it takes, Thomsen (54)-(61)."""

from typing import Any, Literal, overload

import sympy as sp

from symfric.errors import SceneError
from symfric.model.scene import Scene
from symfric.model.symbols import finite, positive, shortened
from symfric.theory.belt.effective import ALPHA1, ALPHA3, DAMPING, Q, least_damping_intensity
from symfric.theory.belt.scene import SYMBOLS, Symbols, numbers, on_belt, value
from symfric.theory.belt.sliding import ETA, V_B1
from symfric.theory.belt.slip import V_B0
from symfric.theory.closed_form import closed_form

v_b, beta, gamma2, a, Omega, mu_s, mu_m, v_m = SYMBOLS
Q_STAR = sp.sqrt(sp.Rational(2, 3)) * v_m * sp.sqrt(1 - 2 * beta / ETA)
_V_HAT = sp.Symbol("v_hat", positive=True)


def _check_slow_belts(given: Symbols, q: float) -> None:
    """Raise if belts slower than q vibrate too; the effective slope there is least at rest."""
    slope = value(DAMPING, given._replace(a=q, Omega=1.0)) + 2 * given.beta / given.gamma2
    if slope < 0:
        raise SceneError(
            f"the closed forms do not hold: at intensity {q:.6g} the effective friction falls at rest (slope "
            f"with damping {slope:.4g}), because mu_m/mu_s = {given.mu_m / given.mu_s:.3g} is too small; "
            "see sf.design.quench"
        )


def _vibrates(given: Symbols) -> bool:
    return bool(value(ETA, given) > 2 * given.beta)


def _unstable(formulas: tuple[sp.Expr, sp.Expr], scene: Scene | None = None) -> tuple[float, float] | None:
    given = numbers(scene)
    if not _vibrates(given):
        return None
    q = abs(given.a * given.Omega)
    if q > 0:
        _check_slow_belts(given, q)
    return (q, value(formulas[1], given)) if q < value(Q_STAR, given) else None


def _everywhere(formula: sp.Expr, scene: Scene | None = None) -> float:
    """Return the intensity (56), or raise if vibration of any intensity above would not suffice."""
    given = numbers(scene)
    if not _vibrates(given):
        return 0.0
    q = value(formula, given)
    # the damping at rest is convex in the intensity, least at q_0
    _check_slow_belts(given, max(q, least_damping_intensity(scene)))
    return q


def _quenching(formula: sp.Expr, scene: Scene | None = None, *_: Any, **__: Any) -> float:
    given = numbers(scene)
    if not _vibrates(given):
        return 0.0
    result = value(formula, given)
    if result > 0:
        _check_slow_belts(given, result)
    return result


@overload
def unstable_speeds(scene: Scene | None = None, *, symbolic: Literal[True]) -> tuple[sp.Expr, sp.Expr]: ...


@overload
def unstable_speeds(scene: Scene | None = None, *, symbolic: bool = False) -> tuple[Any, ...] | None: ...


@closed_form(_unstable)
def unstable_speeds(scene: Scene | None = None, *, symbolic: bool = False) -> tuple[Any, ...] | None:
    """Return the belt speeds (low, high) between which the mass vibrates by itself at the scene's a Omega.

    Returns
    -------
    (float, float), (Expr, Expr) or None
        None if there are none.

    Raises
    ------
    SceneError
        If the effective friction falls at rest faster than the damping allows: then slower belts are unstable too.

    Notes
    -----
    ``a Omega < v_b < v_m sqrt(1 - (a Omega/v_m)^2/2 - 2 beta/eta)``. Thomsen (55) has <= at the lower end, where small
    vibrations die out: the slope of the effective friction on its left is infinite. Without excitation this is (0,
    v_b1).

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> low, high = sf.theory.belt.unstable_speeds(belt)
    >>> round(high, 6)
    0.440959
    """
    return Q, v_m * sp.sqrt(1 - (Q / v_m) ** 2 / 2 - 2 * beta / ETA)


@closed_form(_everywhere)
def quench_intensity(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the intensity a Omega above which no belt speed gives vibration, dimensionless; Thomsen (56).

    Raises
    ------
    SceneError
        If the effective friction falls with speed below a Omega for some intensity above: fast vibration of the
        intensity (56) is then not enough.

    Notes
    -----
    ``sqrt(2/3) v_m sqrt(1 - 2 beta/eta)``; 0.0 where nothing vibrates anyway.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.quench_intensity(belt), 6)
    0.360041
    """
    return Q_STAR


def _speed(v: Any, symbolic: bool) -> sp.Expr:
    if v is None:
        if not symbolic:
            raise SceneError("no belt speed; give the speed at which vibration shall be quenched as v")
        return _V_HAT
    if isinstance(v, sp.Expr) and not v.is_number and symbolic:
        return v
    return sp.Float(positive(v, "the belt speed v"))


@closed_form(_quenching)
def quench_intensity_at(
    scene: Scene | None = None, v: float | None = None, *, symbolic: bool = False
) -> float | sp.Expr:
    """Return the intensity a Omega above which a belt of speed v gives no vibration, dimensionless; Thomsen (57).

    Parameters
    ----------
    scene : Scene
        Its own belt speed is ignored.
    v : float
        Belt speed, > 0; the symbol v_hat where `symbolic` without it.

    Notes
    -----
    v up to a Omega*, ``sqrt(3 (a Omega*)^2 - 2 v^2)`` from there to v_b1, and 0 beyond, where the printed root is
    imaginary and nothing vibrates.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.quench_intensity_at(belt, 0.2), 6)
    0.2
    """
    speed = _speed(v, symbolic)
    return sp.Piecewise(
        (speed, speed <= Q_STAR), (sp.sqrt(3 * Q_STAR**2 - 2 * speed**2), speed < V_B1), (0, True), evaluate=False
    )


@closed_form(_quenching)
def quench_intensity_below(
    scene: Scene | None = None, v: float | None = None, *, symbolic: bool = False
) -> float | sp.Expr:
    """Return the intensity a Omega above which no belt speed up to v gives vibration; Thomsen (58).

    Parameters
    ----------
    scene : Scene
        Its own belt speed is ignored.
    v : float
        Belt speed, > 0; the symbol v_hat where `symbolic` without it.

    Notes
    -----
    v up to a Omega*, and a Omega* beyond.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> round(sf.theory.belt.quench_intensity_below(belt, 0.2), 6)
    0.2
    """
    return sp.Min(_speed(v, symbolic), Q_STAR)


def _range(speeds: Any, symbolic: bool) -> tuple[sp.Expr, sp.Expr]:
    """Return both ends of a range of belt speeds as expressions."""
    if speeds is None and symbolic:
        return sp.Symbol("v_low", positive=True), sp.Symbol("v_high", positive=True)
    try:
        low, high = speeds
    except (TypeError, ValueError):
        raise SceneError(f"speeds is {shortened(speeds)}; give the lowest and the highest belt speed") from None
    low, high = finite(low, "the lowest belt speed"), float(high)
    if not 0 <= low <= high:
        raise SceneError(f"speeds is ({low:g}, {high:g}); the lower one comes first and is not negative")
    if high == 0:
        raise SceneError("the highest of the speeds is 0; a belt at rest excites no vibration")
    return sp.Float(low), sp.oo if high == float("inf") else sp.Float(high)


@closed_form(_quenching)
def quench_intensity_for(
    scene: Scene | None = None, speeds: tuple[float, float] | None = None, *, symbolic: bool = False
) -> float | sp.Expr:
    """Return the intensity a Omega above which no belt speed of a range gives vibration, dimensionless.

    Parameters
    ----------
    scene : Scene
        Its own belt speed is ignored.
    speeds : (float, float)
        Lowest and highest belt speed, 0 <= low <= high; the highest may be infinite: "above a speed". The symbols
        v_low and v_high where `symbolic` without it.

    Returns
    -------
    float or Expr
        0 where nothing vibrates anyway.

    Raises
    ------
    SceneError
        If the speeds are not a range, or the closed forms do not hold: see `quench_intensity`.

    Notes
    -----
    A belt of speed v vibrates for ``a Omega < min(v, sqrt(2 (v_b1^2 - v^2)))``, Thomsen (55). The first one rises with
    v, the second one falls, and they meet at ``v = a Omega*``, (56); so the largest over the range is at its upper end
    below a Omega*, at its lower end above, and a Omega* for a range that contains it. (57) and (58) are the cases (v,
    v) and (0, v). Proved in derivations/thomsen.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.mass_on_belt(v_b=0.3)
    >>> round(sf.theory.belt.quench_intensity_for(scene, (0.38, 0.5)), 7)
    0.3163683
    """
    low, high = _range(speeds, symbolic)
    return sp.Piecewise(
        (high, high <= Q_STAR),
        (Q_STAR, low <= Q_STAR),
        (sp.sqrt(3 * Q_STAR**2 - 2 * low**2), low < V_B1),
        (0, True),
        evaluate=False,
    )


@on_belt()
def mean_power(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the mean power of the excitation at quasi-equilibrium, dimensionless.

    Notes
    -----
    ``<x' (2 beta x' + gamma2 mu(x' - v_b))>`` for ``x' = -q cos``, q = a Omega: ``beta q^2 + gamma2 (alpha1 q^2/2 +
    alpha3 (3 v_b^2 q^2/2 + 3 q^4/8))``, and ``(2 gamma2 mu_s/pi) sqrt(q^2 - v_b^2)`` more for v_b < q. Thomsen (59) is
    called the energy required, and is the kinetic energy of the fast motion.

    Examples
    --------
    >>> import symfric as sf
    >>> shaken = sf.scenes.mass_on_belt(v_b=0.2, a=0.005, Omega=50.0)
    >>> round(sf.theory.belt.mean_power(shaken), 6)
    0.030389
    """
    smooth = beta * Q**2 + gamma2 * (ALPHA1 * Q**2 / 2 + ALPHA3 * (3 * v_b**2 * Q**2 / 2 + 3 * Q**4 / 8))
    jump = sp.Piecewise((2 * gamma2 * mu_s / sp.pi * sp.sqrt(Q**2 - v_b**2), v_b**2 < Q**2), (0, True))
    return smooth + jump


@closed_form(float)
def energy_ratio(*, symbolic: bool = False) -> float | sp.Expr:
    """Return the kinetic energy of the quenching fast motion over that of the largest pure slip, 5/6; Thomsen (61).

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.belt.energy_ratio(symbolic=True)
    5/6
    """
    return sp.simplify((Q_STAR / V_B0) ** 2)
