"""Sections of a scene file and the types of their keys; errors of pydantic become one line with place and cure."""

from typing import Annotated, Any

from pydantic import ConfigDict, Field

from symfric.errors import SceneError
from symfric.fields import (
    MAX_TABLES,
    Axis,
    Mass,
    Names,
    Number,
    Option,
    Positive,
    Range,
    Section,
    Term,
    Terms,
    Text,
    Unit,
    kind_of,
)
from symfric.model.symbols import nearest, shorten
from symfric.motions.table import Ground
from symfric.scenefile.contact_tables import FrictionTable, OwnFriction, RowFriction
from symfric.scenefile.held import HeldTables, ResetTables
from symfric.scenefile.sections import checked
from symfric.scenefile.structure_tables import FlutterTable, StructureScene

_DEEPEST_NAME = 8  # points in the name of a state


class ReadyScene(Section):
    """The section ``[scene]`` of a ready model; its other keys are arguments of the model's function.

    Attributes
    ----------
    model
        Name of a ready scene, see ``symfric scenes``.
    motion
        Ground motion, for the models that take one: path of a record, or a table with ``kind``.
    motions
        Two of them, along x and along y, for the models that take both.
    initial
        Start values that differ from those of the model.
    """

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, Option]

    model: Text
    motion: Ground | None = None
    motions: Annotated[list[Ground], Field(min_length=2, max_length=2)] | None = None
    initial: dict[str, Number] = Field(default_factory=dict)


class OwnScene(Section):
    """The section ``[scene]`` with own equations.

    Attributes
    ----------
    coordinates
        Names of the coordinates q.
    velocities
        Names of the velocities u = q', one for each coordinate.
    mass
        Mass matrix: one entry, the diagonal, or all rows.
    force
        Right-hand side of M u' = force, one for each coordinate, without the friction.
    z
        Names of first-order states, for controllers and the like.
    z_rate
        Their rates, one for each.
    initial
        Start value of every state.
    horizon
        Length of the run.
    """

    coordinates: Names
    velocities: Names
    mass: Mass
    force: Terms
    z: Names = Field(default_factory=list)
    z_rate: Terms = Field(default_factory=list)
    initial: dict[str, Term]
    horizon: Positive


class Sweep(Section):
    """The section ``[sweep]``: equally spaced values of one parameter, and the measurement of the vibration.

    ``[sweep.grid]`` is for ``symfric sweep``: values, or start, stop and count, for each of several parameters.

    Attributes
    ----------
    parameter
        Value to vary; the belt speed unless given.
    from_
        First value.
    to
        Last value.
    number
        How many values.
    coordinate
        State whose half range is measured; the first unless given.
    settle
        Time after which the motion is measured; found by itself unless given.
    window
        Length of the measurement; found by itself unless given.
    branch
        Range over which limit cycles are followed from the onset of vibration.
    grid
        Axes of ``symfric sweep``: a list of values, or start, stop and count, for each name.
    """

    parameter: Text | None = None
    from_: Number | None = Field(default=None, alias="from")
    to: Number | None = None
    number: Annotated[int, Field(ge=2, le=10_000, strict=True)] = 40
    coordinate: Text | None = None
    settle: Positive | None = None
    window: Positive | None = None
    branch: Range | None = None
    grid: Annotated[dict[str, Axis], Field(max_length=MAX_TABLES)] = Field(default_factory=dict)


class Identify(Section):
    """The section ``[identify]``: a record, what it measures, and the unknowns with their bounds.

    Attributes
    ----------
    record
        Path of a table beside the scene file, times in its first column: a text with a line of names, or an array in a
        file .npy, whose columns are called t, c1, c2, ... unless its fields have names.
    unknowns
        Bounds of each value to fit; ``"NAME.offset"`` and the like for those of a column.
    observed
        What a column of the record measures; the state of its name unless given.
    sigma
        Standard deviation of the noise, one for all columns or one for each.
    starts
        Starts of the search.
    seed
        Of the starts.
    loss
        How residuals count: ``linear`` by their squares; ``soft_l1``, ``huber`` or ``cauchy`` less, for outliers.
    """

    record: Text
    unknowns: Annotated[dict[str, Range], Field(min_length=1, max_length=MAX_TABLES)]
    observed: Annotated[dict[str, Term], Field(max_length=MAX_TABLES)] = Field(default_factory=dict)
    sigma: Annotated[Positive | dict[str, Positive] | None, Field()] = None
    starts: Annotated[int, Field(ge=1, le=1000, strict=True)] = 8
    seed: Annotated[int, Field(ge=0, strict=True)] = 0
    loss: Text = "linear"


Tables = Annotated[dict[str, Any], Field(max_length=MAX_TABLES)]


