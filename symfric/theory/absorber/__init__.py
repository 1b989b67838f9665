"""Tuned mass damper on an undamped main mass: response, and optimal tuning and damping for several criteria.

One main mass on a spring, omega1 = 1; on it a mass ``mu`` times as large, on a spring tuned to ``f = omega2/omega1``
and a damper ``zeta = c2/(2 m2 omega2)``. Every formula is proved in derivations/absorber.py.
"""

from typing import TYPE_CHECKING

from symfric.model.public_names import names_of
from symfric.theory.absorber.response import (
    SYMBOLS,
    AbsorberSymbols,
    decay_rate,
    peaks,
    response,
    state_matrix,
    variance,
)
from symfric.theory.absorber.tuning import (
    Tuned,
    fastest_decay,
    fixed_points,
    least_peak,
    least_variance,
    widest_stability,
)

__all__ = [
    "SYMBOLS",
    "AbsorberSymbols",
    "Tuned",
    "decay_rate",
    "fastest_decay",
    "fixed_points",
    "least_peak",
    "least_variance",
    "peaks",
    "response",
    "state_matrix",
    "variance",
    "widest_stability",
]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
