"""Fit of a free decay: dry, viscous and quadratic damping from the envelope."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.identification.direct import Formula, fit_formula, noise_of
from symfric.identification.extremes import Extremes, extremes
from symfric.identification.fit import Fit
from symfric.identification.records import Channel, check_row, numbers
from symfric.identification.unknowns import read_bounds
from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.arguments import is_one_of, items
from symfric.model.scene import Scene
from symfric.model.symbols import shortened
from symfric.model.system import Contact, System
from symfric.spelling import spelt

DRY, VISCOUS, QUADRATIC = "delta", "zeta", "kappa"
TERMS = {"dry": DRY, "viscous": VISCOUS, "quadratic": QUADRATIC}
ROUGH = 0.3  # relative loss a swing beyond which the envelope is a poor description


def envelope(t: Any, start: Any, dry: Any, viscous: Any, quadratic: Any) -> tuple[np.ndarray, np.ndarray]:
    r"""Return the envelope of a free decay and its derivatives.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Time since the start.
    start : float
        Amplitude at t = 0.
    dry, viscous, quadratic : float
        a, b and c of :math:`A' = -(a + b A + c A^2)`.

    Returns
    -------
    A : ndarray, shape (n,)
    slopes : ndarray, shape (n, 4)
        Derivatives by start, a, b and c.

    Notes
    -----
    Riccati's equation, linear for y with ``c A = y'/y``. With ``w = b^2/4 - a c``, ``C = cosh(sqrt(w) t)`` and
    ``S = sinh(sqrt(w) t)/sqrt(w)``, which are real for every w,
    :math:`A = \bigl(A_0 (C - \tfrac b2 S) - a S\bigr)/\bigl(C + (\tfrac b2 + c A_0) S\bigr)`.
    """
    w = viscous**2 / 4 - dry * quadratic
    c, s, dc, ds = _even(w, t)
    half = viscous / 2
    top, bottom = start * (c - half * s) - dry * s, c + (half + quadratic * start) * s
    value = top / bottom
    by_w = (start * (dc - half * ds) - dry * ds - value * (dc + (half + quadratic * start) * ds)) / bottom
    by_start = (c - half * s - value * quadratic * s) / bottom
    by_dry = -s / bottom - quadratic * by_w
    by_viscous = -(start + value) * s / (2 * bottom) + half * by_w
    by_quadratic = -value * start * s / bottom - dry * by_w
    return value, np.stack([by_start, by_dry, by_viscous, by_quadratic], axis=-1)


def _even(w: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return ``cosh(sqrt(w) t)`` and ``sinh(sqrt(w) t)/sqrt(w)``, and their derivatives by w."""
    size = w * t**2
    small = np.abs(size) < 1e-4  # there the series is exact to rounding, and the difference below cancels
    root = np.sqrt(np.abs(w)) if w else 1.0
    c, s = (np.cosh(root * t), np.sinh(root * t) / root) if w > 0 else (np.cos(root * t), np.sin(root * t) / root)
    c = np.where(small, 1 + size / 2 + size**2 / 24, c)
    s = np.where(small, t * (1 + size / 6 + size**2 / 120), s)
    safe = w or 1.0
    ds = np.where(small, t**3 / 6 * (1 + size / 10 + size**2 / 280), (t * c - s) / (2 * safe))
    return c, s, t * s / 2, ds


