"""Checks and values that the ready scenes share."""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from symfric.errors import SceneError
from symfric.model.laws import Law
from symfric.model.symbols import finite, shortened


def check_range(positive: Mapping[str, Any], not_negative: Mapping[str, Any] | None = None) -> None:
    """Raise if a number is missing, not finite or out of range."""
    for name, value in {**positive, **(not_negative or {})}.items():
        number = finite(value, name)
        if number < 0 or (number == 0 and name in positive):
            raise SceneError(
                f"{name} is {number:g}; it must {'be positive' if name in positive else 'not be negative'}"
            )


def open_values(law: Law) -> dict[sp.Symbol, None]:
    """Return the symbols of a law as scene values without a number, to be given later with `where`."""
    if not isinstance(law, Law):
        raise SceneError(f"law is {shortened(law)}; use one of sf.laws")
    return dict.fromkeys(sorted(law.free_symbols, key=str))
