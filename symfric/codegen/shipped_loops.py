"""The event loops as optimised intermediate code of LLVM, shipped with the package for each family of processors.

To compile a loop from its sources takes numba half a minute. Nearly all of it is spent on the way to the optimised
intermediate code, which is the same for all processors of a family; machine code for the present one takes a second
more. ``python -m symfric.codegen.ship`` writes the files anew, and with ``--check`` compiles the loops and compares
them with the files, bit for bit; one that does not belong to the present sources is not used.
"""

import ast
import hashlib
import json
import lzma
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm

from symfric.codegen.target import target_machine, target_triple

FOLDER = Path(__file__).with_name("shipped")
_OPTIMISATION = 3  # of the machine code, as numba has it
_MAX_UNPACKED = 1 << 28  # bytes
#: What a damaged file leads to.
UNREADABLE = OSError, EOFError, lzma.LZMAError, ValueError, KeyError, TypeError, AttributeError, RuntimeError


def shipped_object(module: str, sources: list[Path]) -> bytes | None:
    """Return the name of a loop's function, a line break, and its machine code; None if none is shipped for it.

    Parameters
    ----------
    module : str
        Of the loop.
    sources : list of Path
        The files from which it is compiled; other sources, another major version of LLVM, or another kind of processor
        or system than those of the shipped file give None.
    """
    try:
        known, bitcode = _read(module)
        if known["made for"] != conditions() or known["sources"] != meaning(sources):
            return None
        function: bytes = known["function"].encode()
        code: bytes = target_machine(_OPTIMISATION).emit_object(llvm.parse_bitcode(bitcode))
    except UNREADABLE:
        return None
    return function + b"\n" + code


def shipped_header(module: str) -> dict[str, Any]:
    """Return what a shipped file says of itself."""
    return _read(module)[0]


def shipped_code(module: str) -> bytes:
    """Return the intermediate code in a shipped file, as bitcode."""
    return _read(module)[1]


def bitcode(text: str) -> bytes:
    """Return intermediate code as bitcode: the same bytes for the same code, whatever process made it."""
    return bytes(llvm.parse_assembly(text).as_bitcode())


def _read(module: str) -> tuple[dict[str, Any], bytes]:
    unpacker = lzma.LZMADecompressor(memlimit=_MAX_UNPACKED)
    content = unpacker.decompress(place(module).read_bytes(), _MAX_UNPACKED)
    if not unpacker.eof:
        raise EOFError(module)
    header, _, code = content.partition(b"\n")
    return json.loads(header), code


def write_shipped(module: str, sources: list[Path], function: str, text: str) -> Path:
    """Write the intermediate code of a loop; return the file.

    Parameters
    ----------
    module, sources
        As `shipped_object` takes them.
    function : str
        Name of the function that is called.
    text : str
        The optimised intermediate code.
    """
    header = {"function": function, "sources": meaning(sources), "made for": conditions(), "made with": compilers()}
    content = json.dumps(header).encode() + b"\n" + bitcode(text)
    FOLDER.mkdir(exist_ok=True)
    place(module).write_bytes(lzma.compress(content, preset=9 | lzma.PRESET_EXTREME))
    return place(module)


def place(module: str) -> Path:
    """Return the file of a loop for the present family of processors."""
    return FOLDER / f"{module}.{platform.machine().lower()}.bc.xz"


def conditions() -> list[str]:
    """Return what the intermediate code depends on besides the sources: LLVM and the kind of system."""
    return [str(llvm.llvm_version_info[0]), target_triple()]


def compilers() -> dict[str, str]:
    """Return the versions that the intermediate code depends on: those of Python and of the compiler packages."""
    python = ".".join(platform.python_version_tuple()[:2])
    return {"python": python, **{name: version(name) for name in ("llvmlite", "numba")}}


def meaning(sources: list[Path]) -> str:
    """Return a key that changes with the statements of source files, not with comments, docstrings and layout."""
    digest = hashlib.sha256()
    for file in sources:
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and _is_text(node.body[:1]):
                node.body = node.body[1:] or [ast.Pass()]
        digest.update(f"{file.stem}\n{_written(tree)}\n".encode())
    return digest.hexdigest()


def _written(node: object) -> str:
    """Return a syntax tree as text, the same in every version of Python: what only later ones have is empty here."""
    if isinstance(node, list):
        return f"[{', '.join(map(_written, node))}]"
    if not isinstance(node, ast.AST):
        return repr(node)
    parts = (f"{name}={_written(value)}" for name, value in ast.iter_fields(node) if value not in (None, []))
    return f"{type(node).__name__}({', '.join(parts)})"


def _is_text(statements: list[ast.stmt]) -> bool:
    """Whether the first of some statements is a docstring."""
    return any(isinstance(s, ast.Expr) and isinstance(getattr(s.value, "value", None), str) for s in statements)
