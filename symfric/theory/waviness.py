r"""Closed forms for a mass on a wavy belt, `symfric.scenes.wavy_belt`, with waves much shorter than the slow motion.

Over one wave spring, damper and friction do little, and the mass runs over the hills of the potential ``h cos(phi)``,
``h = F/k``, with the energy W: its slip is :math:`w(\phi) = \sqrt{2(W - h\cos\phi)}`. Means over the phase are denoted
by < >. The mean slip is the belt speed, ``1/v_b = <1/w>``. What the belt does, ``v_b`` times its mean force, friction
and damper take, so that the force is ``gamma2 <mu(w)> + 2 beta (<w> - v_b)``, and slow vibration grows where it falls
with the speed faster than the damper rises. Proved in derivations/waviness.py.

Valid far above resonance, ``k v_b >> 1``, and while the mass passes the hills: what friction takes over a wave, ``2 pi
gamma2 mu/k``, is little against ``W - h``. On slower belts it sticks on them; and wherever a push catches it in a
valley, it goes with the belt until the spring exceeds F, far out.
"""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import scenes
from symfric.model.arguments import instance, whole
from symfric.model.laws import Law
from symfric.model.public_names import names_of
from symfric.model.scene import Scene
from symfric.model.symbols import positive, shortened
from symfric.search import zero
from symfric.spelling import spelt
from symfric.theory.belt.scene import cubic_parameters
from symfric.theory.closed_form import closed_form

__all__ = ["SYMBOLS", "WavinessSymbols", "drag", "onset_speed", "sinusoidal_onset_speed", "slip_over_a_wave"]
_NODES = 256  # of the midpoint rule over a wave, which converges like a power series


class WavinessSymbols(NamedTuple):
    """Symbols of the closed forms, named as in `symfric.scenes.wavy_belt` and `symfric.laws.cubic`.

    Attributes
    ----------
    v_b, beta, gamma2, F, k, mu_s, mu_m, v_m : Symbol
        As in the scene: belt speed, damping ratio, load, waves of the belt, coefficients of the law.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.waviness.SYMBOLS.k
    k
    """

    v_b: sp.Symbol
    beta: sp.Symbol
    gamma2: sp.Symbol
    F: sp.Symbol
    k: sp.Symbol
    mu_s: sp.Symbol
    mu_m: sp.Symbol
    v_m: sp.Symbol


SYMBOLS = WavinessSymbols(*sp.symbols("v_b beta gamma2 F k mu_s mu_m v_m", positive=True))


@alone(SYMBOLIC)
def onset_speed(scene: Scene) -> float:
    r"""Return the belt speed above which steady sliding on a wavy belt is stable, dimensionless.

    Parameters
    ----------
    scene : Scene
        `symfric.scenes.wavy_belt` with `symfric.laws.cubic`; its v_b is not used.

    Returns
    -------
    float
        0 if it is stable at every speed, because the damper outweighs the falling friction.

    Raises
    ------
    SceneError
        If the scene or its law is another one.

    Notes
    -----
    ``v_b <w> = v_b1^2`` with ``v_b1^2 = v_m^2 (1 - 2 beta/eta)``, Thomsen (19); in elliptic integrals ``2 (W + h)
    E(m)/K(m) = v_b1^2``, ``m = 2 h/(W + h)``, and ``v_b = (pi/2) sqrt(2 (W + h))/K(m)``. The left side is the mean
    square of the slip in time, and is exactly that of the full model at its Neimark-Sacker point.

    Examples
    --------
    >>> import symfric as sf
    >>> flat = sf.scenes.wavy_belt(v_b=0.3, F=0.0, k=100.0)
    >>> f"{sf.theory.waviness.onset_speed(flat):.6f} {sf.theory.waviness.onset_speed(flat.where({'F': 10.0})):.6f}"
    '0.440959 0.411653'
    """
    from scipy.special import ellipe, ellipkm1

    given = _numbers(scene)
    hill, limit = given["F"] / given["k"], _onset_square(*(given[s.name] for s in SYMBOLS if s.name in _CUBIC))
    if limit <= 0:
        return 0.0
    if hill == 0:
        return float(np.sqrt(limit))

    def excess(rest: float) -> float:  # rest = 1 - m = (W - h)/(W + h)
        return float(4 * hill / (1 - rest) * ellipe(1 - rest) / ellipkm1(rest) - limit)

    least = 1e-300
    rest = zero(excess, least, 1 - 1e-15) if excess(least) < 0 else least
    return float(np.pi / 2 * np.sqrt(4 * hill / (1 - rest)) / ellipkm1(rest))


def _of_weak_waves(formula: sp.Expr, scene: Scene | None = None) -> float:
    """Return the number, if the waves are weak."""
    given = _numbers(scene)
    speed = complex(formula.subs({s: given[s.name] for s in formula.free_symbols}))
    if speed.imag != 0.0 or speed.real <= 0.0:
        raise NotFound("no belt speed belongs to harmonic fast slip at the limit; see onset_speed, which needs none")
    return speed.real


