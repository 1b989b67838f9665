"""The event loops, shipped with the package for each family of processors as code that is made already.

To compile a loop from its sources takes numba half a minute. Nearly all of it is spent on the way to the optimised
intermediate code of LLVM, which is the same for all processors of a family; machine code for the present one takes some
seconds more. So there is a file of intermediate code, for every system and version of LLVM that reads it, and beside it
one of machine code that any processor of the family runs, for the system on which it was made. ``python -m
symfric.codegen.ship`` writes the files anew, and with ``--check`` compiles the loops and compares them with the files,
bit for bit; one that does not belong to the present sources is not used.
"""

import ast
import hashlib
import json
import lzma
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding as llvm

from symfric.codegen.target import family_machine, processor_features, target_machine, target_triple

FOLDER = Path(__file__).with_name("shipped")
_OPTIMISATION = 3  # of the machine code, as numba has it
_MAX_UNPACKED = 1 << 28  # bytes
#: What a damaged file leads to.
UNREADABLE = OSError, EOFError, lzma.LZMAError, ValueError, KeyError, TypeError, AttributeError, RuntimeError


class Family(NamedTuple):
    """Processors that run the same machine code.

    Attributes
    ----------
    name : str
        In LLVM.
    needs : frozenset of str
        What each of them can do, by the names that LLVM has for it.
    """

    name: str
    needs: frozenset[str]


_V2 = frozenset({"cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3"})
_V3 = Family("x86-64-v3", _V2 | {"avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave"})
_FAMILIES = {"x86_64": _V3, "amd64": _V3}


def family() -> Family | None:
    """Return the family for which this machine makes files; None if there is none."""
    return _FAMILIES.get(platform.machine().lower())


def shipped_object(module: str, sources: list[Path]) -> bytes | None:
    """Return the name of a loop's function, a line break, and its machine code; None if none is shipped for it.

    Parameters
    ----------
    module : str
        Of the loop.
    sources : list of Path
        The files from which it is compiled. Where they are others than those of the shipped files, or the processor or
        system is of another kind, the result is None; also where there is no machine code for it and the intermediate
        code is of another major version of LLVM.
    """
    for read in (_machine_code, _compiled_code):
        try:
            known, code = read(module, sources)
        except UNREADABLE:
            continue
        return known["function"].encode() + b"\n" + code
    return None


def _machine_code(module: str, sources: list[Path]) -> tuple[dict[str, Any], bytes]:
    """Return header and machine code of a file of machine code."""
    known, code = _read(machine_code_place(module))
    own = family()
    if own is None or known["made for"] != machine_conditions(own) or not own.needs <= processor_features():
        raise ValueError("for other processors")
    _check_sources(known, sources)
    return known, code


def _compiled_code(module: str, sources: list[Path]) -> tuple[dict[str, Any], bytes]:
    """Return the header of a file of intermediate code, and the machine code for this processor."""
    known, code = _read(place(module))
    if known["made for"] != conditions():
        raise ValueError("for another system")
    _check_sources(known, sources)
    return known, target_machine(_OPTIMISATION).emit_object(llvm.parse_bitcode(code))


def _check_sources(known: dict[str, Any], sources: list[Path]) -> None:
    """Raise ValueError if a file was made from other sources; to compare their bytes is faster than their meaning."""
    if known.get("bytes") != content_key(sources) and known["sources"] != meaning(sources):
        raise ValueError("of other sources")


def content_key(sources: list[Path]) -> str:
    """Return a key that changes with every byte of source files."""
    return hashlib.sha256(b"".join(f.read_bytes() for f in sources)).hexdigest()


def shipped_header(module: str) -> dict[str, Any]:
    """Return what a shipped file of intermediate code says of itself."""
    return _read(place(module))[0]


def shipped_code(module: str) -> bytes:
    """Return the intermediate code in a shipped file, as bitcode."""
    return _read(place(module))[1]


def shipped_machine_code(module: str) -> bytes | None:
    """Return the machine code in a shipped file; None where none is made for this system."""
    own = family()
    if own is None:
        return None
    known, code = _read(machine_code_place(module))
    return code if known["made for"] == machine_conditions(own) else None


def bitcode(text: str) -> bytes:
    """Return intermediate code as bitcode: the same bytes for the same code, whatever process made it."""
    return bytes(llvm.parse_assembly(text).as_bitcode())


def for_family(code: bytes, own: Family) -> bytes:
    """Return the machine code that all processors of a family run, from bitcode."""
    return bytes(family_machine(own.name, _OPTIMISATION).emit_object(llvm.parse_bitcode(code)))


def _read(file: Path) -> tuple[dict[str, Any], bytes]:
    unpacker = lzma.LZMADecompressor(memlimit=_MAX_UNPACKED)
    content = unpacker.decompress(file.read_bytes(), _MAX_UNPACKED)
    if not unpacker.eof:
        raise EOFError(file.name)
    header, _, code = content.partition(b"\n")
    return json.loads(header), code


def write_shipped(module: str, sources: list[Path], function: str, text: str) -> list[Path]:
    """Write the code of a loop; return the files.

    Parameters
    ----------
    module, sources
        As `shipped_object` takes them.
    function : str
        Name of the function that is called.
    text : str
        The optimised intermediate code.
    """
    made_from = {"function": function, "sources": meaning(sources), "bytes": content_key(sources)}
    code = bitcode(text)
    files = [_written_file(place(module), {**made_from, "made for": conditions()}, code)]
    own = family()
    if own is not None:
        header = {**made_from, "made for": machine_conditions(own)}
        files.append(_written_file(machine_code_place(module), header, for_family(code, own)))
    return files


def renewed(module: str, sources: list[Path]) -> bool:
    """Whether the files of a loop hold what its sources give still; they learn the bytes of the sources then.

    Parameters
    ----------
    module, sources
        As `shipped_object` takes them; comments, docstrings and layout may be others than those of the files.
    """
    own, files = family(), {place(module): conditions()}
    if own is not None:
        files[machine_code_place(module)] = machine_conditions(own)
    present = {"sources": meaning(sources), "made with": compilers()}
    try:
        read = [(file, *_read(file)) for file in files]
    except UNREADABLE:
        return False
    if any(known | present | {"made for": files[file]} != known for file, known, _ in read):
        return False
    for file, known, code in read:
        _written_file(file, {**known, "bytes": content_key(sources)}, code)
    return True


def _written_file(file: Path, known: dict[str, Any], code: bytes) -> Path:
    content = json.dumps({**known, "made with": compilers()}).encode() + b"\n" + code
    file.parent.mkdir(exist_ok=True)
    file.write_bytes(lzma.compress(content, preset=9 | lzma.PRESET_EXTREME))
    return file


def place(module: str) -> Path:
    """Return the file of a loop's intermediate code for the present family of processors."""
    return FOLDER / f"{module}.{platform.machine().lower()}.bc.xz"


def machine_code_place(module: str) -> Path:
    """Return the file of a loop's machine code for the present family of processors."""
    return FOLDER / f"{module}.{platform.machine().lower()}.o.xz"


def conditions() -> list[str]:
    """Return what the intermediate code depends on besides the sources: LLVM and the kind of system."""
    return [str(llvm.llvm_version_info[0]), target_triple()]


def machine_conditions(own: Family) -> list[str]:
    """Return what machine code depends on besides the sources: the family of processors and the kind of system."""
    return [own.name, target_triple()]


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
