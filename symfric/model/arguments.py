"""Checks of arguments that functions of all layers take: counts, seeds, words of a list, paths, objects of a kind."""

from collections.abc import Container, Hashable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from symfric.errors import SceneError
from symfric.model.symbols import shortened

_Kind = TypeVar("_Kind")


def whole(value: Any, name: str, least: int = 1, most: int | None = None) -> int:
    """Return an argument as a whole number within its bounds.

    Parameters
    ----------
    value : int
    name : str
        Of the argument.
    least : int
    most : int, optional

    Raises
    ------
    SceneError
        If it is anything else.
    """
    counts = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if counts and least <= value and (most is None or value <= most):
        return int(value)
    span = f", at least {least}" if most is None else f" from {least} to {most}"
    raise SceneError(f"{name} is {shortened(value)}; give a whole number{span}")


def flag(value: Any, name: str) -> bool:
    """Return an argument that is True or False.

    Parameters
    ----------
    value : bool
    name : str
        Of the argument.

    Raises
    ------
    SceneError
        If it is anything else: a text, a list or a number is a wrong argument, and no yes.
    """
    if not isinstance(value, bool | np.bool_):
        raise SceneError(f"{name} is {shortened(value)}; give True or False")
    return bool(value)


def is_one_of(value: Any, known: Container[Any]) -> bool:
    """Whether an argument is one of a few words or numbers; lists and arrays are none of them.

    Parameters
    ----------
    value : object
    known : container
    """
    return isinstance(value, Hashable) and value in known


def path_of(value: Any, name: str = "path") -> Path:
    """Return an argument as a path.

    Parameters
    ----------
    value : str or Path
    name : str
        Of the argument.
    """
    if not isinstance(value, str | Path):
        raise SceneError(f"{name} is {shortened(value)}; give the path of a file")
    return Path(value)


def instance(value: Any, kind: type[_Kind], name: str) -> _Kind:
    """Return an argument that is an object of a public class, whose name the error shows.

    Parameters
    ----------
    value : object
    kind : type
    name : str
        Of the argument.
    """
    if not isinstance(value, kind):
        raise SceneError(f"{name} is {shortened(value)}; give a {kind.__name__}")
    return value


def items(value: Any, name: str) -> Iterator[Any]:
    """Yield the entries of an argument that is a sequence, but no text and no mapping.

    Parameters
    ----------
    value : sequence
    name : str
        Of the argument.
    """
    if isinstance(value, str) or not np.iterable(value):
        raise SceneError(f"{name} is {shortened(value)}; give a sequence, {name}=[...]")
    yield from value
