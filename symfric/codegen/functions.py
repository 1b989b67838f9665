"""Compile straight-line CasADi SX functions to machine code by LLVM, without a C compiler.

A function with one or more dense inputs becomes ``void f(double* in_0, ..., double* out_0, ...)``. Objects are kept on
disk under a hash of their instructions and of the processor, so that a second process only loads them.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import llvmlite.binding as llvm

from symfric.codegen.llvm_ir import Drafted, Written, assembly
from symfric.codegen.object_cache import load, store
from symfric.codegen.target import link, target_key, target_machine
from symfric.locks import SYMBOLIC, alone

_LONG = 4000  # instructions of a function that is called seldom, beyond which compiling takes longer than it saves
Code = ca.Function | Written | Drafted
_FORMAT = 7  # version of the generated code, part of the cache key


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
def compile_functions(functions: Sequence[Code], rare: Sequence[ca.Function] = ()) -> MachineCode:
    """Compile SX functions into one object, or load it from the cache.

    Parameters
    ----------
    functions : sequence of Function, Written or Drafted
    rare : sequence of Function
        Others that are called seldom; long ones among them are compiled fast instead of made fast.

    Raises
    ------
    SceneError
        If an operation has no machine-code translation; named.
    """
    long = [f for f in rare if f.n_instructions() > _LONG]
    first: list[Code] = [*functions, *(f for f in rare if f.n_instructions() <= _LONG)]
    groups: list[tuple[Sequence[Code], int]] = [(first, 2), *([(long, 0)] if long else [])]
    addresses: dict[str, int] = {}
    cached, engines = True, []
    for group, opt in groups:
        key = _key(group)
        code = load(key)
        if code is None:
            text = assembly([f.write() if isinstance(f, Drafted) else f for f in group])
            code = target_machine(opt=opt).emit_object(llvm.parse_assembly(text))
            store(key, code)
            cached = False
        engine = link(code)
        addresses |= {f.name(): engine.get_function_address(f.name()) for f in group}
        engines.append(engine)
    return MachineCode(addresses, cached, engines)


def _key(functions: Sequence[Code]) -> str:
    parts = [str(_FORMAT), target_key(), *(f.serialize() for f in functions)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
