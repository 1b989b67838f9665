"""Ground motions of a scene file, as the file gives them."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, ConfigDict

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


Ground = Annotated[MotionTable, BeforeValidator(_path_as_table)]
