"""Functions of few numbers, compiled once and evaluated at many points."""

import ctypes

import casadi as ca
import numpy as np

from symfric.codegen.functions import compile_functions

_WORTH = 100  # instructions from which on compiling is worth it
_LONGEST = 40_000  # instructions beyond which compiling takes more than some six seconds


class PointFunction:
    """A CasADi function of numbers with one number as its result, at arrays of points.

    Parameters
    ----------
    function : casadi.Function

    Examples
    --------
    >>> import casadi as ca
    >>> x, y = ca.SX.sym("x"), ca.SX.sym("y")
    >>> PointFunction(ca.Function("sum", [x, y], [x + y]))(np.array([1.0, 2.0]), np.array([3.0, 5.0]))
    array([4., 7.])
    """

    def __init__(self, function: ca.Function) -> None:
        self._function = function
        self._code = None
        if _WORTH <= function.n_instructions() <= _LONGEST:
            self._code = compile_functions([function])
            kind = ctypes.PYFUNCTYPE(None, *((function.n_in() + 1) * [ctypes.c_void_p]))
            self._call = kind(self._code.addresses[function.name()])

    def __call__(self, *places: np.ndarray) -> np.ndarray:
        """Return the values at points whose coordinates are arrays of equal shape."""
        shape = places[0].shape
        rows = [np.ascontiguousarray(place, dtype=float).ravel() for place in places]
        values = np.empty(rows[0].size)
        if self._code is None:
            values[:] = np.array(self._function(*(row[None] for row in rows))).ravel()
            return values.reshape(shape)
        starts, size = [row.ctypes.data for row in rows] + [values.ctypes.data], values.itemsize
        for k in range(values.size):
            self._call(*(start + k * size for start in starts))
        return values.reshape(shape)
