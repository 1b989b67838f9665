"""Load event loops: machine code from the disk cache, else from what the package ships, else compiled by numba.

To load numba and to make it read its own cache takes as long as everything else that a first result needs. A loop gets
nothing but addresses, so that its machine code can be linked and called without numba, as the models' is.
"""

import ctypes
import hashlib
import importlib.util
import logging
import re
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding as llvm

from symfric.codegen.array_table import Table
from symfric.codegen.object_cache import load, store
from symfric.codegen.shipped_loops import content_key, shipped_object
from symfric.codegen.target import link, target_key
from symfric.locks import SYMBOLIC, alone
from symfric.time_limit import untimed

_IMPORT = re.compile(r"^ *from (symfric[\w.]*) import ", re.MULTILINE)
_PACKAGE = Path(__file__).parents[1]
LOOPS = (
    "symfric.solve.loop.entry",
    "symfric.solve.loop.case_loop",
    "symfric.solve.lanes.entry",
    "symfric.solve.exact.oscillator.entry",
    "symfric.solve.exact.record.entry",
)
FOLLOWED = ("symfric.codegen", "symfric.solve")  # packages whose imported modules count as sources too


class Loop(NamedTuple):
    """A compiled event loop.

    Attributes
    ----------
    launch : callable
        ``(table, fresh) -> int``: start from the given values, or continue after a pause, and return a status or code.
    address : int
        Address of its machine code, for `symfric.codegen.loop_calls.call_loop`.
    """

    launch: Callable[[Table, bool], int]
    address: int


_opened: dict[str, tuple[Loop, llvm.ExecutionEngine]] = {}  # keeps the engines alive, and thereby the code


@alone(SYMBOLIC)
def load_loop(module: str, what: str) -> Loop:
    """Return the event loop of a module, from the disk cache, else from what is shipped, else compiled.

    Parameters
    ----------
    module : str
        Its name; it has a function ``launch(address, fresh)`` of two integers, compiled as
        `symfric.codegen.numba_types` says.
    what : str
        Description for the log.

    Returns
    -------
    Loop
    """
    if module not in _opened:
        key = _key(module)
        kept = load(key)
        if kept is None:
            kept = shipped_object(module, sources(module))
            if kept is not None:
                store(key, kept)
        if kept is None:
            logging.getLogger("symfric").info("compiling %s, once for this machine", what)
            with untimed():
                kept = _compiled(module)
            store(key, kept)
        name, _, code = kept.partition(b"\n")
        engine = link(code)
        address = engine.get_function_address(name.decode())
        _opened.setdefault(module, (Loop(_caller(address, what), address), engine))
    return _opened[module][0]


def _compiled(module: str) -> bytes:
    """Compile a loop; return the name of its function and the object code."""
    result = _compile_result(module)
    _, _, (code, _) = result.library.serialize_using_object_code()
    name: bytes = result.fndesc.llvm_func_name.encode()
    return name + b"\n" + bytes(code)


def optimised(module: str) -> tuple[str, str]:
    """Compile a loop; return the name of its function and the optimised intermediate code."""
    result = _compile_result(module)
    return result.fndesc.llvm_func_name, result.library.get_llvm_str()


def _compile_result(module: str) -> Any:
    dispatcher = importlib.import_module(module).launch
    dispatcher.compile("int64(int64, int64)")
    (result,) = dispatcher.overloads.values()
    return result


def _caller(address: int, what: str) -> Callable[[Table, bool], int]:
    """Return a Python function that calls numba's ``int (int64* result, void** reason, int64, int64)``."""
    # declared as pointers, which have the same size and are passed faster
    kind = ctypes.CFUNCTYPE(ctypes.c_int, *(4 * [ctypes.c_void_p]))
    native = kind(address)

    def launch(table: Table, fresh: bool) -> int:
        if native(table.result, table.trouble, table.address, fresh):
            raise ArithmeticError(f"a division by zero inside {what}")
        return table.answer()

    return launch


def _key(module: str) -> str:
    """Return a key that changes with the sources of the loop, the compilers and the processor."""
    parts = [module, version("numba"), target_key(), sources_key(module)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def sources_key(module: str, followed: tuple[str, ...] = FOLLOWED) -> str:
    """Return a key that changes with the sources of a module."""
    return content_key(sources(module, followed))


def sources(module: str, followed: tuple[str, ...] = FOLLOWED) -> list[Path]:
    """Return the files of a module and of its imports, direct or through modules of the layers `followed`."""
    files: dict[str, Path] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in files or (path := _file_of(name)) is None:
            continue
        files[name] = path
        if name.startswith(followed) or name == module:
            waiting += _IMPORT.findall(path.read_text(encoding="utf-8"))
    return [files[name] for name in sorted(files)]


def _file_of(module: str) -> Path | None:
    """Return the file of a module, None for a package."""
    if not module.startswith("symfric."):
        spec = importlib.util.find_spec(module)
        return Path(spec.origin) if spec and spec.origin else None
    path = _PACKAGE.joinpath(*module.split(".")[1:]).with_suffix(".py")
    return path if path.is_file() else None
