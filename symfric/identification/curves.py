"""Fit of the steady friction curve to points of speed and friction."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from symfric.errors import SceneError
from symfric.identification.direct import Formula, fit_formula, noise_of, symbols_called, with_law
from symfric.identification.fit import Fit
from symfric.identification.records import Channel, numbers
from symfric.identification.unknowns import read_bounds
from symfric.locks import SYMBOLIC, alone
from symfric.model.laws import Law
from symfric.model.numeric import numeric
from symfric.model.symbols import SPEED, Key, positive, shortened
from symfric.spelling import spelt

KINETIC, STATIC = "friction", "static friction"


@spelt
def fit_curve(
    law: Law,
    speed: Any,
    friction: Any,
    parameters: Mapping[Key, tuple[float, float]],
    *,
    normal: float = 1.0,
    static: Any = None,
    sigma: Any = None,
    seed: int = 0,
) -> Fit:
    """Fit a friction law to steady sliding: points of speed and friction.

    Parameters
    ----------
    law : Law
        With symbols in place of what is unknown, such as ``sf.laws.stribeck(mu_s, mu_k, v_s)``. With memory, its steady
        coefficient is fitted.
    speed, friction : array_like, shape (n,)
        Sliding velocities, of either sign but not zero, and the friction measured, positive along the velocity.
    parameters : mapping of name to (low, high)
        The symbols of the law with their bounds.
    normal : float
        Normal load, so that `friction` is a force; 1 for coefficients.
    static : float or array_like, optional
        Friction measured at breaking away, which the law's static coefficient has to meet.
    sigma : float or array_like, shape (n,), optional
        Standard deviation of the noise, of breaking away too if it is a number; estimated unless given.
    seed : int
        Of the starts.

    Returns
    -------
    Fit
        ``fit.law`` is the law with the fitted values.

    Raises
    ------
    SceneError
        If the law has other symbols, a point is bad, or there are fewer points than unknowns.
    NotFound
        If the law has no finite value between the bounds.

    Notes
    -----
    Least squares of ``friction = normal sign(v) mu(|v|)``, with exact derivatives; standard errors as in `identify`.

    Examples
    --------
    >>> import numpy as np
    >>> import sympy as sp
    >>> import symfric as sf
    >>> mu_s, mu_k, v_s = sp.symbols("mu_s mu_k v_s", positive=True)
    >>> v = np.linspace(0.01, 1.0, 30)
    >>> measured = 0.25 + 0.15 * np.exp(-v / 0.1)
    >>> bounds = {"mu_s": (0.1, 1.0), "mu_k": (0.1, 1.0), "v_s": (0.01, 1.0)}
    >>> fit = sf.fit_curve(sf.laws.stribeck(mu_s, mu_k, v_s), v, measured, bounds)
    >>> {n: round(x, 8) for n, x in fit.values.items()}
    {'mu_s': 0.4, 'mu_k': 0.25, 'v_s': 0.1}
    """
    if not isinstance(law, Law):
        raise SceneError(f"{shortened(law)} is no friction law; give one of sf.laws with symbols for what is unknown")
    load = positive(normal, "normal")
    v, y = _points(speed, friction)
    held = np.zeros(0) if static is None else numbers(np.atleast_1d(static), "static")
    unknowns = read_bounds(parameters)
    evaluate = _formula(law, unknowns.names, v, held.size, load)
    order = np.argsort(v, kind="stable")
    noise = noise_of(sigma, y.size) if np.ndim(sigma) else noise_of(sigma, y.size + held.size)
    if noise is not None and np.ndim(sigma) and held.size:
        noise = np.concatenate([noise, np.full(held.size, np.mean(noise))])
    places = np.concatenate([order, y.size + np.arange(held.size)])
    channels = [Channel("", KINETIC, law.kinetic, v[order], y[order], over="speed")]
    if held.size:
        channels.append(Channel("", STATIC, law.stick, np.arange(held.size, dtype=float), held, over="trial"))

    def sorted_(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        y, slopes = evaluate(values)
        return y[places], slopes[places]

    fit = fit_formula(Formula(tuple(channels), unknowns, sorted_), None if noise is None else noise[places], None, seed)
    return with_law(fit, law)


def _points(speed: Any, friction: Any) -> tuple[np.ndarray, np.ndarray]:
    v, y = numbers(speed, "speed"), numbers(friction, "friction")
    if v.size != y.size:
        raise SceneError(f"there are {v.size} speeds and {y.size} values of friction; give one for each")
    if not v.size:
        raise SceneError("there are no points; measure at several speeds")
    for row, name in ((v, "speed"), (y, "friction")):
        bad = np.flatnonzero(~np.isfinite(row))
        if bad.size:
            raise SceneError(f"{name}[{bad[0]}] is {row[bad[0]]}; leave out points that are not finite")
    rest = np.flatnonzero(v == 0)
    if rest.size:
        raise SceneError(f"speed[{rest[0]}] is 0, where friction is whatever holds; give break-away values as static")
    if np.ptp(v) == 0:
        raise SceneError(f"all points have the speed {v[0]:g}; a curve needs several speeds")
    return v, y


@alone(SYMBOLIC)
def _formula(
    law: Law, names: tuple[str, ...], v: np.ndarray, held: int, load: float
) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Return the function of the values that gives friction at the speeds, and when breaking away, with derivatives."""
    symbols = symbols_called(names, (law.kinetic.free_symbols | law.stick.free_symbols) - {SPEED})
    parts = [numeric((SPEED, *symbols), [e, *(e.diff(s) for s in symbols)]) for e in (law.kinetic, law.stick)]
    size, sign = np.abs(v), np.sign(v)

    def evaluate(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        given = [np.full(size.size, p) for p in values]
        slides = [load * sign * np.broadcast_to(e, size.shape) for e in parts[0](size, *given)]
        breaks = [load * np.broadcast_to(e, size.shape)[:1] for e in parts[1](size[:1], *(g[:1] for g in given))]
        rows = [np.concatenate([a, np.repeat(b, held)]) for a, b in zip(slides, breaks, strict=True)]
        return rows[0], np.stack(rows[1:], axis=1)

    return evaluate
