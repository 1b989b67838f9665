"""Sentences on designs: numbers, ranges and quantities of a scene with their units."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from symfric.model.belts import belt_speeds
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.model.units import Units

_NUMBER = r"([-−]?\d++(?:\.\d++)?+(?:e[+-]?\d++)?+)"


@dataclass(frozen=True)
class Wording:
    """What sentences on a design need of its scene.

    Attributes
    ----------
    scene : Scene
    coordinate : str
        State whose vibration is measured.
    """

    scene: Scene
    coordinate: str

    @property
    def units(self) -> Units:
        """Units of states and values by name, as far as known."""
        return self.scene.units

    @cached_property
    def quantities(self) -> dict[str, str]:
        """Units of what designs report, as far as known."""
        system, units = self.scene.system, self.units
        u = system.u[0]
        impulse = system.mass[0, 0] * u if system.linear is None else None  # matrices have no units
        return {
            "half range": units.get(self.coordinate, ""),
            "displacement": units.get(system.q[0].name, ""),
            "velocity": units.get(u.name, ""),
            "acceleration": units.of(u / TIME),
            "force": "" if impulse is None else units.of(impulse / TIME),
            "power": "" if impulse is None else units.of(impulse * u / TIME),
            "rate": units.rate,
            "damping": units.of(1 / TIME),
            "time of rest": units.get("t", ""),
        }

    def number(self, value: float, name: str = "") -> str:
        """Return a number with the unit of a name."""
        return with_unit(f"{value:g}", self.units.get(name, ""))

    def interval(self, pair: tuple[float, float], name: str = "") -> str:
        """Return a range as text, with the unit of a name."""
        return f"{pair[0]:g} to {self.number(pair[1], name)}"

    def speeds(self, pair: tuple[float, float], name: str | None = None) -> str:
        """Return a range of speeds, those of the belt unless another one is named."""
        return self.interval(pair, name or next((s.name for s in belt_speeds(self.scene)), ""))

    def bounds(self, bounds: Mapping[str, tuple[float, float]]) -> str:
        """Return the bounds of several parameters as text."""
        return " and ".join(f"{name} from {self.interval(pair, name)}" for name, pair in bounds.items())

    def limits(self, limits: Mapping[str, float]) -> str:
        """Return limits on quantities as the end of a sentence."""
        words = [
            f"at least {100 * v:g} % of the friction is left"
            if n == "friction"
            else f"{n} at most {with_unit(f'{v:g}', self.quantities.get(n, ''))}"
            for n, v in limits.items()
        ]
        return f"; {', '.join(words)}" if words else ""

    def with_units(self, text: str) -> str:
        """Return a sentence with units behind its numbers, those of symbols and those of named quantities."""
        known = {**{f"{name} =": unit for name, unit in self.units.items()}, **self.quantities}
        for words, unit in known.items():
            if unit:
                text = re.sub(
                    rf"(?<!\w)({re.escape(words)}(?:(?: of [a-z ]+| at [^:;()]+)?:)? ){_NUMBER}(?! ?[\w/%])",
                    rf"\1\2 {unit}",
                    text,
                )
        return text


def with_unit(number: str, unit: str) -> str:
    """Return a number with its unit."""
    return f"{number} {unit}" if unit else number