class Document(Section):
    """A whole scene file.

    Attributes
    ----------
    title
        Title of the page.
    description
        Words under the title.
    scene
        Ready model, own equations, or the matrices of a structure.
    values
        Number of every name that the equations use.
    friction
        The contacts.
    held
        Variables that are computed at sampling instants or at crossings of zero, such as the command of a controller.
    reset
        Changes of states at known times or at crossings of zero.
    outputs
        What the study lists beside its own results, such as ``"max(x)"``.
    sweep
        Values of one parameter, and how the vibration is measured.
    flutter
        Modes of a structure over the coefficient of friction.
    design
        Designs to compute.
    identify
        A record, and what shall be found from it.
    units
        Unit of a state, a value or ``t``, for axes and tables.
    """

    title: Text = ""
    description: Text = ""
    scene: ReadyScene | OwnScene | StructureScene
    values: Annotated[dict[str, Number], Field(max_length=MAX_TABLES)] = Field(default_factory=dict)
    friction: Annotated[list[FrictionTable], Field(max_length=MAX_TABLES)] = Field(default_factory=list)
    held: HeldTables = Field(default_factory=dict)
    reset: ResetTables = Field(default_factory=list)
    outputs: Annotated[dict[str, Text], Field(max_length=MAX_TABLES)] = Field(default_factory=dict)
    sweep: Sweep | None = None
    flutter: FlutterTable | None = None
    identify: Identify | None = None
    design: Tables = Field(default_factory=dict)
    units: Annotated[dict[str, Unit], Field(max_length=MAX_TABLES)] = Field(default_factory=dict)


def read_document(raw: dict[str, Any]) -> Document:
    """Check the types and keys of a parsed file.

    Parameters
    ----------
    raw : dict
        What `tomllib` returns.

    Raises
    ------
    SceneError
        Naming ``section.key`` and the cure; only the first error.
    """
    data = dict(raw)
    contacts, places = _friction_tables(data.pop("friction", None), data.pop("contact", None))
    if "scene" not in data:
        known = [*Document.model_fields, "contact"]
        close = next((nearest(k, ["scene"]) for k in data if k not in known and "mean" in nearest(k, ["scene"])), "")
        raise SceneError("there is no [scene] section" + (close or "; add one with a model, or with own equations"))
    table = _with_states_of_contacts(_table(data.pop("scene"), "scene"))
    kind = ReadyScene if "model" in table else StructureScene if "structure" in table else OwnScene
    scene = checked(kind, table, "scene")
    contact: type[FrictionTable] = OwnFriction if kind is OwnScene else FrictionTable
    contact = RowFriction if kind is StructureScene else contact
    for own, place in zip(contacts, places, strict=True):
        if "gap" in own and contact is not OwnFriction:
            raise SceneError(f"{place}.gap: contacts that open are for own equations; remove gap")
    friction = [checked(contact, c, p) for c, p in zip(contacts, places, strict=True)]
    return checked(Document, {**data, "scene": scene, "friction": friction}, "", extra=("contact",))


def _with_states_of_contacts(scene: dict[str, Any]) -> dict[str, Any]:
    """Return the table with ``initial.belt.z = 1``, which TOML reads as a table inside another, as the key belt.z."""
    initial = scene.get("initial")
    return {**scene, "initial": _flat(initial)} if isinstance(initial, dict) else scene


def _flat(table: dict[str, Any], depth: int = 0) -> dict[str, Any]:
    """Return a table of tables as one, with the names joined by points."""
    entries: dict[str, Any] = {}
    for name, value in table.items():
        inner = isinstance(value, dict) and value and depth < _DEEPEST_NAME
        entries |= {f"{name}.{own}": v for own, v in _flat(value, depth + 1).items()} if inner else {name: value}
    return entries


def _table(value: object, place: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise SceneError(f"{place} is {kind_of(value)}; write a section [{place}]")
    return value


def _friction_tables(friction: Any, contact: Any) -> tuple[list[dict[str, Any]], list[str]]:
    """Return one table for each contact and its place: ``[friction]``, ``[friction.name]`` or ``[[contact]]``."""
    if friction is not None and contact is not None:
        raise SceneError("both [friction] and [[contact]] are given; they mean the same, keep one")
    if contact is not None:
        tables = contact if isinstance(contact, list) else [contact]
        places = [f"contact[{i}]" for i in range(len(tables))]
    elif friction is None:
        return [], []
    else:
        friction = _table(friction, "friction")
        if friction and all(isinstance(v, dict) for v in friction.values()):
            places = [f"friction.{shorten(name, 30)}" for name in friction]
            tables = [{"name": name, **table} for name, table in friction.items()]
        else:
            tables, places = [friction], ["friction"]
    if len(tables) > MAX_TABLES:
        raise SceneError(f"{len(tables)} contacts; at most {MAX_TABLES} are read")
    return [_table(t, p) for t, p in zip(tables, places, strict=True)], places
