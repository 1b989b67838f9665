"""Compile straight-line CasADi SX functions to machine code by LLVM, without a C compiler.

A function with one or more dense inputs becomes ``void f(double* in_0, ..., double* out_0, ...)``. Objects are kept on
disk under a hash of their instructions and of the processor, so that a second process only loads them.
"""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import casadi as ca
import llvmlite.binding as llvm

from symfric.codegen.llvm_ir import Drafted, Shared, Written, assembly
from symfric.codegen.object_cache import load, store
from symfric.codegen.target import link, target_key, target_machine
from symfric.locks import SYMBOLIC, alone

_LONG = 4000  # instructions of a function that is called seldom, beyond which compiling takes longer than it saves
_MANY = 3000  # instructions of a scene from which on they are compiled fast at first
_SHARED = 2  # level of optimisation of shared functions: they are never compiled again, and long runs need them fast
Code = ca.Function | Written | Drafted
_FORMAT = 9  # version of the generated code, part of the cache key
_provided: dict[tuple[str, ...], object] = {}  # engines of shared functions, by their names


@dataclass(frozen=True)
class MachineCode:
    """Compiled functions; their addresses are valid as long as this object lives.

    Attributes
    ----------
    addresses : dict of str to int
        By function name.
    cached : bool
        Whether the code was loaded from the cache.
    draft : Draft or None
        How it can be made faster, if it was compiled fast.
    """

    addresses: dict[str, int]
    cached: bool
    _engine: object
    draft: "Draft | None" = None


class Draft:
    """Functions that were compiled fast, to be compiled again where that pays; both codes end at the same bits.

    Parameters
    ----------
    functions : sequence of Function, Written or Drafted
    addresses : dict of str to int
        Of the code so far.
    """

    def __init__(self, functions: Sequence[Code], addresses: dict[str, int]) -> None:
        self._functions, self._addresses = functions, addresses
        self._better: MachineCode | None = None

    @alone(SYMBOLIC)
    def improved(self) -> dict[int, int]:
        """Compile for speed, unless that is done; return the new address of every old one."""
        if self._better is None:
            self._better = _made(self._functions, (2,))
        return {old: self._better.addresses[name] for name, old in self._addresses.items()}


def compile_fast() -> None:
    """Compile all code fast at first, in a process most of whose programs run once."""
    global _MANY, _SHARED
    _MANY = _SHARED = 0


@alone(SYMBOLIC)
def compile_functions(functions: Sequence[Code], rare: Sequence[ca.Function] = ()) -> MachineCode:
    """Compile SX functions into one object, or load it from the cache.

    Many instructions are compiled fast, in a sixth of the time, to code that takes 1.3 to 1.7 times as long; their
    `draft` makes it faster.

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
    many = sum(_instructions(f) for f in first) > _MANY
    code = _made(first, (2, 0) if many else (2,))
    if not long:
        return code
    other = _made(long, (0,))
    return MachineCode(code.addresses | other.addresses, code.cached and other.cached, (code, other), code.draft)


def _instructions(f: Code) -> int:
    """Return the number of instructions of a function; zero for a table of them."""
    if isinstance(f, Drafted):
        return f.instructions
    return int(f.n_instructions()) if isinstance(f, ca.Function) else 0


def _made(functions: Sequence[Code], levels: tuple[int, ...]) -> MachineCode:
    """Return machine code of the first of these levels that is in the cache, else of the last; 0 is fast to compile."""
    for shared in {s for f in functions if isinstance(f, Written) for s in f.shared}:
        _provide(shared)
    sources = [f.serialize() for f in functions]
    found = ((level, load(_key([str(level), *sources]))) for level in levels)
    level, code = next(((level, code) for level, code in found if code is not None), (levels[-1], None))
    engine = link(code or _compiled(_key([str(level), *sources]), functions, level))
    addresses = {f.name(): engine.get_function_address(f.name()) for f in functions}
    draft = Draft(functions, addresses) if level != levels[0] else None
    return MachineCode(addresses, code is not None, engine, draft)


def _provide(shared: Shared) -> None:
    """Make shared functions known to all code that is linked later."""
    if shared.names in _provided:
        return
    key = _key([str(_SHARED), shared.key])
    _provided[shared.names] = engine = link(load(key) or _compiled(key, shared.write(), _SHARED))
    for name in shared.names:
        llvm.add_symbol(name, engine.get_function_address(name))


def _compiled(key: str, functions: Sequence[Code], opt: int) -> bytes:
    """Compile functions and keep the code in the cache."""
    text = assembly([f.write() if isinstance(f, Drafted) else f for f in functions])
    code: bytes = target_machine(opt=opt).emit_object(llvm.parse_assembly(text))
    store(key, code)
    return code


def _key(sources: Iterable[str]) -> str:
    return hashlib.sha256("\n".join([str(_FORMAT), target_key(), *sources]).encode()).hexdigest()
