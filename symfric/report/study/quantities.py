"""Numbers in sentences, with their units."""

import math
import re

from symfric.model.symbols import superscript
from symfric.scenefile import SceneFile

_EXPONENT = re.compile(r"(?<=\d)e([+-]\d+)\b")


def measure(value: float, name: str, file: SceneFile) -> str:
    """Return a number with the unit of a state or value."""
    return measured(value, file.units.get(name, ""))


def measured(value: float, unit: str) -> str:
    """Return a number of five digits with its unit."""
    return f"{powers_of_ten(f'{value:.5g}').replace('-', '−')}{' ' + unit if unit else ''}"


def powers_of_ten(text: str) -> str:
    """Return a number in text with a power of ten in the place of an e."""
    return _EXPONENT.sub(lambda m: "·10" + superscript(int(m.group(1))), text)


def angular_frequency(value: float, file: SceneFile) -> str:
    """Return an angular frequency with its unit, and in Hz where time has one."""
    hertz = file.units.hertz
    return measured(value, file.units.angular) + (f" ({value * hertz:.4g} Hz)" if math.isfinite(hertz) else "")
