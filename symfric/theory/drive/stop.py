"""Positioning error of a slide whose drive stops, Guida (10)-(20)."""

from dataclasses import dataclass

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import is_one_of
from symfric.model.results import Result
from symfric.model.symbols import finite, shortened
from symfric.spelling import spelt
from symfric.theory.closed_form import closed_form
from symfric.theory.drive.excursion import FreeResponse, descent, excursion, slope

MU1, LAM = sp.Symbol("mu1", real=True), sp.Symbol("lambda", positive=True)


@dataclass(frozen=True, repr=False)
class PositioningError(Result):
    """Positioning error of a slide after its drive has stopped.

    Attributes
    ----------
    value : float
        Delta S over v*/omega_n, up to the first rest.
    type : {"a", "b", "c", "none"}
        "a": the speed stays below v*; "b", "c": it exceeds v*, with mu2 >= 1 and below 1; "none": the slide does not
        move, because its static friction carries the spring.

    Examples
    --------
    >>> import symfric as sf
    >>> error = sf.theory.drive.positioning_error(-0.5, 0.8, 4.0)
    >>> error.type
    'c'
    >>> sorted(error.to_dict())
    ['type', 'value']
    """

    value: float
    type: str

    def __repr__(self) -> str:
        return f"PositioningError({self.value:.6g}, type {self.type})"


@alone(SYMBOLIC)
def positioning_error(
    mu1: float,
    mu2: float,
    lam: float,
    *,
    epsilon: float = 0.0,
    slide: str = "at rest",
    damper: str = "ground",
    sigma: float = 0.0,
) -> PositioningError:
    """Return the positioning error of a slide after its drive has stopped.

    Parameters
    ----------
    mu1, mu2 : float
        Slopes below and above v*, damper included, as in `threshold`. After the stop a damper on the support and one
        to ground act alike.
    lam : float
        Force of the spring at the stop less the kinetic friction at rest, over ``m omega_n v*``; see `excess`.
    epsilon : float
        ``(F_as - F_ac)/(m omega_n v*)`` >= 0.
    slide : {"at rest", "moving"}
        What the slide does when the drive stops: it rests with the spring's force of steady sliding, as the source
        assumes, or still has the drive's speed. That speed follows from `lam`, by the inverse of `excess`.
    damper : {"ground", "support"}
        Where the damper sits. Without effect on a slide at rest; with a moving one it decides which speed belongs to
        `lam`, and on the support its force jumps from 0 to 2 sigma V.
    sigma : float
        Its damping ratio ``c/(2 sqrt(k m))`` >= 0; enters with a damper on the support and a moving slide only.

    Returns
    -------
    PositioningError
        Up to the first rest, whether or not the static friction then holds the compressed spring. Infinite if mu2 <= -1
        lets the slide run away.

    Raises
    ------
    SceneError
        If an argument is bad, or no steady speed of a moving slide belongs to `lam`.

    Notes
    -----
    Guida (15), (20). With w = x' the motion is ``w'' + 2 mu(w) w' + w = 0`` from (w, w') = (0, lambda), and ends at
    w = 0 with ``w' = -Delta S_lambda``; ``Delta S = lambda + Delta S_lambda``. A slide at rest holds exactly if
    ``lambda <= eps``. The source's (19b) is the limit `steep_error`. Proved in derivations/guida.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.drive.positioning_error(-0.5, 0.8, 4.0)
    PositioningError(6.28739, type c)
    """
    mu1, mu2, lam, epsilon = slope(mu1, "mu1"), slope(mu2, "mu2"), finite(lam, "lam"), finite(epsilon, "epsilon")
    if epsilon < 0:
        raise SceneError(f"epsilon is {epsilon:g}; static friction is not below the kinetic one, so give it >= 0")
    shift = _damper_share(damper, sigma)
    if slide == "moving":
        return _from_motion(mu1, mu2, lam, shift)
    if slide != "at rest":
        raise SceneError(f"slide is {slide!r}; it is 'at rest' or 'moving' when the drive stops")
    if lam <= epsilon:
        return PositioningError(0.0, "none")
    speed, crossed = excursion(0.0, lam, 1.0, mu1, mu2)
    return PositioningError(lam + speed, _type(mu2) if crossed else "a")


@spelt
def excess(mu1: float, mu2: float, speed: float, *, damper: str = "ground", sigma: float = 0.0) -> float:
    """Return lambda, the spring's force in steady sliding less the kinetic friction at rest, over ``m omega_n v*``.

    Parameters
    ----------
    mu1, mu2 : float
        Slopes below and above v*, damper included.
    speed : float
        V = v/v* > 0.
    damper : {"ground", "support"}
        On the support it carries nothing in steady sliding, so that its share 2 sigma of the slopes is left out.
    sigma : float
        Damping ratio >= 0.

    Returns
    -------
    float

    Raises
    ------
    SceneError
        If an argument is out of its range.

    Notes
    -----
    Guida (8), (14): ``f(0) - f_c = 2 mu1 + 2 mu2 (V - 1)`` for V >= 1 and ``2 mu1 V`` below, to ground.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.drive.excess(-0.5, 0.8, 2.0), 6)
    0.6
    """
    mu1, mu2, speed = slope(mu1, "mu1"), slope(mu2, "mu2"), finite(speed, "speed")
    if not speed > 0:
        raise SceneError(f"speed is {speed:g}; it is v/v* of a drive that moves, so give it > 0")
    shift = _damper_share(damper, sigma)
    return 2 * (mu1 - shift) * min(speed, 1.0) + 2 * (mu2 - shift) * max(speed - 1.0, 0.0)


