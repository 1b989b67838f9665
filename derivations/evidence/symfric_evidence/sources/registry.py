"""Registry entries of reproduced figures and tables: how they are computed, drawn, written and judged."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np

from symfric.motions.motion import Motion

_Data = TypeVar("_Data")


@dataclass(frozen=True)
class Inputs:
    """Inputs of a computation.

    Attributes
    ----------
    motions : sequence of Motion or None
        Ground motions for the figures that take them; artificial ones are made where there are none.
    progress : callable ``(fraction) -> None``
    """

    motions: Sequence[Motion] | None = None
    progress: Callable[[float], None] = field(default=lambda _fraction: None, repr=False)


@dataclass(frozen=True)
class Finding:
    """A claim of a source, and the result.

    Attributes
    ----------
    claim, found : str
    holds : bool or None
        None where the source leaves open what would decide it.
    """

    claim: str
    found: str
    holds: bool | None = None

    def __str__(self) -> str:
        verdict = {True: "true", False: "not so", None: "open"}[self.holds]
        return f"{self.claim}: {verdict}; {self.found}"


@dataclass(frozen=True)
class Made:
    """A reproduced figure or table.

    Attributes
    ----------
    figure : matplotlib Figure or None
    text : str
        A table for reading; empty if there is none.
    data : object
        Plain data for JSON, or None.
    findings : tuple of Finding
    """

    figure: Any = None
    text: str = ""
    data: object = None
    findings: tuple[Finding, ...] = ()


def _nothing(_data: object) -> tuple[Finding, ...]:
    return ()


@dataclass(frozen=True)
class Entry(Generic[_Data]):
    """The recipe of a reproduced figure or table; computing and drawing are separate functions.

    Attributes
    ----------
    caption : str
    compute : callable ``(Inputs) -> data``
    draw : callable ``(data, axes=None) -> Axes or array of Axes``, or None
    text : callable ``(data) -> str``, or None
    plain : callable ``(data) -> object``, or None
        Data for JSON.
    findings : callable ``(data) -> tuple of Finding``
    takes_records : bool
        Whether ground motions make a difference.
    """

    caption: str
    compute: Callable[[Inputs], _Data] = field(repr=False)
    draw: Callable[[_Data], Any] | None = field(default=None, repr=False)
    text: Callable[[_Data], str] | None = field(default=None, repr=False)
    plain: Callable[[_Data], object] | None = field(default=None, repr=False)
    findings: Callable[[_Data], tuple[Finding, ...]] = field(default=_nothing, repr=False)
    takes_records: bool = False

    def make(self, inputs: Inputs | None = None) -> Made:
        """Compute a figure or table, draw it and write its text."""
        data = self.compute(Inputs() if inputs is None else inputs)
        return Made(
            None if self.draw is None else np.ravel(self.draw(data))[0].figure,
            "" if self.text is None else self.text(data),
            None if self.plain is None else self.plain(data),
            tuple(self.findings(data)),
        )


SOURCES = {
    "thomsen": "Thomsen",
    "handbook": "Vibration and Shock Handbook, 19.5",
    "guida": "Guida, Nilvetti and Pappalardo",
    "younes": "Younes and Ashour",
    "rolling": "Scaling of rolling friction",
}


def title(name: str) -> str:
    """Return a name as a title: source, and its figure or table."""
    source, _, rest = name.partition("-")
    kind, _, number = rest.rpartition("-")
    if rest[0].isdigit():
        return f"{SOURCES[source]}, figure {rest}"
    return f"{SOURCES[source]}, {kind} {number}" if kind == "table" else f"{SOURCES[source]}: {rest.replace('-', ' ')}"
