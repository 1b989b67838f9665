"""Quantities of pint among the numbers of a scene: a number in the unit of its symbol, or in its own."""

import sys
from collections.abc import Mapping
from typing import Any

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC
from symfric.model.dimensions import short_factor
from symfric.model.symbols import name_of, shorten
from symfric.model.unit_texts import NUMBER, dimension_of, read_unit


def is_quantity(value: object) -> bool:
    """Whether a value is a quantity of pint, which is not imported for that."""
    pint = sys.modules.get("pint")
    return pint is not None and isinstance(value, pint.Quantity)


def without_units(entries: Mapping[Any, Any], units: dict[str, str]) -> Mapping[Any, Any]:
    """Return values with plain numbers in place of quantities; a symbol without a unit takes that of its quantity.

    Parameters
    ----------
    entries : mapping of symbol or name to value
    units : dict of str to str
        Units by name; new ones are added.

    Raises
    ------
    SceneError
        If a quantity is of another dimension than the unit of its symbol.
    """
    if not isinstance(entries, Mapping) or not any(map(is_quantity, entries.values())):
        return entries
    numbers = dict(entries)
    for key, value in entries.items():
        if is_quantity(value):
            numbers[key] = number_of(value, name_of(key), units)
    return numbers


def number_of(quantity: Any, name: str, units: dict[str, str]) -> float:
    """Return a quantity as a number in the unit of a symbol, which is that of the quantity if there is none yet."""
    with SYMBOLIC:
        unit = f"{quantity.units:~P}"
        if (0 * quantity).to_base_units().magnitude:
            raise SceneError(f"{name} is in {unit}, whose zero is not that of its base unit; give it in another unit")
        text = units.setdefault(name, unit or "1")
        given, expected = dimension_of(type(quantity)(1.0, quantity.units)), read_unit(text, f"units.{name}")
        if given.base != expected.base:
            said = "a plain number" if text in NUMBER else f"in {text}"
            raise SceneError(f"{name} is {said}, and its value {shorten(quantity, 40)} is not")
        return float(quantity.magnitude) * short_factor(given / expected)
