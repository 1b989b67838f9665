"""Compiled event loops, kept on disk as machine code; numba is loaded only where one has to be compiled.

To load numba and to make it read its own cache takes as long as everything else that a first result needs. A loop gets
nothing but addresses, so that its machine code can be linked and called without numba, as the models' is.
"""

import ctypes
import hashlib
import importlib
import logging
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import llvmlite.binding as llvm

from symfric.codegen.array_table import Table
from symfric.codegen.object_cache import load, store
from symfric.codegen.target import link, target_key
from symfric.locks import SYMBOLIC, alone

# sources of all loops, beside those in their folders
_SHARED = (
    *("door.py", "memory.py", "native.py", "status.py", "wanted.py"),
    *("../lower/automaton.py", "../lower/edges.py", "../lower/holding.py"),
)
_opened: dict[str, tuple[Callable[[Table, bool], int], llvm.ExecutionEngine]] = {}  # code lives as long as its engine


@alone(SYMBOLIC)
def open_door(module: str, what: str, *folders: Path) -> Callable[[Table, bool], int]:
    """Return the event loop of a module, loaded from the disk or compiled and kept there.

    Parameters
    ----------
    module : str
        Its name; it has a function ``launch(address, fresh)`` of two integers, compiled as
        `symfric.codegen.numba_types` says.
    what : str
        What is compiled, for the log.
    *folders : Path
        Of the sources that the loop is made from.

    Returns
    -------
    callable
        ``(table, fresh) -> int``: start with what is given, or go on after a pause, and return why it stopped.
    """
    if module not in _opened:
        key = _key(module, folders)
        kept = load(key)
        if kept is None:
            logging.getLogger("symfric").info("compiling %s, once for this machine", what)
            kept = _compiled(module)
            store(key, kept)
        name, _, code = kept.partition(b"\n")
        engine = link(code)
        _opened.setdefault(module, (_caller(engine.get_function_address(name.decode()), what), engine))
    return _opened[module][0]


def _compiled(module: str) -> bytes:
    """Return the name of a loop's function and the object that holds it."""
    dispatcher = importlib.import_module(module).launch
    dispatcher.compile("int64(int64, int64)")
    (result,) = dispatcher.overloads.values()
    _, _, (code, _) = result.library.serialize_using_object_code()
    return result.fndesc.llvm_func_name.encode() + b"\n" + code


def _caller(address: int, what: str) -> Callable[[Table, bool], int]:
    """Return a Python function that calls numba's ``int (int64* result, void** reason, int64, int64)``."""
    kind = ctypes.CFUNCTYPE(ctypes.c_int, *(4 * [ctypes.c_void_p]))  # pointers pass more quickly, and are as long
    native = kind(address)

    def launch(table: Table, fresh: bool) -> int:
        if native(table.result, table.trouble, table.address, fresh):
            raise ArithmeticError(f"a division by zero inside {what}")
        return table.answer()

    return launch


def _key(module: str, folders: tuple[Path, ...]) -> str:
    """Return a key that changes with any source that the loop is made from, with the compilers and the processor."""
    parts = [module, version("numba"), target_key(), sources_key(*folders)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def sources_key(*folders: Path) -> str:
    """Return a key that changes with the sources of the compiled loops and with those in the folders."""
    return hashlib.sha256(b"".join(f.read_bytes() for f in sources(*folders))).hexdigest()


def sources(*folders: Path) -> list[Path]:
    """Return the files that `sources_key` reads."""
    shared = [(Path(__file__).parent / name).resolve() for name in _SHARED]
    return [*shared, *(f.resolve() for folder in folders for f in sorted(folder.glob("*.py")))]
