"""Similarity of shaking-table models of a rolling isolator: scale factors, and responses converted to full scale."""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.offering import offer
from symfric.model.symbols import finite

__all__ = [
    "FACTORS",
    "SYMBOLS",
    "Factors",
    "ScalingSymbols",
    "factors",
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
class Factors:
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

    def __repr__(self) -> str:
        return f"Factors(length={self.length}, density={self.density}, acceleration={self.acceleration})"

    def to_dict(self) -> dict:
        """Return the factors by name.

        Returns
        -------
        dict
            Plain numbers, strings and lists.
        """
        return {f.name: getattr(self, f.name) for f in fields(self)}


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
def factors(L=None, D=None, *, mass=None, symbolic: bool = False) -> Factors:
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
    if symbolic:
        return FACTORS
    if L is None:
        raise SceneError("no L; give the length of the prototype over that of the model")
    if D is not None and mass is not None:
        raise SceneError("D and mass are both given; mass is D/L^3, so give one of them")
    L = _positive(L, "L")
    D = _positive(1.0 if D is None else D, "D") if mass is None else _positive(mass, "mass") * L**3
    values = {name: float(formula.subs({_L: L, _D: D})) for name, formula in FACTORS.to_dict().items()}
    return Factors(**values)


def returned_ratio(model, prototype, factor):
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
    if any(isinstance(e, sp.Expr) for e in (model, prototype, factor)):
        return model / (factor * prototype)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.asarray(model, dtype=float) / (factor * np.asarray(prototype, dtype=float))
    return ratio if ratio.ndim else float(ratio)


def _positive(value, what: str) -> float:
    number = finite(value, what)
    if number <= 0:
        raise SceneError(f"{what} is {number:g}; it must be positive")
    return number


offer(__name__)
