"""Functions that take long to write, kept on disk beside machine code, so that a second process only reads them."""

import hashlib
import json
import zlib
from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca

from symfric.codegen.columns import WithColumns
from symfric.codegen.llvm_ir import Written
from symfric.codegen.object_cache import load, store

Kept = Mapping[str, Any]  # functions of CasADi, with columns or without, or what JSON can hold
_FORMAT = 1  # version of the files, part of their key
_FAST = 1  # level of compression


def kept(key: str, make: Callable[[], Kept]) -> Kept:
    """Return what `make` returns, from the disk cache if it is there.

    Parameters
    ----------
    key : str
        Of all that the functions are written from.
    make : callable
        Returns functions, numbers, texts and lists of these by name; a `Written` function among them is not kept, nor
        what stands beside it.

    Returns
    -------
    dict
        By name, with the same bits; tuples become lists.
    """
    parts = [str(_FORMAT), ca.CasadiMeta.version(), key]
    name = hashlib.sha256("\n".join(parts).encode()).hexdigest()
    stored = load(name)
    if stored is not None:
        return {k: _read(v) for k, v in json.loads(zlib.decompress(stored)).items()}
    made = make()
    if any(isinstance(v, Written) for v in made.values()):
        return made
    store(name, zlib.compress(json.dumps({k: _written(v) for k, v in made.items()}).encode(), _FAST))
    return made


def _written(value: Any) -> Any:
    if isinstance(value, ca.Function):
        return {"casadi": value.serialize()}
    return {"columns": value.to_dict()} if isinstance(value, WithColumns) else value


def _read(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    return ca.Function.deserialize(value["casadi"]) if "casadi" in value else WithColumns.from_dict(value["columns"])
