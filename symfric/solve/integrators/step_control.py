"""Length of the next piece of an integration, from the error of the last one relative to the allowed error."""

import math

_SAFETY = 0.9  # of the length at which the estimated error would just equal the allowed one
_GROWTH = 4.0  # largest growth from one piece to the next: the estimate holds near the present length only
_TRIFLE = 1e-6  # relative error below which the estimate is rounding and says nothing more
_SHRINK = (0.1, 0.7)  # least and largest factor after a piece that was refused
_FAILED = 0.2  # factor where no error is known: the integrator gave up, or an event was missed


def growth(excess: float, order: int) -> float:
    """Return the factor of the next length after an accepted piece whose error goes with a power of its length."""
    factor: float = _SAFETY * max(excess, _TRIFLE) ** (-1 / order)
    return min(_GROWTH, factor)


def shrinkage(excess: float, order: int) -> float:
    """Return the factor of the length for another try; infinite or small errors stand for other failures."""
    factor: float = _SAFETY * excess ** (-1 / order) if math.isfinite(excess) and excess > 1 else _FAILED
    return min(_SHRINK[1], max(_SHRINK[0], factor))
