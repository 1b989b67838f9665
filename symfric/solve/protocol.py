"""What a route and a prepared program offer."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from symfric.model.scene import Scene
from symfric.model.symbols import Key
from symfric.solve.batch import Batch
from symfric.solve.lowered import LoweredScene
from symfric.solve.run import Run


@dataclass(frozen=True)
class Answer:
    """Whether a route takes a scene.

    Attributes
    ----------
    takes : bool
    preferred : bool
        Whether no other route that takes the scene is faster by itself; of several, the first in the list is chosen.
    words : str
        Why.
    """

    takes: bool
    preferred: bool
    words: str


class Program(Protocol):
    """A scene compiled once, to be run many times, from any thread."""

    scene: Scene
    tolerance: float

    @property
    def built_in(self) -> Mapping[str, float]:
        """Parameters that the machine code takes as numbers."""

    def run(
        self,
        values: Mapping[Key, float] | None = None,
        initial: Mapping[Key, float] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Run:
        """Run with other parameter values or another start."""

    def map(
        self,
        values: Mapping[Key, Any] | None = None,
        initial: Mapping[Key, Any] | None = None,
        threads: int = 1,
        progress: Callable[[float], None] | None = None,
    ) -> Batch:
        """Run many cases; numbers in as rows, results out as rows."""


class Route(Protocol):
    """The settings of a way to solve scenes, which know how to prepare one."""

    @property
    def name(self) -> str:
        """What users call it."""

    def answer(self, scene: LoweredScene) -> Answer:
        """Say whether this route takes a scene."""

    def build(self, scene: LoweredScene, tolerance: float) -> Program:
        """Compile a scene; raise `NoRoute` if it is none for this route."""
