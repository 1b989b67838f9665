"""Tables of array addresses, by which compiled code accesses arrays of Python.

Compiled code knows an `ArraySet` as one pointer, to the table of their addresses, and reads from it what
it uses. Forty arrays passed from function to function would be three hundred numbers for the compiler to keep track of.
A set may hold other sets, as records with names: their rows lie within the table of the whole, so that a record of a
record is the same pointer moved by a constant, which costs nothing.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, fields, replace
from typing import Annotated, Any, ClassVar, Self, get_type_hints

import numpy as np

# annotations of the fields: type and number of dimensions are part of compiled code
Reals = Annotated[np.ndarray, (float, 1)]
Matrix = Annotated[np.ndarray, (float, 2)]
Cube = Annotated[np.ndarray, (float, 3)]
Integers = Annotated[np.ndarray, (int, 1)]
IntegerMatrix = Annotated[np.ndarray, (int, 2)]

WIDTH = 4  # width of the table: address and shape
WORD = 8  # bytes per number
VECTOR = 8  # numbers that compiled code takes at once


class Scalars(np.ndarray):
    """Base of records of named numbers of one type, which Python and compiled code access as attributes.

    A subclass lists the names as annotations, and sets ``kind`` to float or int.
    """

    names: ClassVar[tuple[str, ...]] = ()
    kind: ClassVar[type] = float

    def __init_subclass__(cls, kind: type | None = None) -> None:
        cls.names, cls.kind = (*cls.names, *cls.__annotations__), kind or cls.kind
        for place, name in enumerate(cls.names):
            setattr(cls, name, property(*_entry(place)))

    @classmethod
    def zeros(cls) -> Self:
        """Return a record of zeros."""
        return np.zeros(len(cls.names), cls.kind).view(cls)


def _entry(place: int) -> tuple[Callable[[np.ndarray], Any], Callable[[np.ndarray, Any], None]]:
    def get(self: np.ndarray) -> Any:
        return self.item(place)

    def put(self: np.ndarray, value: Any) -> None:
        self[place] = value

    return get, put


@dataclass(frozen=True, eq=False, kw_only=True)
class ArraySet:
    """Base of sets of arrays, and of further sets, for compiled code; annotations of the fields define their types."""

    @classmethod
    def zeros(cls, **shapes: int | tuple[int, ...]) -> Self:
        """Return a set of arrays of zeros, with these shapes."""
        hints = get_type_hints(cls, include_extras=True)
        return cls(**{name: np.zeros(shape, hints[name].__metadata__[0][0]) for name, shape in shapes.items()})

    @classmethod
    def names(cls) -> list[str]:
        """Return the names of the fields in their order."""
        return [f.name for f in fields(cls)]

    def items(self) -> list[tuple[str, Any]]:
        """Return the names of all arrays, with those of their records in front, and the arrays."""
        entries: list[tuple[str, Any]] = []
        for name in self.names():
            value = getattr(self, name)
            inner = value.items() if isinstance(value, ArraySet) else None
            entries += [(name, value)] if inner is None else [(f"{name}.{n}", array) for n, array in inner]
        return entries

    def copy(self, shared: Collection[str] = ()) -> Self:
        """Return a set with copies of all fields but those named in `shared`, which are the same."""
        return replace(self, **{n: getattr(self, n).copy() for n in self.names() if n not in shared})


class Table:
    """Table of address and shape of every array of an `ArraySet`, with memory for the result of a call.

    Attributes
    ----------
    address, result, trouble : int
        Addresses of the table, and of the memory for the result and the reason of a failure. Valid as long
        as this object and the arrays live.
    """

    def __init__(self, work: ArraySet):
        arrays = work.items()
        self._rows = np.zeros((len(arrays) + 1, WIDTH), dtype=np.int64)
        for row, (_, array) in zip(self._rows, arrays, strict=False):
            row[0] = array.ctypes.data
            row[1 : 1 + array.ndim] = array.shape
        self.address = self._rows.ctypes.data
        self.result = self.address + self._rows.nbytes - WIDTH * WORD
        self.trouble = self.result + WORD
        self._place = self._rows.size - WIDTH

    def answer(self) -> int:
        """Return the result of the last call."""
        return self._rows.item(self._place)