@spelt
def fit_decay(t: Any, x: Any, terms: Sequence[str] = ("dry", "viscous", "quadratic"), *, sigma: Any = None) -> Fit:
    r"""Fit the damping of a free oscillation to the envelope of its decay.

    Parameters
    ----------
    t, x : array_like, shape (n,)
        Record of a displacement that swings freely until it rests, or a part of it.
    terms : sequence of {"dry", "viscous", "quadratic"}
        Kinds of damping.
    sigma : float, optional
        Standard deviation of the noise of a sample; estimated from the scatter around each extreme unless given.

    Returns
    -------
    Fit
        Values ``delta`` (dry friction over stiffness, a length), ``zeta`` (damping ratio), ``kappa`` (1/length), as far
        as they are among the terms, ``x0`` (amplitude at the first extreme) and ``offset`` of the sensor. The fitted
        record is that of the extremes.

    Raises
    ------
    SceneError
        If the record is bad, or a term unknown.
    NotFound
        If the record has too few swings above its noise.

    Notes
    -----
    For :math:`x'' + \omega^2 (x + \Delta\,\mathrm{sgn}\,x') + 2\zeta\omega x' + \kappa x'|x'| = 0` averaging over
    the phase gives :math:`A' = -(a + b A + c A^2)` with :math:`a = 2\Delta\omega/\pi`, :math:`b = \zeta\omega`,
    :math:`c = 4\kappa\omega/(3\pi)`, whose solution is closed (`envelope`). Alone, dry friction and viscous damping
    lose exactly that much from one extreme to the next; together the error is of second order in the loss per swing.
    `sf.identify` on the whole record has no such error; see ``fit.scene``.

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> scene = sf.scenes.coulomb_oscillator(0.02, horizon=80.0)
    >>> t = np.linspace(0.0, 80.0, 4001)
    >>> x = sf.simulate(scene)(t)[0] + 0.001 * np.random.default_rng(0).standard_normal(t.size)
    >>> fit = sf.fit_decay(t, x, ["dry"])
    >>> abs(fit.values["delta"] - 0.02) < 3 * fit.standard_errors["delta"]
    True
    """
    t, x = numbers(t, "the times"), numbers(x, "the values")
    check_row(t, x, "the record")
    terms = tuple(items(terms, "terms"))
    strange = [n for n in terms if not is_one_of(n, TERMS)]
    if strange or not terms or len(set(terms)) < len(terms):
        raise SceneError(f"terms is {shortened(terms)}; give some of {', '.join(map(repr, TERMS))}")
    noise = noise_of(sigma, x.size)
    swings = extremes(t, x, None if noise is None else float(np.mean(noise)))
    names = [TERMS[n] for n in terms]
    size = float(np.max(np.abs(swings.x)))
    bounds = {"x0": (0.3 * size, 3 * size), "offset": (-size, size)}
    most = {DRY: size, VISCOUS: 0.5, QUADRATIC: 2 / size}
    bounds |= {n: (-0.2 * most[n], most[n]) for n in names}
    unknowns = read_bounds(bounds)
    side = np.where((np.arange(swings.t.size) % 2 == 0) == (swings.x[0] > swings.x[1]), 1.0, -1.0)
    factor = {DRY: 2 * swings.omega / np.pi, VISCOUS: swings.omega, QUADRATIC: 4 * swings.omega / (3 * np.pi)}
    time = swings.t - swings.t[0]

    def evaluate(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        given = dict(zip(unknowns.names, values, strict=True))
        rates = [factor[n] * given.get(n, 0.0) for n in (DRY, VISCOUS, QUADRATIC)]
        with np.errstate(all="ignore"):
            size, slopes = envelope(time, given["x0"], *rates)
        columns = {"x0": side * slopes[:, 0], "offset": np.ones(side.size)}
        columns |= {n: side * factor[n] * slopes[:, 1 + k] for k, n in enumerate((DRY, VISCOUS, QUADRATIC))}
        return side * size + given["offset"], np.stack([columns[n] for n in unknowns.names], axis=1)

    first = np.array([abs(swings.x[0]), 0.0, *(0.02 * most[n] for n in names)])
    channel = Channel("", "extremes", sp.Symbol("x"), swings.t, swings.x)
    fit = fit_formula(Formula((channel,), unknowns, evaluate), swings.sigma, first)
    fit = replace(fit, scenes={"": _scene(fit, swings)})
    loss = 1 - abs(swings.x[2] - fit.values["offset"]) / abs(swings.x[0] - fit.values["offset"])
    rough = f"each swing loses {100 * loss:.0f} %, too much for an envelope; use sf.identify on fit.scene"
    return replace(fit, notes=(rough, *fit.notes)) if loss > ROUGH else fit


@alone(SYMBOLIC)
def _scene(fit: Fit, swings: Extremes) -> Scene:
    """Return the oscillator with the fitted values, at rest at the first extreme."""
    x, u = sp.symbols("x u", real=True)
    letters = {
        n: sp.Symbol(n, real=True) for n in (DRY, VISCOUS, QUADRATIC, "omega", "x0") if n in (*fit.values, "omega")
    }
    omega, zero = letters["omega"], sp.Integer(0)
    damping = 2 * letters.get(VISCOUS, zero) * omega * u + letters.get(QUADRATIC, zero) * u * sp.Abs(u)
    dry = fit.values.get(DRY, 0.0) > 0
    contacts = [Contact("friction", u, omega**2, laws.coulomb(letters[DRY]))] if dry else []
    numbers = {s: swings.omega if n == "omega" else fit.values[n] for n, s in letters.items() if n != DRY or dry}
    system = System([x], [u], [[1]], [-(omega**2) * x - damping])
    side = 1 if swings.x[0] > swings.x[1] else -1
    return Scene(system, contacts, numbers, {x: side * letters["x0"], u: 0.0}, float(swings.t[-1] - swings.t[0]))
