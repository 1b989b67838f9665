"""A program whose parameters were built in as numbers, for other values of these."""

from collections.abc import Mapping
from typing import Any, TypeVar

from symfric.model.names import Key, name_of

Program = TypeVar("Program", bound=Any)


def widened(program: Program, values: Mapping[Key, float]) -> Program | None:
    """Return the program in which the parameters named in `values` may be anything, or None if this one serves.

    It is prepared once and kept as ``program.general``.
    """
    built_in = program.built_in
    for key, value in values.items():
        name = name_of(key)
        if name in built_in and built_in[name] != value:
            break
    else:
        return None
    names = {name_of(k) for k in values}
    if program.general is None or not names <= program.general.varied:
        program.general = program.remade(program.varied | names)
    return program.general
