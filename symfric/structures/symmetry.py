"""Which matrices of a structure are symmetric or skew-symmetric to rounding, and what that decides."""

from typing import Any

from symfric.structures.structure import Structure

_ROUNDING = 1e-13  # of the largest entry: asymmetry that is rounding


def is_symmetric(matrix: Any) -> bool:
    """Whether a sparse matrix equals its transpose."""
    return _vanishes(matrix - matrix.T, matrix)


def is_skew(matrix: Any) -> bool:
    """Whether a sparse matrix is the negative of its transpose."""
    return _vanishes(matrix + matrix.T, matrix)


def can_decay(s: Structure) -> bool:
    """Whether modes can decay away from a loss of stability: not without damping, nor with gyroscopic forces alone."""
    return s.C is not None and not (is_skew(s.C) and is_symmetric(s.friction))


def _vanishes(rest: Any, whole: Any) -> bool:
    return float(abs(rest).max()) <= _ROUNDING * float(abs(whole).max())
