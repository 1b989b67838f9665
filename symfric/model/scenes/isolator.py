"""The ready scene of a mass on rolling bearings with a damper, shaken by the ground."""

import math
from collections.abc import Sequence
from typing import Protocol, TypeAlias

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.arguments import whole
from symfric.model.laws import Law
from symfric.model.outputs import At, Max, Output, friction_force
from symfric.model.scene import Scene
from symfric.model.scenes.arguments import open_values
from symfric.model.symbols import Key, finite, shortened
from symfric.model.system import Contact, Signal, System
from symfric.spelling import spelt

# mu, (mu0, R), or (edges, values)
FloorProfile: TypeAlias = float | Sequence[float] | Sequence[Sequence[float]] | Sequence[np.ndarray] | np.ndarray
_U, _W = sp.symbols("u w", real=True)
_STRETCH = sp.Symbol("stretch", positive=True)
_RUN_OUT = 20.0  # horizon beyond the end of the record in s, in which the mass comes to rest


class Record(Protocol):
    """A sampled motion of the ground, such as `Signal` and `symfric.motions.Motion`."""

    @property
    def samples(self) -> np.ndarray:
        """Accelerations."""

    @property
    def dt(self) -> float:
        """Sampling interval."""


@alone(SYMBOLIC)
def rolling_isolator(
    *,
    C: float,
    m: float,
    motion: Record,
    profile: FloorProfile,
    g: float = 9.81,
    alpha: float = 1.0,
    law: Law | None = None,
    rest_speed: float = 1e-5,
    horizon: float | None = None,
) -> Scene:
    r"""Mass on a rough floor that moves with the ground: :math:`m(w' + a_g) = -C w - \mathrm{sgn}(w)\,\mu(u)\,m g`.

    Parameters
    ----------
    C : float
        Damping constant between mass and ground, N s/m; N (s/m)^alpha.
    m : float
        Mass, kg.
    motion : Signal or Motion
        Acceleration of the ground, m/s^2, linear between its samples.
    profile : float, pair of floats, or (edges, values)
        Coefficient of rolling friction over the displacement u: a number mu; (mu0, R) for ``mu0 + R |u|``; or arrays of
        n + 1 increasing edges of cells, in m, with n values (constant in each cell) or n + 1 (linear between the edges,
        constant beyond the outermost).
    g : float
        Gravity, m/s^2.
    alpha : float
        Exponent of the damper, whose force is ``C |w|^alpha``, > 0; 1 is a linear one.
    law : Law, optional
        Factor of the coefficient over the sliding speed, such as ``sf.laws.stribeck(1, .6, .1)``; constant unless
        given. Its symbols are values to be given with `where`.
    rest_speed : float
        Speed, m/s, about which a damper turns linear whose exponent is no odd number, ``C w (w^2 +
        rest_speed^2)^((alpha - 1)/2)``: its force has no series at rest. Displacements change by less than 1e-4 of
        their size with the one given.
    horizon : float, optional
        s; unless given, 20 s longer than the record, so that the mass comes to rest.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        If a number is missing or out of range.

    Notes
    -----
    u and w are displacement and velocity of the mass relative to the ground; a roller moves half of u. ``amplitude``, 1
    unless changed by ``where``, multiplies the motion, ``stretch`` the positions of the cells where that changes the
    floor (an edge at u = 0 stays there). Outputs: `peak_acceleration` of the mass in space, `peak_velocity` and
    `peak_displacement` relative to the ground, `residual` displacement at the horizon and `residual_end_of_record`,
    which a horizon before the end of the record leaves out. From the study of scaled rolling isolation, figure 1, with
    sticking as the set-valued law has it; its own scheme tests w == 0 at the ends of fixed steps. The nonlinear damper
    and friction that depends on speed are beyond the source, which leaves the latter to further research;
    `symfric.theory.scaling.isolator_model` scales both.

    Examples
    --------
    >>> import symfric as sf
    >>> motion = sf.motions.sine_burst(3.0, 1.5, cycles=6)
    >>> for alpha in (1.0, 2.0):
    ...     run = sf.simulate(sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=motion, profile=0.02, alpha=alpha))
    ...     print(f"{1e3 * run['peak_displacement']:.2f} mm")
    36.49 mm
    37.73 mm
    """
    alpha = finite(alpha, "alpha")
    if not alpha > 0:
        raise SceneError(f"alpha is {alpha:g}; the exponent of the damper must be positive")
    signal = as_signal(motion)
    values: dict[Key, float | None] = {"C": finite(C, "C"), "m": finite(m, "m"), "g": finite(g, "g")}
    C_, m_, g_, a_g, amplitude = sp.symbols("C m g a_g amplitude", real=True)
    values["amplitude"] = 1.0
    coefficient, more = _profile(profile)
    friction = friction_force("floor")
    law = laws.coulomb(1) if law is None else law
    values |= more
    values |= open_values(law)
    floor = Contact("floor", slip=_W, normal=m_ * g_, law=law, profile=coefficient)
    damping, more = _damper(C_, alpha, rest_speed)
    values |= more
    horizon = signal.t_end + _RUN_OUT if horizon is None else finite(horizon, "horizon")
    outputs: dict[str, Output] = {
        "peak_acceleration": Max(sp.Abs((friction - damping) / m_)),
        "peak_velocity": Max(sp.Abs(_W)),
        "peak_displacement": Max(sp.Abs(_U)),
        "residual": At(_U),
    }
    if horizon >= signal.t_end:
        outputs["residual_end_of_record"] = At(_U, signal.t_end)
    return Scene(
        system=System(q=[_U], u=[_W], mass=[[m_]], force=[-damping - m_ * amplitude * a_g]),
        contacts=[floor],
        values=values,
        inputs={a_g: signal},
        initial={_U: 0.0, _W: 0.0},
        horizon=horizon,
        outputs=outputs,
    )


