"""Units of acceleration."""

import re
from collections.abc import Mapping
from fractions import Fraction

from symfric.errors import SceneError
from symfric.model.dimensions import short_factor
from symfric.model.symbols import shortened
from symfric.model.unit_texts import read_unit

G = 9.81  # m/s^2
_AT_ONCE = {"m/s^2": 1.0, "g": G, "gal": 0.01}  # the usual one, and two that pint takes for a gram and a gallon
KNOWN = "'g', 'm/s^2', 'cm/s^2', 'gal' or 'mm/s^2'"
# by the power of time beside a length
_KINDS: Mapping[Fraction | int, str] = {-2: "an acceleration", -1: "a velocity", 0: "a displacement"}


def plain_unit(unit: str) -> str:
    """Return a unit as pint reads it: ``CM/SEC/SEC``, ``cm/s2`` and ``cm.s-2`` are ``cm/s/s``, ``cm/s^2`` and so on."""
    text = re.sub(r"\s", "", unit).lower().replace("sec", "s").replace("gals", "gal")
    text = re.sub(r"/s2$", "/s^2", text)
    return re.sub(r"^(c?m|mm)(?:\*s|s|\.s)(?:\^|\*\*)?-2$", r"\1/s^2", text)


def _read(unit: str) -> tuple[str, float]:
    """Return of what a word is the unit, "" if of none known here, and its factor to m, s."""
    plain = plain_unit(unit)
    if plain in _AT_ONCE:
        return _KINDS[-2], _AT_ONCE[plain]
    try:
        dimension = read_unit(plain)
    except SceneError:
        return "", 1.0
    moved = {**dimension.base, "[time]": 0} == {"[length]": 1, "[time]": 0}  # a length, whatever the power of time
    return _KINDS.get(dimension.base.get("[time]", 0), "") if moved else "", short_factor(dimension)


def is_acceleration(unit: str) -> bool:
    """Whether a word is a unit of acceleration."""
    return _read(unit)[0] == _KINDS[-2]


def factor_of(unit: str, where: str, quoted: bool = True) -> float:
    """Return the factor from a unit to m/s^2.

    Parameters
    ----------
    unit : str
    where : str
        Stands before the message.
    quoted : bool
        Whether a message quotes an unknown unit; not for one read from a file.

    Raises
    ------
    SceneError
        If it is no unit of acceleration.
    """
    if not isinstance(unit, str):
        raise SceneError(f"{where} is {shortened(unit)}; give the unit of the samples, {KNOWN}")
    kind, factor = _read(unit)
    if kind == _KINDS[-2]:
        return factor
    if kind:
        raise SceneError(f"{where} is {unit}, {kind}; take the record of the acceleration instead")
    shown = f"{unit!r}, which is " if quoted else ""
    raise SceneError(f"{where} is {shown}no unit of acceleration known here; give {KNOWN}")
