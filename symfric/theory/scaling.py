"""Similarity of shaking-table models of a rolling isolator: scale factors, and responses converted to full scale."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import scenes
from symfric.model.arguments import flag, instance, is_one_of
from symfric.model.laws import Law
from symfric.model.public_names import names_of
from symfric.model.results import Result
from symfric.model.scene import Scene
from symfric.model.scenes.isolator import as_signal
from symfric.model.symbols import SPEED, finite, numbers_of, pair, positive, shortened
from symfric.model.system import Signal
from symfric.spelling import spelt

__all__ = [
    "FACTORS",
    "SYMBOLS",
    "Factors",
    "ScalingSymbols",
    "TableModel",
    "factors",
    "for_table",
    "isolator_model",
    "returned_ratio",
]


class ScalingSymbols(NamedTuple):
    """L: length of the prototype over that of the model; D: density of the model over that of the prototype.

    Attributes
    ----------
    L, D : Symbol
        Scale of length, scale of density.

    Examples
    --------
    >>> import symfric as sf
    >>> sf.theory.scaling.SYMBOLS.L
    L
    """

    L: sp.Symbol
    D: sp.Symbol


#: Symbols of the scaling laws: scale of length L, scale of density D.
SYMBOLS = ScalingSymbols(*sp.symbols("L D", positive=True))


@dataclass(frozen=True, repr=False)
class Factors(Result):
    """Model over prototype for each quantity; the rows of tables 1 and 2, floats or formulas in `SYMBOLS`.

    Attributes
    ----------
    length, friction_increment, elastic_modulus, stress, density, mass, force, damping, time, velocity, acceleration
        damping is that of the viscous damping constant, friction_increment that of friction coefficient per length.
    gravity_1, gravity_2
        Gravity as similarity demands it, and as it is on a shaking table.

    Examples
    --------
    >>> import symfric as sf
    >>> model = sf.theory.scaling.factors(L=10.0)
    >>> round(model.time, 6)
    0.1
    >>> "time" in model.to_dict()
    True
    """

    length: float | sp.Expr
    friction_increment: float | sp.Expr
    elastic_modulus: float | sp.Expr
    stress: float | sp.Expr
    density: float | sp.Expr
    mass: float | sp.Expr
    force: float | sp.Expr
    damping: float | sp.Expr
    time: float | sp.Expr
    velocity: float | sp.Expr
    acceleration: float | sp.Expr
    gravity_1: float | sp.Expr
    gravity_2: float | sp.Expr

    @property
    def friction_distortion(self) -> float | sp.Expr:
        """Apparent over true coefficient of friction of a model under unscaled gravity."""
        return self.gravity_2 / self.gravity_1

    def damper(self, alpha: float = 1.0) -> float | sp.Expr:
        """Return the factor of C of a damper with the force ``C |w|^alpha``: ``D^(alpha/2)/L^2``.

        Parameters
        ----------
        alpha : float
            Its exponent, > 0; 1 gives `damping`.

        Returns
        -------
        float or Expr

        Notes
        -----
        Its force scales by 1/L^2, the speed by D^(-1/2). Beyond the source; derivations/rolling_isolation/factors.py.

        Examples
        --------
        >>> import symfric as sf
        >>> sf.theory.scaling.factors(4, D=4.0).damper(0.5)
        0.08838834764831843
        """
        return self.force / self.velocity**alpha

    def __repr__(self) -> str:
        return f"Factors(length={self.length}, density={self.density}, acceleration={self.acceleration})"


_L, _D = SYMBOLS
_ONE = sp.Integer(1)
#: The scaling laws as formulas in `SYMBOLS`.
FACTORS = Factors(
    length=1 / _L,
    friction_increment=_L,
    elastic_modulus=_ONE,
    stress=_ONE,
    density=_D,
    mass=_D / _L**3,
    force=1 / _L**2,
    damping=sp.sqrt(_D) / _L**2,
    time=sp.sqrt(_D) / _L,
    velocity=1 / sp.sqrt(_D),
    acceleration=_L / _D,
    gravity_1=_L / _D,
    gravity_2=_ONE,
)


@alone(SYMBOLIC)
def factors(
    L: float | None = None, D: float | None = None, *, mass: float | None = None, symbolic: bool = False
) -> Factors:
    """Return the scale factors of a model 1 : L made of the prototype's material.

    Parameters
    ----------
    L : float
        Length of the prototype over that of the model, > 0.
    D : float, optional
        Density of the model over that of the prototype; 1 unless given, which is table 1.
    mass : float, optional
        Mass of the model over that of the prototype, in place of D: ``D = mass L^3``. Table 2 has 0.008163.
    symbolic : bool
        Return the formulas in `SYMBOLS`.

    Returns
    -------
    Factors

    Raises
    ------
    SceneError
        If L is missing, D and mass are both given, or one of them is not positive.

    Notes
    -----
    Dimensional analysis with the elastic modulus unchanged: ``mass D/L^3``, ``force 1/L^2``, ``damping sqrt(D)/L^2``,
    ``time sqrt(D)/L``, ``velocity 1/sqrt(D)``, ``acceleration L/D``; tables 1 and 2 of the rolling-friction source,
    derivations/rolling_isolation/factors.py.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.scaling.factors(L=10.0).acceleration, 6)
    10.0
    """
    if flag(symbolic, "symbolic"):
        return FACTORS
    if L is None:
        raise SceneError("no L; give the length of the prototype over that of the model")
    if D is not None and mass is not None:
        raise SceneError("D and mass are both given; mass is D/L^3, so give one of them")
    L = positive(L, "L")
    D = positive(1.0 if D is None else D, "D") if mass is None else positive(mass, "mass") * L**3
    values = {name: float(formula.subs({_L: L, _D: D})) for name, formula in FACTORS.to_dict().items()}
    return Factors(**values)


class TableModel(NamedTuple):
    """A model for a shaking table, under the gravity that there is.

    Attributes
    ----------
    L, D : float
        Length of the prototype over that of the model; density of the model over that of the prototype.
    mass : float
        Of the model, kg.
    extra_mass : float
        Of it, what must be added to a model of the prototype's material, kg; negative if it must be lighter.
    friction_distortion : float
        Apparent over true coefficient of friction; 1 if gravity is as similarity demands it. The model's coefficient
        over this one makes up for it.

    Examples
    --------
    >>> import symfric as sf
    >>> model = sf.theory.scaling.for_table(mass=3e5, load=2000.0, L=10.0)
    >>> round(model.D, 6)
    6.666667
    """

    L: float
    D: float
    mass: float
    extra_mass: float
    friction_distortion: float


@alone(SYMBOLIC)
def for_table(mass: float, load: float, L: float | None = None) -> TableModel:
    """Choose the density of a model, by masses added to it, for the load that a shaking table carries.

    Parameters
    ----------
    mass : float
        Of the prototype, kg.
    load : float
        Largest mass of a model on the table, kg.
    L : float, optional
        Length of the prototype over that of the model, >= 1; unless given, the largest model that needs no other
        gravity.

    Returns
    -------
    TableModel
        With ``D = L``, where accelerations scale by 1 and gravity is that of the model, if the table carries it; else
        with as much mass as it carries.

    Raises
    ------
    SceneError
        If an argument is out of range.

    Notes
    -----
    The acceleration scales by L/D, the mass by ``D/L^3``: with D = L by ``1/L^2``, so that ``L = sqrt(mass/load)`` is
    the largest model without distorted gravity. The source's table 2 keeps the mass at 0.008163 of the prototype's,
    which balances at L = 11.068; its conclusion (1) proposes to adjust the density so. Proved in
    derivations/rolling_isolation/factors.py.

    Examples
    --------
    >>> import symfric as sf
    >>> model = sf.theory.scaling.for_table(mass=3e5, load=0.008163 * 3e5)
    >>> f"1:{model.L:.4f}, D = {model.D:.4f}, {model.extra_mass:.0f} of {model.mass:.0f} kg added"
    '1:11.0682, D = 11.0682, 2228 of 2449 kg added'
    >>> f"{sf.theory.scaling.for_table(mass=3e5, load=2449, L=7).friction_distortion:.3f}"
    '0.400'
    """
    mass, load = positive(mass, "mass"), positive(load, "load")
    L = max(1.0, float(np.sqrt(mass / load))) if L is None else positive(L, "L")
    if L < 1:
        raise SceneError(f"L is {L:g}; a model is not larger than its prototype, so give L >= 1")
    D = min(L, load * L**3 / mass)
    own = mass / L**3
    return TableModel(L, D, D * own, (D - 1) * own, D / L)


@alone(SYMBOLIC)
def isolator_model(
    factors: Factors,
    *,
    C: float,
    m: float,
    motion: Any,
    profile: Any,
    alpha: float = 1.0,
    law: Law | None = None,
    rest_speed: float = 1e-5,
    g: float = 9.81,
    gravity: str = "scaled",
) -> Scene:
    """Return the model of a rolling isolator: the ready scene with everything scaled.

    Parameters
    ----------
    factors : Factors
        From `factors`.
    C, m, motion, profile, alpha, law, rest_speed, g
        The prototype's, as in `symfric.scenes.rolling_isolator`.
    gravity : {"scaled", "table"}
        Gravity as similarity demands it, or as it is on a shaking table.

    Returns
    -------
    Scene
        Of `symfric.scenes.rolling_isolator`.

    Raises
    ------
    SceneError
        If an argument is wrong.

    Notes
    -----
    The damper's constant scales by ``D^(alpha/2)/L^2``, the speeds of a law by ``D^(-1/2)``, the record by the factors
    of acceleration and time, a profile by its positions. With scaled gravity every response is then that of the
    prototype times its factor: the source's solution where friction depends on the speed, which it leaves open.

    Examples
    --------
    >>> import symfric as sf
    >>> scaling, motion = sf.theory.scaling, sf.motions.sine_burst(3.0, 1.5, cycles=6)
    >>> prototype = {"C": 1e5, "m": 3e5, "motion": motion, "profile": 0.02, "alpha": 1.5}
    >>> prototype["law"] = sf.laws.stribeck(1.0, 0.6, 0.1)
    >>> peaks = [
    ...     sf.simulate(scaling.isolator_model(by, **prototype))["peak_displacement"] / by.length
    ...     for by in (scaling.factors(1), scaling.factors(7, D=2.8))
    ... ]
    >>> f"{peaks[1] / peaks[0]:.9f}"
    '1.000000000'
    """
    if not is_one_of(gravity, ("scaled", "table")):
        raise SceneError(f"gravity is {shortened(gravity)}; it is 'scaled' or that of a 'table'")
    f = instance(factors, Factors, "factors")
    C, m, alpha, g = finite(C, "C"), finite(m, "m"), finite(alpha, "alpha"), finite(g, "g")
    rest_speed = finite(rest_speed, "rest_speed")
    if law is not None:
        if instance(law, Law, "law").memory is not None:
            raise SceneError("the law has memory, whose displacements are not scaled here; scale its parameters")
        breaks, steep = (tuple(f.velocity * e for e in speeds) for speeds in (law.breaks, law.steep))
        law = replace(law, kinetic=law.kinetic.subs(SPEED, SPEED / f.velocity), breaks=breaks, steep=steep)
    record = as_signal(motion)
    return scenes.rolling_isolator(
        C=C * f.damper(alpha),
        m=m * f.mass,
        motion=Signal(record.samples * f.acceleration, record.dt * f.time, record.t0 * f.time, hold=record.hold),
        profile=_scaled_profile(profile, f),
        g=g * (f.gravity_1 if gravity == "scaled" else f.gravity_2),
        alpha=alpha,
        law=law,
        rest_speed=rest_speed * f.velocity,
        horizon=(record.t_end + 20.0) * f.time,
    )


def _scaled_profile(profile: Any, f: Factors) -> Any:
    """Return a profile of friction with its positions scaled."""
    if not isinstance(profile, Sequence | np.ndarray):
        return profile
    first, second = pair(profile, "profile")
    if np.ndim(first) == 0:
        return first, second * f.friction_increment
    return np.asarray(first, dtype=float) * f.length, second


@spelt
def returned_ratio(model: Any, prototype: Any, factor: Any) -> Any:
    """Return the response of a model, converted to full scale, over that of the prototype.

    Parameters
    ----------
    model, prototype : float, array_like or Expr
        Responses of the same kind; arrays broadcast.
    factor : float or Expr
        Scale factor of that kind, model over prototype: a field of `Factors`.

    Returns
    -------
    float, ndarray or Expr
        1 where the model says what the prototype does; infinite or not a number where the prototype's response is 0.

    Notes
    -----
    Equation (1) of the rolling-friction source.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.theory.scaling.returned_ratio(0.02, 0.25, 0.1), 6)
    0.8
    """
    given = {"model": model, "prototype": prototype, "factor": factor}
    exact = (sp.Expr, Real) if any(isinstance(v, sp.Expr) for v in given.values()) else ()
    numbers = {name: v if isinstance(v, exact) else numbers_of(v, name) for name, v in given.items()}
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = numbers["model"] / (numbers["factor"] * numbers["prototype"])
    return float(ratio) if isinstance(ratio, np.floating) else ratio


if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