@closed_form(_of_weak_waves)
def sinusoidal_onset_speed(scene: Scene | None = None, *, symbolic: bool = False) -> float | sp.Expr:
    r"""Return the same for waves so weak that the fast slip is harmonic, of the amplitude ``q = F/(k v_b)``.

    Parameters
    ----------
    scene : Scene
        `symfric.scenes.wavy_belt` with `symfric.laws.cubic`.
    symbolic : bool
        Return the formula in `SYMBOLS`.

    Returns
    -------
    float or Expr

    Raises
    ------
    NotFound
        If no speed belongs to the limit: the waves are not weak.
    SceneError
        If the scene or its law is another one.

    Notes
    -----
    ``v_b^2 + q^2/2 = v_b1^2``, Thomsen (55) with the excitation ``a = F/(k v_b)^2``, ``Omega = k v_b`` that the belt
    brings along: :math:`v_b^2 = (v_{b1}^2 + \sqrt{v_{b1}^4 - 2 h^2})/2` with h = F/k. Thomsen, section 5.4, calls both
    equivalent; they are for q far below v_b only, and an excitation of constant a Omega, which makes the slip reverse
    on slow belts, has no counterpart here.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.wavy_belt(v_b=0.3, F=10.0, k=100.0)
    >>> round(sf.theory.waviness.sinusoidal_onset_speed(scene), 6)
    0.404903
    """
    s = SYMBOLS
    square = _onset_square(s.beta, s.gamma2, s.mu_s, s.mu_m, s.v_m)
    return sp.sqrt((square + sp.sqrt(square**2 - 2 * (s.F / s.k) ** 2)) / 2)


@alone(SYMBOLIC)
def drag(scene: Scene, law: Law | None = None) -> float:
    r"""Return the mean force of a wavy belt on the mass, ``gamma2 <mu(w)> + 2 beta (<w> - v_b)``, dimensionless.

    Parameters
    ----------
    scene : Scene
        `symfric.scenes.wavy_belt`, with any law.
    law : Law, optional
        Taken instead of that of the scene.

    Returns
    -------
    float
        The mean position of the mass in steady sliding.

    Raises
    ------
    SceneError
        If the scene is another one or v_b is not positive.

    Notes
    -----
    The mean friction over the way, not over time: where the mass is slow it does not stay longer on its way. Without
    waves ``gamma2 mu(v_b)``.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.wavy_belt(v_b=0.45, F=5.0, k=100.0)
    >>> round(sf.theory.waviness.drag(scene), 6)
    0.25742
    """
    given = _numbers(scene, cubic=False)
    if not given["v_b"] > 0:
        raise SceneError(f"v_b is {given['v_b']:g}; the mass slides over the waves of a belt that moves, v_b > 0")
    w = slip_over_a_wave(given["v_b"], given["F"] / given["k"])
    values = scene.parameter_values()
    law = scene.contacts[0].law.where(values) if law is None else instance(law, Law, "law")
    return float(given["gamma2"] * np.mean(law(w)) + 2 * given["beta"] * (np.mean(w) - given["v_b"]))


@spelt
def slip_over_a_wave(v_b: float, hill: float, number: int = _NODES) -> np.ndarray:
    """Return the slip ``sqrt(2 (W - h cos(phi)))`` at evenly spaced phases of a wave.

    Parameters
    ----------
    v_b : float
        Mean slip in time, > 0.
    hill : float
        Height of the potential, h = F/k >= 0.
    number : int
        How many phases, in the middle of equal intervals.

    Returns
    -------
    ndarray, shape (number,)

    Notes
    -----
    W from ``v_b = (pi/2) sqrt(2 (W + h))/K(m)``, ``m = 2 h/(W + h)``; derivations/waviness.py.

    Examples
    --------
    >>> import symfric as sf
    >>> w = sf.theory.waviness.slip_over_a_wave(0.4, 0.05)
    >>> f"{1 / (1 / w).mean():.6f} {w.min():.4f} {w.max():.4f}"
    '0.400000 0.2873 0.5315'
    """
    from scipy.special import ellipkm1

    v_b, hill = positive(v_b, "v_b"), positive(hill, "hill", zero=True)
    phase = (np.arange(whole(number, "number")) + 0.5) * 2 * np.pi / number
    if hill == 0:
        return np.full(number, float(v_b))

    def gap(log_rest: float) -> float:
        rest = np.exp(log_rest)
        return float(np.pi / 2 * np.sqrt(4 * hill / -np.expm1(log_rest)) / ellipkm1(rest) - v_b)

    rest = np.exp(zero(gap, -690.0, -1e-15, xtol=1e-15))
    top = 2 * hill / (1 - rest)  # W + h
    return np.asarray(np.sqrt(2 * top * (rest + (1 - rest) * np.sin(phase / 2) ** 2)))


_CUBIC = ("beta", "gamma2", "mu_s", "mu_m", "v_m")


def _onset_square(beta: Any, gamma2: Any, mu_s: Any, mu_m: Any, v_m: Any) -> Any:
    """Return v_b1 squared, Thomsen (19)."""
    return v_m**2 * (1 - 4 * beta * v_m / (3 * gamma2 * (mu_s - mu_m)))


def _numbers(scene: Scene | None, cubic: bool = True) -> dict[str, float]:
    """Return the values of a wavy belt by name, with the parameters of its cubic law."""
    if not isinstance(scene, Scene):
        raise SceneError(
            f"{shortened(scene)} is no sf.Scene; the closed forms of waviness take sf.scenes.wavy_belt(...)"
        )
    model = scenes.wavy_belt(v_b=1.0, F=1.0, k=1.0)
    same = scene.system == model.system and len(scene.contacts) == 1
    if not same or (scene.contacts[0].slip, scene.contacts[0].normal) != (
        model.contacts[0].slip,
        model.contacts[0].normal,
    ):
        raise SceneError("the closed forms of waviness hold for sf.scenes.wavy_belt; this scene has other equations")
    values = scene.parameter_values()
    given = {s.name: float(v) for s, v in values.items()}
    if cubic:
        given |= dict(zip(("mu_s", "mu_m", "v_m"), cubic_parameters(scene.contacts[0].law.where(values)), strict=True))
    return given


if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
