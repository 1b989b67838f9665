"""Ground motions of a scene file, as the file gives them."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, ConfigDict, Discriminator, Tag

from symfric.fields import Option, Section, Text


class MotionTable(Section):
    """A ground motion: the path of a record, or ``kind`` with the arguments of a function in ``sf.motions``.

    Attributes
    ----------
    file
        Path of a record in the format AT2.
    kind
        Maker of an artificial motion; its arguments are further keys.
    """

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, Option]

    file: Text | None = None
    kind: Literal["synthetic", "sine_burst"] | None = None


def _path_as_table(value: object) -> object:
    """Convert the path of a record to a table."""
    return {"file": value} if isinstance(value, str) else value


def _two(value: object) -> object:
    """Return a list of two motions, or raise."""
    if isinstance(value, list) and len(value) != 2:
        raise ValueError(f"has {len(value)} motions; a pair has two, along x and along y")
    return value


def _one_or_two(value: object) -> str:
    """Return the tag of a motion or of a pair of motions."""
    return PAIR if isinstance(value, list | tuple) else ONE


ONE, PAIR = "<one>", "<pair>"  # tags, which are no keys: the messages of `symfric.scenefile.sections` leave them out
Ground = Annotated[MotionTable, BeforeValidator(_path_as_table)]
Pair = Annotated[tuple[Ground, Ground], BeforeValidator(_two)]
GroundOrPair = Annotated[Annotated[Ground, Tag(ONE)] | Annotated[Pair, Tag(PAIR)], Discriminator(_one_or_two)]
