"""LLVM target machine of this processor, and linking of objects into this process."""

import ctypes
import ctypes.util
import sys
from functools import cache

import llvmlite
import llvmlite.binding as llvm

# C library functions that machine code may call
_MATHEMATICS = (
    *("exp", "log", "pow", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh"),
    *("atanh", "atan2", "fmin", "fmax", "expm1", "log1p", "hypot", "erf", "floor", "ceil"),
)


def target_machine(opt: int) -> llvm.TargetMachine:
    """Return an LLVM target machine for this processor."""
    _prepare()
    cpu, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    return llvm.Target.from_default_triple().create_target_machine(opt=opt, cpu=cpu, features=features)


def family_machine(family: str, opt: int) -> llvm.TargetMachine:
    """Return an LLVM target machine for all processors of a family, by the name that LLVM has for it."""
    _prepare()
    return llvm.Target.from_default_triple().create_target_machine(opt=opt, cpu=family, features="")


def processor_features() -> frozenset[str]:
    """Return what this processor can do, by the names that LLVM has for it."""
    _prepare()
    return frozenset(name for name, has in llvm.get_host_cpu_features().items() if has)


@cache
def target_key() -> str:
    """Return the part of the cache key that identifies LLVM and the processor."""
    _prepare()
    features = llvm.get_host_cpu_features().flatten()
    return "\n".join([llvmlite.__version__, target_triple(), llvm.get_host_cpu_name(), features])


def target_triple() -> str:
    """Return processor, vendor and system for which code is made."""
    _prepare()
    return str(llvm.get_default_triple())


def link(code: bytes) -> llvm.ExecutionEngine:
    """Link an object; return the engine, during whose lifetime the addresses of its functions are valid."""
    # every engine owns its target machine, so each gets one of its own
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target_machine(opt=2))
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine


@cache
def _prepare() -> None:
    """Initialise LLVM and register the addresses of C library functions, which it does not find on every system."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    if sys.platform == "win32":
        library = ctypes.CDLL("ucrtbase")
    else:
        library = ctypes.CDLL(ctypes.util.find_library("m") or None)
    for name in _MATHEMATICS:
        llvm.add_symbol(name, ctypes.cast(getattr(library, name), ctypes.c_void_p).value)
