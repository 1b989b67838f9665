"""Units of acceleration."""

import re

from symfric.errors import SceneError

G = 9.81  # m/s^2
_FACTORS = {"m/s^2": 1.0, "g": G, "cm/s^2": 0.01, "gal": 0.01, "mm/s^2": 0.001}
KNOWN = "'g', 'm/s^2', 'cm/s^2', 'gal' or 'mm/s^2'"
_OTHER = {"m/s": "a velocity", "cm/s": "a velocity", "mm/s": "a velocity", "in/s": "a velocity"}
_OTHER |= {"m": "a displacement", "cm": "a displacement", "mm": "a displacement", "in": "a displacement"}


def plain_unit(unit: str) -> str:
    """Return a unit in one spelling: ``CM/SEC/SEC``, ``cm/s2`` and ``cm/s**2`` are all ``cm/s^2``."""
    text = re.sub(r"\s", "", unit).lower().replace("sec", "s").replace("gals", "gal")
    text = re.sub(r"^(c?m|mm)/(?:s/s|s\*\*2|s2|\(s\^2\)|s\^2|s²)$", r"\1/s^2", text)
    return re.sub(r"^(c?m|mm)(?:\*s|s|\.s)(?:\^|\*\*)?-2$", r"\1/s^2", text)


def is_acceleration(unit: str) -> bool:
    """Whether a word is a unit of acceleration known here."""
    return plain_unit(unit) in _FACTORS


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
        raise SceneError(f"{where} is {unit!r}; give the unit of the samples, {KNOWN}")
    plain = plain_unit(unit)
    if plain in _FACTORS:
        return _FACTORS[plain]
    if plain in _OTHER:
        raise SceneError(f"{where} is {unit}, {_OTHER[plain]}; take the record of the acceleration instead")
    shown = f"{unit!r}, which is " if quoted else ""
    raise SceneError(f"{where} is {shown}no unit of acceleration known here; give {KNOWN}")