def _damper(C: sp.Symbol, alpha: float, rest_speed: float) -> tuple[sp.Expr, dict[Key, float | None]]:
    """Return the force of the damper and the values of its own symbols."""
    if alpha % 2 == 1:
        return C * _W ** int(alpha), {}
    if not finite(rest_speed, "rest_speed") > 0:
        raise SceneError(f"rest_speed is {rest_speed:g}; the damper is linear below it, so it must be positive")
    low = sp.Symbol("rest_speed", real=True)
    return C * _W * (_W**2 + low**2) ** sp.Float((alpha - 1) / 2), {"rest_speed": rest_speed}


def as_signal(motion: object) -> Signal:
    """Return a ground motion as a sampled input."""
    if isinstance(motion, Signal):
        return motion
    samples, dt = getattr(motion, "samples", None), getattr(motion, "dt", None)
    if samples is None or dt is None:
        raise SceneError(f"motion is {shortened(motion)}; give a sf.Signal or what sf.motions reads")
    return Signal(samples, dt, unit="m/s^2")


def _profile(profile: FloorProfile) -> tuple[sp.Expr, dict[Key, float | None]]:
    """Return the coefficient of friction over u and the values of its symbols."""
    if isinstance(profile, str):
        raise SceneError(f"profile is {profile!r}; give a number mu, a pair (mu0, R), or arrays (edges, values)")
    if not isinstance(profile, Sequence | np.ndarray):
        return sp.Symbol("mu", real=True), {"mu": _coefficient(profile, "mu")}
    if len(profile) != 2:
        raise SceneError(f"profile has {len(profile)} parts; give mu, (mu0, R), or (edges, values)")
    if all(np.ndim(part) == 0 for part in profile):
        values: dict[Key, float | None] = {"mu0": _coefficient(profile[0], "mu0"), "R": finite(profile[1], "R")}
        return sp.Symbol("mu0", real=True) + sp.Symbol("R", real=True) * sp.Abs(_U), values
    edges, numbers = (np.asarray(part, dtype=float) for part in profile)
    _check_cells(edges, numbers)
    if numbers.size == edges.size - 1:
        lines = [sp.Float(v) for v in numbers]
        return _stretched(lines, edges[1:-1].tolist())
    slopes = np.diff(numbers) / np.diff(edges)
    lines = [
        sp.Float(v) + sp.Float(k) * (_U / _STRETCH - sp.Float(e))
        for v, k, e in zip(numbers, slopes, edges, strict=False)
    ]
    return _stretched([sp.Float(numbers[0]), *lines, sp.Float(numbers[-1])], edges.tolist())


def _stretched(lines: list[sp.Expr], edges: list[float]) -> tuple[sp.Expr, dict[Key, float | None]]:
    """Return a profile and the value of its stretch parameter, which one without edges or with one at u = 0 lacks.

    Between two lines that are the same there is no edge: SymPy would join their conditions to one that is no interval.
    """
    pieces = [(a, _U < _STRETCH * edge) for a, b, edge in zip(lines, lines[1:], edges, strict=False) if a != b]
    profile = sp.Piecewise(*pieces, (lines[-1], True))
    return profile, {"stretch": 1.0} if profile.has(_STRETCH) else {}


