"""Friction that differs along the two slips of a contact in the plane: the factors of its ellipse."""

from collections.abc import Sequence
from typing import Any

import sympy as sp

from symfric.errors import SceneError
from symfric.model.symbols import expression, shortened


def read_ellipse(given: Any, contact: str, in_plane: bool) -> tuple[sp.Expr, sp.Expr]:
    """Return the factors of friction along both slips, or raise."""
    where = f"ellipse of contact {contact!r}"
    if not in_plane:
        raise SceneError(f"{where} is for a contact in the plane; give a pair of slips, or remove it")
    if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != 2:
        raise SceneError(f"{where} is {shortened(given)}; give two factors, along the first and the second slip")
    first, second = (expression(e, where) for e in given)
    for e in (first, second):
        if e.is_number and not e > 0:
            raise SceneError(f"{where} has the factor {e}; both must be positive")
    return first, second
