"""Units as texts: read by pint into dimensions, and written in base units."""

import math
import re
from fractions import Fraction
from functools import cache
from typing import Any

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC
from symfric.model.dimensions import PLAIN, Dimension, factor
from symfric.model.symbols import shorten, superscript

_WRITTEN = re.compile(r"[\w\s·⋅*/^().%°²³⁻¹⁰⁴⁵⁶⁷⁸⁹+-]{0,40}")
_POWER = re.compile(r"(\*\*|\^)\s*([+-]?\d{1,2}(\.\d+)?(?!\s*(\*\*|\^|\d))|\(\s*-?\d{1,2}\s*/\s*\d{1,2}\s*\))")
NUMBER = ("", "1", "-", "–")
_BASE = {"[mass]": "kg", "[length]": "m", "[time]": "s", "[current]": "A", "[temperature]": "K"}


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(cache_folder=None)


@cache
def _parsed(text: str) -> Dimension:
    if text.strip() in NUMBER:
        return PLAIN
    rest = _POWER.sub("", text)  # powers of powers would take for ever
    if not _WRITTEN.fullmatch(text) or "**" in rest or "^" in rest:
        raise ValueError(text)
    unit = _registry().parse_units(text.replace("⋅", "·"))
    if _registry().Quantity(0.0, unit).to_base_units().magnitude:  # degrees Celsius have their zero elsewhere
        raise ValueError(text)
    return dimension_of(_registry().Quantity(1.0, unit))


def dimension_of(quantity: Any) -> Dimension:
    """Return the dimension of a quantity of pint of the size 1."""
    base = quantity.to_base_units()
    powers = {k: Fraction(v).limit_denominator(100) for k, v in base.dimensionality.items() if v}
    return Dimension(powers, math.log(float(base.magnitude)))


def read_unit(text: str, place: str = "") -> Dimension:
    """Return the dimension of the text of a unit; raise if it is not one."""
    if not isinstance(text, str):
        raise SceneError(f"{place} is {shorten(text, 40)!r}; give the unit as a text, such as 'N/m'")
    _registry()  # an error of pint's own must not pass for one of the text
    try:
        with SYMBOLIC:
            return _parsed(text)
    except Exception:  # pint raises errors of many kinds on what is no unit
        raise SceneError(
            f"{place}: {shorten(text, 40)!r} is not a unit; write N/m, kg, m/s, rad/s, or 1 for a plain number"
        ) from None


def in_base_units(dimension: Dimension) -> str:
    """Return a dimension in m, kg, s, with its factor."""
    order = [k for k in _BASE if k in dimension.base] + sorted(k for k in dimension.base if k not in _BASE)
    parts = [(k, dimension.base[k]) for k in order]
    above = " ".join(_power(_BASE.get(k, k.strip("[]")), v) for k, v in parts if v > 0)
    below = " ".join(_power(_BASE.get(k, k.strip("[]")), -v) for k, v in parts if v < 0)
    text = (above or "1") + (f"/({below})" if " " in below else f"/{below}" if below else "")
    size = factor(dimension)
    return text if abs(size - 1) < 1e-9 else f"{size:.6g} {text}"


def _power(unit: str, power: Fraction) -> str:
    return unit if power == 1 else unit + (superscript(int(power)) if power.denominator == 1 else f"^({power})")