def _limit(formula: sp.Expr, mu1: float | None = None) -> float:
    mu1 = finite(mu1, "mu1")
    if mu1 <= -1:
        return 0.0
    return float(sp.E if mu1 == 1 else sp.re(formula.subs(MU1, sp.Float(mu1, 17)).evalf(17)))


@closed_form(_limit)
def type_limit(mu1: float | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the largest lambda of type "a"; 0 for mu1 <= -1.

    Notes
    -----
    ``exp(mu1 acos(mu1)/sqrt(1 - mu1^2))``: the free motion on the first section reaches its largest speed, here v*,
    after ``acos(mu1)/sqrt(1 - mu1^2)``; the point E* of Guida, figure 9.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.drive.type_limit(-0.5), 6)
    0.298436
    """
    return sp.exp(MU1 * sp.acos(MU1) / sp.sqrt(1 - MU1**2))


def _underdamped(formula: sp.Expr, mu1: float | None = None, lam: float | None = None) -> float:
    mu1, lam = finite(mu1, "mu1"), finite(lam, "lam")
    if not (-1 < mu1 < 1 and lam > 0):
        raise SceneError(f"mu1 is {mu1:g} and lam {lam:g}; the formula holds for |mu1| < 1 and lam > 0")
    return float(formula.subs({MU1: sp.Float(mu1, 17), LAM: sp.Float(lam, 17)}).evalf(17))


@closed_form(_underdamped)
def single_section_error(
    mu1: float | None = None, lam: float | None = None, *, symbolic: bool = False
) -> float | sp.Expr:
    """Return Delta S of type "a", ``|mu1| < 1``; Guida (19) line 1, which prints Delta S_lambda for it.

    Notes
    -----
    ``lambda (1 + exp(-mu1 pi/sqrt(1 - mu1^2)))``.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.drive.single_section_error(-0.5, 1.0), 6)
    7.133707
    """
    return LAM * (1 + sp.exp(-MU1 * sp.pi / sp.sqrt(1 - MU1**2)))


@closed_form(_underdamped)
def steep_error(mu1: float | None = None, lam: float | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    """Return the limit of Delta S for mu2 -> infinity, ``|mu1| < 1``; Guida (19) line 2, where a factor is missing.

    Notes
    -----
    ``lambda + exp(-mu1 acos(-mu1)/sqrt(1 - mu1^2))``; for mu1 < 0, with psi of (18), ``lambda - 2 mu1 psi(0, mu1)
    /psi(-1/(2 mu1), mu1)``. The speed stays v* until the slide is ``-2 mu1`` beyond the kinetic equilibrium. Nearly so
    for type "b"; it holds where lambda exceeds `type_limit`.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.drive.steep_error(-0.5, 4.0), 6)
    5.830519
    """
    return LAM + sp.exp(-MU1 * sp.acos(-MU1) / sp.sqrt(1 - MU1**2))


def _type(mu2: float) -> str:
    return "b" if mu2 >= 1 else "c"


def _damper_share(damper: str, sigma: float) -> float:
    """Return the slope that the damper adds after the stop but not in steady sliding."""
    sigma = finite(sigma, "sigma")
    if sigma < 0:
        raise SceneError(f"sigma is {sigma:g}; a damper's ratio is >= 0")
    if not is_one_of(damper, ("ground", "support")):
        raise SceneError(f"damper is {shortened(damper)}; it goes to 'ground' or sits on the 'support'")
    return sigma if damper == "support" else 0.0


def _from_motion(mu1: float, mu2: float, lam: float, shift: float) -> PositioningError:
    """Return the error of a slide that moves with the drive's speed when the drive stops."""
    first, second = 2 * (mu1 - shift), 2 * (mu2 - shift)
    if 0 < lam < first:
        speed = lam / first
    elif lam >= first and second > 0:
        speed = 1 + (lam - first) / second
    else:
        raise SceneError(
            f"lam is {lam:g}: no speed of steady sliding belongs to it (tan(alpha1) = {first:g}, tan(alpha2) = "
            f"{second:g} without the damper on the support); see excess"
        )
    deceleration = 2 * shift * speed  # by the damper, whose support no longer moves
    corner = min(speed, 1.0)
    if speed > 1:
        deceleration = descent(FreeResponse(mu2), speed, deceleration, 1.0)
    landing = descent(FreeResponse(mu1), corner, deceleration, 0.0)
    return PositioningError(lam + landing, _type(mu2) if speed > 1 else "a")
