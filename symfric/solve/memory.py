"""Arrays and machine code by their addresses, for compiled code that owns neither."""

from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import carray, njit, types
from numba.extending import intrinsic


def addresses(work: NamedTuple) -> np.ndarray:
    """Return address and shape of every array: one argument crosses into compiled code faster than forty."""
    table = np.zeros((len(work), 4), dtype=np.int64)
    for row, array in zip(table, work, strict=True):
        row[0] = array.ctypes.data
        row[1 : 1 + array.ndim] = array.shape
    return table


@intrinsic
def _real_pointer(typing_context, address):
    """Reinterpret an integer as a pointer to doubles."""

    def generate(context, builder, signature, args):
        return builder.inttoptr(args[0], ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(types.int64), generate


@intrinsic
def _integer_pointer(typing_context, address):
    """Reinterpret an integer as a pointer to 64-bit integers."""

    def generate(context, builder, signature, args):
        return builder.inttoptr(args[0], ir.IntType(64).as_pointer())

    return types.CPointer(types.int64)(types.int64), generate


@njit(nogil=True, inline="always")
def reals(table, k):
    """Return array k of a table as a row of reals."""
    return carray(_real_pointer(table[k, 0]), (table[k, 1],))


@njit(nogil=True, inline="always")
def matrix(table, k):
    """Return array k of a table as a matrix."""
    return carray(_real_pointer(table[k, 0]), (table[k, 1], table[k, 2]))


@njit(nogil=True, inline="always")
def cube(table, k):
    """Return array k of a table as a cube."""
    return carray(_real_pointer(table[k, 0]), (table[k, 1], table[k, 2], table[k, 3]))


@njit(nogil=True, inline="always")
def integers(table, k):
    """Return array k of a table as a row of integers."""
    return carray(_integer_pointer(table[k, 0]), (table[k, 1],))


@njit(nogil=True, inline="always")
def integer_matrix(table, k):
    """Return array k of a table as a matrix of integers."""
    return carray(_integer_pointer(table[k, 0]), (table[k, 1], table[k, 2]))


@intrinsic
def call_code(typing_context, address, a, b, out):
    """Call machine code ``void f(double*, double*, double*)`` at an integer address, from numba."""

    def generate(context, builder, signature, args):
        pointer = ir.DoubleType().as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [pointer] * 3)
        target = builder.inttoptr(args[0], kind.as_pointer())
        builder.call(target, [builder.inttoptr(x, pointer) for x in args[1:]])
        return context.get_dummy_value()

    return types.void(types.int64, types.uintp, types.uintp, types.uintp), generate
