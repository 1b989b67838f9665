"""Symbols of the belt's closed forms, and their values in a ready scene."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import scenes
from symfric.model.laws import Law
from symfric.model.numeric import numeric
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, shortened
from symfric.theory.closed_form import P, R, closed_form


class Symbols(NamedTuple):
    """Symbols of the closed forms; the first five are those of `symfric.scenes.mass_on_belt`."""

    v_b: sp.Symbol
    beta: sp.Symbol
    gamma2: sp.Symbol
    a: sp.Symbol
    Omega: sp.Symbol
    mu_s: sp.Symbol
    mu_m: sp.Symbol
    v_m: sp.Symbol


#: Symbols of the closed forms: the values of `sf.scenes.mass_on_belt` and the coefficients of the cubic law.
SYMBOLS = Symbols(*sp.symbols("v_b beta gamma2 a Omega", real=True), *sp.symbols("mu_s mu_m v_m", positive=True))


@alone(SYMBOLIC)
def numbers(scene: Scene | None = None) -> Symbols:
    """Read the numbers of a mass-on-belt scene with the cubic law.

    Parameters
    ----------
    scene : Scene
        `symfric.scenes.mass_on_belt`, with `laws.cubic` or a law equal to it.

    Returns
    -------
    Symbols
        Of floats.

    Raises
    ------
    SceneError
        If the scene or its law is another one, or v_b is negative.
    """
    if scene is None:
        raise SceneError("no scene to take numbers from; give one, or ask for the formula with symbolic=True")
    if not isinstance(scene, Scene):
        raise SceneError(f"{shortened(scene)} is no sf.Scene; the belt's closed forms take sf.scenes.mass_on_belt(...)")
    model = scenes.mass_on_belt(v_b=1.0)
    (belt,) = model.contacts
    same = scene.system == model.system and len(scene.contacts) == 1
    if not same or (scene.contacts[0].slip, scene.contacts[0].normal, scene.contacts[0].profile) != (
        belt.slip,
        belt.normal,
        belt.profile,
    ):
        raise SceneError(
            "the belt's closed forms hold for sf.scenes.mass_on_belt; this scene has other equations (sf.stability, "
            "sf.hopf and sf.average take any)"
        )
    values = scene.parameter_values()
    given = {s.name: v for s, v in values.items()}
    if given["v_b"] < 0:
        raise SceneError(f"v_b is {given['v_b']:g}; the closed forms take belt speeds >= 0, so mirror the scene")
    v_b, beta, gamma2, a, Omega = (given[s.name] for s in SYMBOLS[:5])
    return Symbols(v_b, beta, gamma2, a, Omega, *cubic_parameters(scene.contacts[0].law.where(values)))


@alone(SYMBOLIC)
def cubic_parameters(law: Law) -> tuple[float, float, float]:
    """Return mu_s, mu_m and v_m of a law in numbers that equals `laws.cubic`.

    Raises
    ------
    SceneError
        If it does not.
    """
    other = f"the law {law.kinetic} is not laws.cubic, and the belt's closed forms hold for that law only"
    if law.breaks or not law.kinetic.is_polynomial(SPEED):
        raise SceneError(f"{other}; sf.hopf and sf.average take any law")
    c = {n: float(value) for (n,), value in sp.Poly(law.kinetic, SPEED).terms()}
    if any(value != 0 for n, value in c.items() if n not in (0, 1, 3)):
        raise SceneError(f"{other}; sf.hopf and sf.average take any law")
    c0, c1, c3 = (c.get(n, 0.0) for n in (0, 1, 3))
    if c1 == 0 == c3:
        v_m = 1.0  # arbitrary: friction does not depend on speed
    elif c1 * c3 < 0:
        v_m = float(np.sqrt(-c1 / (3 * c3)))
    else:
        raise SceneError(f"{other}: it has no extreme at a positive speed")
    drop = -2 * c1 * v_m / 3
    if abs(float(law.stick) - c0) > 1e-12 * abs(c0):
        raise SceneError(
            f"the law sticks up to {float(law.stick):g} and starts to slip with {c0:g}; the closed forms take one mu_s"
        )
    return c0, c0 - drop, v_m


@alone(SYMBOLIC)
def value(formula: sp.Expr, given: Symbols, extra: tuple[tuple[sp.Symbol, float], ...] = ()) -> float:
    """Evaluate a formula in `SYMBOLS` for numbers."""
    letters = (*SYMBOLS, *(s for s, _ in extra))
    (result,) = numeric(letters, (formula,))(*given, *(v for _, v in extra))
    return float(result)


def on_belt(read: Callable[..., Symbols] = numbers) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorate a function that returns a formula in `SYMBOLS`, or several, so that a scene gives their numbers.

    Parameters
    ----------
    read : callable
        Takes the arguments of the function but `symbolic`; returns the scene's numbers, or raises where the formulas
        do not hold.
    """

    def evaluate(formula: Any, *arguments: Any, **named: Any) -> Any:
        given = read(*arguments, **named)
        return tuple(value(f, given) for f in formula) if isinstance(formula, tuple) else value(formula, given)

    return closed_form(evaluate)
