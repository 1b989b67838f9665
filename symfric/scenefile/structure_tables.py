"""Tables of a scene file whose equations are the matrices of a structure."""

from typing import Annotated, Any

from pydantic import BeforeValidator, ConfigDict, Field

from symfric.fields import MAX_TABLES, Number, Option, Positive, Range, Section, Term, Text, as_list, text
from symfric.scenefile.contact_tables import as_row


def _path_as_table(value: object) -> object:
    """Convert the path of matrices to a table."""
    return {"file": value} if isinstance(value, str) else value


def _points(value: object) -> dict[str, str | dict[str, float]]:
    """Return rows by their names; a name alone is the degree of freedom that is called so."""
    if isinstance(value, dict):
        return {text(name): as_row(row) for name, row in value.items()}
    return {text(name): {text(name): 1.0} for name in as_list(value)}


Points = Annotated[dict[str, Any], BeforeValidator(_points), Field(max_length=MAX_TABLES)]


class Source(Section):
    """The matrices of a structure: the path of a file or folder, or ``maker`` with its arguments as further keys.

    Attributes
    ----------
    file
        A .npz, or a folder or zip of Matrix Market files; relative to the scene file.
    maker
        Function of ``sf.structures`` that makes matrices: ``chain``, ``beam``, ``ziegler``, ``disc_and_pad``.
    """

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, Option]

    file: Text | None = None
    maker: Text | None = None


Matrices = Annotated[Source, BeforeValidator(_path_as_table)]


class StructureScene(Section):
    """The section ``[scene]`` of a structure, whose equations are matrices.

    Attributes
    ----------
    structure
        Path of the matrices, or a table with ``maker``.
    points
        Names of degrees of freedom to look at, or names with rows; the pages show the first.
    modes
        Number of modes that are kept beside contacts, forces and points; all degrees of freedom stay unless given.
    places
        CSV of where the degrees of freedom are, for pictures: name, x, and if there are any y and direction.
    force
        Forces, by the name of a degree of freedom or of a point.
    mu
        Factor of the friction matrix in the equations of motion; it is left out unless given.
    initial
        Start values that are not zero.
    horizon
        Length of the run.
    """

    structure: Matrices
    points: Points = Field(default_factory=dict)
    modes: Annotated[int, Field(ge=0, le=1000, strict=True)] | None = None
    places: Text | None = None
    force: Annotated[dict[str, Term], Field(max_length=MAX_TABLES)] = Field(default_factory=dict)
    mu: Term | None = None
    initial: dict[str, Number] = Field(default_factory=dict)
    horizon: Positive


class FlutterTable(Section):
    """The section ``[flutter]``: modes of a structure over the coefficient of friction.

    Attributes
    ----------
    mu
        Range of the coefficient.
    modes
        How many modes are followed, those of the lowest frequencies.
    near
        Angular frequency near which the modes are, instead of the lowest.
    grid
        Values of the coefficient to begin with.
    """

    mu: Range
    modes: Annotated[int, Field(ge=1, le=200, strict=True)] = 6
    near: Number = 0.0
    grid: Annotated[int, Field(ge=2, le=1000, strict=True)] = 25
