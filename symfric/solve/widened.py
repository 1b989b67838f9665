"""Recompile a program for other values of parameters that were built in as numbers."""

from collections.abc import Mapping
from typing import Any, TypeVar

from symfric.locks import SYMBOLIC
from symfric.model.symbols import Key, name_of

Program = TypeVar("Program", bound=Any)


def widened(program: Program, values: Mapping[Key, float]) -> Program | None:
    """Return a program in which the parameters named in `values` are free, or None if they are free in this one.

    It is prepared once and kept in ``program.wider``, one for every set of names that were built in, so that a run does
    not depend on the runs before it.
    """
    built_in = program.built_in
    for key, value in values.items():
        name = name_of(key)
        if name in built_in and built_in[name] != value:
            break
    else:
        return None
    names = frozenset(map(name_of, values)).intersection(built_in)
    found = program.wider.get(names)
    if found is None:
        with SYMBOLIC:
            found = program.wider.get(names)
            if found is None:
                found = program.wider[names] = program.remade(program.varied | names)
    return found
