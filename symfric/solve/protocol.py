"""Interfaces of a route and of a prepared program."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeAlias

from symfric.model.scene import Scene
from symfric.model.symbols import Key
from symfric.solve.batch import Batch
from symfric.solve.lowered import LoweredScene
from symfric.solve.run import Run

RouteName: TypeAlias = Literal["exact", "taylor", "integrators"]


@dataclass(frozen=True)
class Answer:
    """Answer of a route: whether it takes a scene, and why.

    Attributes
    ----------
    takes : bool
    preferred : bool
        Whether no other route that takes the scene is faster by itself; of several, the first in the list is chosen.
    words : str
        The reason.
    """

    takes: bool
    preferred: bool
    words: str


class Program(Protocol):
    """A compiled scene that can be run many times, from any thread."""

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
    """Settings of one solver, with the methods that check and compile a scene for it."""

    @property
    def name(self) -> str:
        """Name of the route in `prepare` and scene files."""

    def answer(self, scene: LoweredScene) -> Answer:
        """Return whether this route takes a scene, and why."""

    def build(self, scene: LoweredScene, tolerance: float) -> Program:
        """Compile a scene; raise `NoRoute` if this route cannot take it."""
