"""Outputs that are square roots, of an extreme, a value or a mean square, and their derivatives.

A root has no Taylor series where its radicand is zero, so a run accumulates the radicand and the root is taken of the
result. Derivatives at a zero radicand do not exist; they are infinite or NaN here, without a warning.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy as sp


def is_root(expr: sp.Expr) -> bool:
    """Whether an expression is a square root."""
    return bool(expr.is_Pow and expr.exp == sp.S.Half)


def root(radicand: Any) -> Any:
    """Return the square root; a radicand that rounding made negative counts as zero."""
    return np.maximum(radicand, 0.0) ** 0.5


def slopes_of_root(slopes: Any, radicand: Any) -> Any:
    """Return d sqrt(r) from the derivatives d r of the radicand: ``dr / (2 sqrt(r))``."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return slopes / (2.0 * radicand**0.5)


def second_slopes_of_root(twice: Any, slopes: Any, radicand: Any, pairs: Sequence[tuple[int, int]]) -> np.ndarray:
    """Return the second derivatives of s = sqrt(r) by pairs of directions: ``(r_ab / 2 - s_a s_b) / s``.

    Parameters
    ----------
    twice : ndarray
        Second derivatives r_ab of the radicand, one column for each pair.
    slopes : ndarray
        First derivatives s_a of the root, one column for each direction.
    radicand : float
    pairs : sequence of (int, int)
        Directions of each column of `twice`.
    """
    products = np.array([slopes[a] * slopes[b] for a, b in pairs])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((0.5 * twice - products) / radicand**0.5)
