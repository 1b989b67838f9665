"""Calls of a compiled event loop from compiled code."""

from typing import Any

from llvmlite import ir
from numba import types

from symfric.codegen.numba_types import inlined

FAILED = -100  # result of `call_loop` if the loop divided by zero; neither a status nor a code to call again


@inlined
def call_loop(typing_context: Any, loop: Any, result: Any, trouble: Any, table: Any, fresh: Any) -> Any:
    """Call numba's ``int (int64* result, void** reason, int64 table, int64 fresh)`` at an integer address.

    Return the result of the loop, or `FAILED`.
    """

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        word = ir.IntType(64)
        kind = ir.FunctionType(ir.IntType(32), [word.as_pointer(), word.as_pointer(), word, word])
        target = builder.inttoptr(args[0], kind.as_pointer())
        place = builder.inttoptr(args[1], word.as_pointer())
        reason = builder.inttoptr(args[2], word.as_pointer())
        state = builder.call(target, [place, reason, args[3], args[4]])
        wrong = builder.icmp_signed("!=", state, ir.Constant(ir.IntType(32), 0))
        return builder.select(wrong, ir.Constant(word, FAILED), builder.load(place))

    return types.int64(*(5 * [types.int64])), generate
