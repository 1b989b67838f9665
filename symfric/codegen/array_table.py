"""Arrays by their addresses, for compiled code that does not own them.

Compiled code knows the arrays of a NamedTuple as one pointer, to the table of their addresses, and reads from it what
it uses. Forty arrays passed from function to function would be three hundred numbers for the compiler to keep track of.
"""

from typing import Annotated, NamedTuple

import numpy as np

# annotations of the fields: kind and number of their indices are part of compiled code
Reals = Annotated[np.ndarray, (float, 1)]
Matrix = Annotated[np.ndarray, (float, 2)]
Cube = Annotated[np.ndarray, (float, 3)]
Integers = Annotated[np.ndarray, (int, 1)]
IntegerMatrix = Annotated[np.ndarray, (int, 2)]

WIDTH = 4  # of the table: address and shape
WORD = 8  # bytes of every number


class Table:
    """Address and shape of every array of a NamedTuple, one row for each, and room for the result of a call.

    Attributes
    ----------
    address, result, trouble : int
        Where the table begins, and where compiled code may leave its result and the reason of a failure. Valid as long
        as this object and the arrays live.
    """

    def __init__(self, work: NamedTuple):
        self._rows = np.zeros((len(work) + 1, WIDTH), dtype=np.int64)
        for row, array in zip(self._rows, work, strict=False):
            row[0] = array.ctypes.data
            row[1 : 1 + array.ndim] = array.shape
        self.address = self._rows.ctypes.data
        self.result = self.address + self._rows.nbytes - WIDTH * WORD
        self.trouble = self.result + WORD
        self._place = self._rows.size - WIDTH

    def answer(self) -> int:
        """Return the result of the last call."""
        return self._rows.item(self._place)
