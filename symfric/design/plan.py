"""Base of the designs of a scene file: the keys of a table of ``[design]``, the call, and what a page says of it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, is_dataclass
from typing import Annotated, Any, ClassVar, NamedTuple, NoReturn, Self, TypeAlias

import sympy as sp
from pydantic import AfterValidator, ConfigDict, Field

from symfric.design.optimal_control.collocation import Profile
from symfric.design.result import Design
from symfric.design.wording import Wording
from symfric.errors import SceneError
from symfric.fields import MAX_TABLES, Number, Range
from symfric.model.scene import Scene
from symfric.model.symbols import nearest, shorten
from symfric.motions.motion import Motion
from symfric.motions.table import MotionTable


def _ordered(pair: tuple[float, float]) -> tuple[float, float]:
    if not pair[0] <= pair[1]:
        raise ValueError(f"is [{pair[0]:g}, {pair[1]:g}]; write [smallest, largest]")
    return pair


def _not_negative(pair: tuple[float, float]) -> tuple[float, float]:
    if not 0 <= pair[0] <= pair[1]:
        raise ValueError(f"is [{pair[0]:g}, {pair[1]:g}]; write [smallest, largest], not negative")
    return pair


_SOME = Field(min_length=1, max_length=MAX_TABLES)
Span = Annotated[Range, AfterValidator(_not_negative)]
SignedSpan = Annotated[Range, AfterValidator(_ordered)]
Spans = Annotated[dict[str, Span], _SOME]
SignedSpans = Annotated[dict[str, SignedSpan], _SOME]
Numbers = Annotated[dict[str, Number], _SOME]
Designed: TypeAlias = Design | Profile


@dataclass(frozen=True)
class TableReader:
    """The scene file around a table: what names, texts and motions in its keys mean.

    Attributes
    ----------
    place : str
        Of the table, for messages.
    scene : Scene
    model : str or None
        Name of the ready scene, None for equations of its own.
    expression : callable ``(text, place) -> Expr``
        Of states and values.
    motion : callable ``(table, place) -> Motion``
    """

    place: str
    scene: Scene
    model: str | None
    expression: Callable[[str, str], sp.Expr]
    motion: Callable[[MotionTable, str], Motion]

    def refuse(self, key: str, problem: str) -> NoReturn:
        """Raise `SceneError` with the place of a key."""
        raise SceneError(f"{self.place}.{key} {problem}")

    def parameters(self, key: str, names: Iterable[str | None]) -> None:
        """Raise unless all names are values of the scene."""
        self._among(key, names, [s.name for s in self.scene.parameters], "value")

    def states(self, key: str, names: Iterable[str | None]) -> None:
        """Raise unless all names are states of the scene."""
        self._among(key, names, [s.name for s in self.scene.system.states], "state")

    def _among(self, key: str, names: Iterable[str | None], known: list[str], what: str) -> None:
        for name in names:
            if name is not None and name not in known:
                raise SceneError(f"{self.place}.{key}: no {what} {shorten(name, 40)!r}{nearest(name, known)}")


class ClosedForm(NamedTuple):
    """A closed form beside what a design has computed of the same quantity."""

    quantity: str
    predicted: float
    computed: float
    source: str


@dataclass(frozen=True)
class DesignPlan(ABC):
    """A design to compute: one table of ``[design]``, whose keys are the fields.

    Attributes
    ----------
    kind : str
        Name of the table and of the function in `symfric.design`.
    function : callable ``(scene, **arguments) -> Design or Profile``
    heading, caption : str
        Heading of the section of the page, and caption of the picture that the design draws.
    models : tuple of str
        Ready scenes that the design takes; none if it takes any scene.
    excites : bool
        Whether the design shakes the scene, so that motions without and with it are shown.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    kind: ClassVar[str]
    function: ClassVar[Callable[..., Designed]]
    heading: ClassVar[str]
    caption: ClassVar[str] = "What limits the design; dashed: the level at which it does."
    models: ClassVar[tuple[str, ...]] = ()
    excites: ClassVar[bool] = False

    @property
    def arguments(self) -> dict[str, Any]:
        """Arguments of the function, as far as the table gives them."""
        return given(self)

    @property
    @abstractmethod
    def varied(self) -> tuple[str, ...]:
        """Names of the design parameters."""

    def __call__(self, scene: Scene) -> Designed:
        """Compute the design; raises the exceptions of the design function."""
        return type(self).function(scene, **self.arguments)

    def read(self, reader: TableReader) -> Self:
        """Return the plan with what its keys mean in a scene file; raises `SceneError` where they do not fit it."""
        return self

    @abstractmethod
    def question(self, wording: Wording) -> str:
        """Return the design problem as a sentence without its end."""

    @abstractmethod
    def objective(self, wording: Wording) -> tuple[str, str]:
        """Return the name of the objective and its unit, as far as known."""

    def told(self, values: str, wording: Wording) -> str:
        """Return what the values of the design do, for the summary."""
        return values

    def axis_unit(self, label: str, wording: Wording) -> str:
        """Return the unit of the vertical axis of the picture, "" where its label has one or none is known."""
        return ""

    def working(self, design: Designed) -> tuple[dict[str, float], float]:
        """Return values with which the requirement was met on the full model, and by how much they exceed the optimum.

        The excess is relative, and infinite where the optimum is zero.
        """
        return dict(design.corrected or design.values), 0.0

    def excited(self, scene: Scene, design: Designed) -> Scene:
        """Return the scene with the design."""
        return scene.where(design.values)

    def closed_forms(self, scene: Scene, design: Designed) -> list[ClosedForm]:
        """Return closed forms of what was designed on `symfric.scenes.mass_on_belt` with its cubic law."""
        return []


def given(table: Any) -> dict[str, Any]:
    """Return the keys of a table that are given, tables inside it as dicts; none without a table."""
    values = {} if table is None else {f.name: getattr(table, f.name) for f in fields(table)}
    return {k: given(v) if is_dataclass(v) else v for k, v in values.items() if v is not None}
