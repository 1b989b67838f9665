"""The fast vibration that keeps steady sliding from starting to vibrate: across the sliding direction, and along it."""

import itertools
from dataclasses import dataclass

import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.averaged_law import pieces_between
from symfric.model.laws import Law
from symfric.model.laws.law import refuse_memory
from symfric.model.numeric import ArrayFunction, numeric_function
from symfric.model.results import Result
from symfric.model.symbols import SPEED, positive, shortened
from symfric.search import Function, zero
from symfric.theory.plane.vibration import (
    lateral_vibration_drag,
    lateral_vibration_power,
    longitudinal_vibration_drag,
    longitudinal_vibration_power,
    mean_across,
    mean_along,
)

_RATIOS = np.geomspace(1e-3, 1e3, 121)  # of intensity to speed that are searched


@dataclass(frozen=True)
class QuenchComparison(Result):
    """Least intensities of fast vibration that make steady sliding stable, across the sliding direction and along it.

    Attributes
    ----------
    speed, damping : float
        Of the sliding; damping constant over normal load.
    across, along : float
        Least intensity, 0 where the sliding is stable anyway; in the limit from above.
    power_across, power_along : float
        That maintains the vibration, over the normal load; negative where the sliding drives it.
    drag_across, drag_along : float
        Mean friction that remains, over the normal load.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.theory.plane.compare_quenching(sf.laws.cubic(0.4, 0.25, 0.5), 0.2)
    >>> print(f"{found.across:.4f} {found.along:.4f} {found.drag_across:.4f} {found.drag_along:.4f}")
    0.1622 0.2000 0.2675 0.3220
    """

    speed: float
    damping: float
    across: float
    along: float
    power_across: float
    power_along: float
    drag_across: float
    drag_along: float


@alone(SYMBOLIC)
def compare_quenching(law: Law, speed: float, damping: float = 0.0) -> QuenchComparison:
    r"""Compare the fast vibration across and along the sliding direction that stabilises steady sliding.

    Parameters
    ----------
    law : Law
        In numbers.
    speed : float
        Of the sliding, > 0.
    damping : float
        Damping constant over normal load, >= 0.

    Returns
    -------
    QuenchComparison

    Raises
    ------
    NotFound
        If no intensity across up to a thousand times the speed does.
    SceneError
        If a number is out of range, or the law has symbols or memory.

    Notes
    -----
    One mass slides stably where the slope of its mean friction is at least minus the damping. Across it is
    :math:`\langle\mu' v^2/S^2 + \mu\,q^2\cos^2\theta/S^3\rangle`, which rises from the first vibration on, by
    :math:`q^2\mu/(2v^3)` on slow sliding; along it is :math:`\langle\mu'(|w|)\rangle` for q < v, and jumps to infinity
    at q = v: Thomsen (57), (58). So slow sliding needs less intensity across, and falling friction pays for
    the vibration along; derivations/plane.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.theory.plane.compare_quenching(sf.laws.cubic(0.4, 0.25, 0.5), 0.2)
    >>> bool(found.across < found.along and found.power_along < found.power_across)
    True
    """
    if not isinstance(law, Law):
        raise SceneError(f"law is {shortened(law)}; give one of sf.laws")
    refuse_memory(law, "steady sliding in the plane")
    v, damping = positive(speed, "speed"), positive(damping, "damping", zero=True)
    law(v)  # raises if the law has symbols
    slope = _slope(law)

    def across(q: float) -> float:
        return damping + slope_across(law, slope, v, q)

    def along(q: float) -> float:
        return damping + mean_along(law, v, q, lambda w: slope(np.abs(w)))

    q_across, q_along = 0.0, 0.0
    if float(slope(np.array(v))) < -damping:
        above, below = _first(across, v), _first(along, v, 1.0)
        if above is None:
            raise NotFound(f"no intensity across up to {_RATIOS[-1] * v:g} makes sliding at {v:g} stable")
        q_across, q_along = above, v if below is None else below
    return QuenchComparison(
        v,
        damping,
        q_across,
        q_along,
        lateral_vibration_power(v, q_across, law),
        longitudinal_vibration_power(v, q_along, law),
        lateral_vibration_drag(v, q_across, law),
        longitudinal_vibration_drag(v, q_along, law),
    )


def slope_across(law: Law, slope: ArrayFunction, v: float, q: float) -> float:
    """Return the slope of the mean friction under vibration across, for the slope of the law as a function."""
    own = mean_across(law, v, q, lambda s: (v / s) ** 2, slope)
    return own + mean_across(law, v, q, lambda s: (s - v) * (s + v) / s**3)


def _slope(law: Law) -> ArrayFunction:
    """Return the slope of a law as a function of speeds."""
    pieces = [piece.diff(SPEED) for piece in pieces_between(law.kinetic, law.breaks)]
    conditions = [b > SPEED for b in law.breaks]
    return numeric_function((SPEED,), sp.Piecewise(*zip(pieces, [*conditions, sp.true], strict=True)))


def _first(margin: Function, v: float, most: float = np.inf) -> float | None:
    """Return the least intensity at which a margin becomes positive, None if none below `most` times the speed does."""
    grid = v * _RATIOS[most > _RATIOS]
    values = [margin(q) for q in grid]
    for k, (a, b) in enumerate(itertools.pairwise(values)):
        if a < 0 <= b:
            return zero(margin, grid[k], grid[k + 1])
    return None