@spelt
def patched_floor(
    length: float, n: int, mean: float, deviation: float, spread: float | None = None, *, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return edges and random coefficients of n equal cells about u = 0, with exactly the given mean and deviation.

    Parameters
    ----------
    length : float
        Of the floor, m.
    n : int
        At least two.
    mean, deviation : float
        Mean and standard deviation of the coefficients, which they have exactly.
    spread : float, optional
        Largest distance of a coefficient from the mean, to rounding. They are drawn from a symmetric beta distribution
        with this range and deviation; the uniform one, ``sqrt(3) deviation``, unless given.
    seed : int

    Returns
    -------
    edges : ndarray, shape (n + 1,)
    values : ndarray, shape (n,)

    Raises
    ------
    SceneError
        If a number is out of range, or a coefficient comes out negative.

    Notes
    -----
    The study of scaled rolling isolation gives range, mean and deviation of its cases 2 and 3, and neither their cells
    nor how they were drawn: a beta distribution is a choice. Moving and stretching a draw to its mean and deviation may
    carry it out of the range; it is cut off there and stretched again, until it stays inside.

    Examples
    --------
    >>> import symfric as sf
    >>> edges, values = sf.patched_floor(1.0, 4, 0.01, 0.002, seed=1)
    >>> edges.round(6)
    array([-0.5 , -0.25,  0.  ,  0.25,  0.5 ])
    >>> round(float(values.mean()), 6)
    0.01
    """
    length, mean, deviation = finite(length, "length"), finite(mean, "mean"), finite(deviation, "deviation")
    spread = math.sqrt(3) * deviation if spread is None else finite(spread, "spread")
    n, seed = whole(n, "n", 2), whole(seed, "seed", 0)
    if not (length > 0 and deviation > 0):
        raise SceneError("a patched floor needs a positive length and a positive deviation")
    if spread <= deviation:
        raise SceneError(f"spread is {spread:g}; nothing within it has the deviation {deviation:g}")
    shape = 0.5 * ((spread / deviation) ** 2 - 1.0)
    drawn = np.random.default_rng(seed).beta(shape, shape, n)
    stretched = _stretched_within(drawn, spread / deviation)
    if stretched is None:
        raise SceneError(f"{n} cells drawn with seed {seed} do not get the deviation {deviation:g} within {spread:g}")
    values = mean + deviation * stretched
    if np.any(values < 0):
        raise SceneError(f"a coefficient is {values.min():.3g}; take a smaller deviation or spread")
    return length * np.linspace(-0.5, 0.5, n + 1), values


def _stretched_within(drawn: np.ndarray, reach: float) -> np.ndarray | None:
    """Return numbers with mean 0, deviation 1 and nothing beyond +-reach, near those drawn; None if that fails."""
    stretched: np.ndarray = drawn
    for _ in range(1000):
        deviation = stretched.std()
        if deviation == 0:
            return None
        stretched = (stretched - stretched.mean()) / deviation
        if np.max(np.abs(stretched)) <= reach * (1 + 1e-12):
            return stretched
        stretched = np.clip(stretched, -reach, reach)
    return None


def _coefficient(value: object, name: str) -> float:
    number = finite(value, name)
    if number < 0:
        raise SceneError(f"{name} is {number:g}; a coefficient of friction must not be negative")
    return number


def _check_cells(edges: np.ndarray, values: np.ndarray) -> None:
    if edges.ndim != 1 or values.ndim != 1 or edges.size < 2 or values.size not in (edges.size, edges.size - 1):
        raise SceneError(
            f"profile has {edges.size} edges and {values.size} values; give n + 1 edges with n values (constant "
            "cells) or n + 1 values (straight lines)"
        )
    if not (np.all(np.isfinite(edges)) and np.all(np.isfinite(values))):
        raise SceneError("profile holds a number that is not finite")
    if np.any(np.diff(edges) <= 0):
        raise SceneError(f"the edges of the profile must increase; edge {int(np.argmin(np.diff(edges))) + 1} does not")
    if np.any(values < 0):
        raise SceneError(f"value {int(np.argmin(values))} of the profile is negative; friction must not be")
