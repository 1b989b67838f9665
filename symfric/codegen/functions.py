"""Compile straight-line CasADi SX functions to machine code by LLVM, without a C compiler.

A function with one or more dense inputs becomes ``void f(double* in_0, ..., double* out_0, ...)``. Objects are kept on
disk under a hash of their instructions and of the processor, so that a second process only loads them.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import llvmlite.binding as llvm

from symfric.codegen.llvm_ir import Written, assembly
from symfric.codegen.object_cache import load, store
from symfric.codegen.target import link, target_key, target_machine
from symfric.locks import SYMBOLIC, alone

_FORMAT = 5  # version of the generated code, part of the cache key


@dataclass(frozen=True)
class MachineCode:
    """Compiled functions; their addresses are valid as long as this object lives.

    Attributes
    ----------
    addresses : dict of str to int
        By function name.
    cached : bool
        Whether the code was loaded from the cache.
    """

    addresses: dict[str, int]
    cached: bool
    _engine: object


@alone(SYMBOLIC)
def compile_functions(functions: Sequence[ca.Function | Written]) -> MachineCode:
    """Compile SX functions into one object, or load it from the cache.

    Raises
    ------
    SceneError
        If an operation has no machine-code translation; named.
    """
    key = _key(functions)
    code = load(key)
    cached = code is not None
    if code is None:
        code = target_machine(opt=2).emit_object(llvm.parse_assembly(assembly(functions)))
        store(key, code)
    engine = link(code)
    return MachineCode({f.name(): engine.get_function_address(f.name()) for f in functions}, cached, engine)


def _key(functions: Sequence[ca.Function | Written]) -> str:
    parts = [str(_FORMAT), target_key(), *(f.serialize() for f in functions)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
