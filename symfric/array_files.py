"""The format .npy of NumPy, for files from elsewhere: a header is checked against its data before memory is taken."""

import ast
import math
import re
import struct

import numpy as np

from symfric.errors import SceneError

_MAGIC = b"\x93NUMPY"
_LENGTH = {b"\x01\x00": "<H", b"\x02\x00": "<I", b"\x03\x00": "<I"}  # of the header, by version
_MAX_HEADER = 1 << 16
_PLAIN = re.compile(r"[<>=|]?([biufcSU])(\d{1,9})")
_KEYS = {"descr", "fortran_order", "shape"}
_MAX_FIELDS = 1000


def array_of(data: bytes, what: str) -> np.ndarray:
    """Return the array in the content of a .npy file, read-only.

    Parameters
    ----------
    data : bytes
    what : str
        For messages.

    Raises
    ------
    SceneError
        If it is of Python objects, which are not read, or its header disagrees with its length.
    """
    form = _LENGTH.get(data[6:8]) if data.startswith(_MAGIC) else None
    if form is None:
        raise SceneError(f"{what} is no array of NumPy; write it with numpy.save")
    begin = 8 + struct.calcsize(form)
    length = struct.unpack_from(form, data.ljust(begin, b"\xff"), 8)[0]
    head = data[begin : begin + length]
    begin += length
    if length > _MAX_HEADER or len(head) < length:
        raise SceneError(f"{what} ends inside its header; write it anew")
    try:
        said = ast.literal_eval(head.decode("utf-8").strip())
    except (ValueError, SyntaxError, MemoryError, RecursionError, TypeError):
        said = None
    if not isinstance(said, dict) or set(said) != _KEYS or not _is_shape(said["shape"]):
        raise SceneError(f"{what} has a header that cannot be read; write it anew")
    kind, shape = _kind(said["descr"], what), said["shape"]
    if begin + math.prod(shape) * kind.itemsize != len(data):
        raise SceneError(
            f"{what} has {len(data) - begin} bytes, and its header says {str(shape)[:60]} of {kind.itemsize} bytes "
            "each; write it anew"
        )
    return np.frombuffer(data, kind, math.prod(shape), begin).reshape(
        shape, order="F" if said["fortran_order"] else "C"
    )


def _is_shape(shape: object) -> bool:
    return isinstance(shape, tuple) and len(shape) <= 8 and all(type(e) is int and 0 <= e < 2**62 for e in shape)


def _kind(said: object, what: str) -> np.dtype:
    """Return the type of an array: numbers, text, or a row of named ones."""
    named = isinstance(said, list)
    fields = said if isinstance(said, list) else [("", said)]
    known = [(str(f[0]), str(f[1])) for f in fields[:_MAX_FIELDS] if isinstance(f, tuple) and len(f) == 2]
    matches = [_PLAIN.fullmatch(kind) for _, kind in known]
    try:
        if known and len(known) == len(fields) and all(m is not None and int(m[2]) for m in matches):
            return np.dtype(known) if named else np.dtype(known[0][1])
    except (TypeError, ValueError):  # a size that no number has, or a name twice
        pass
    raise SceneError(f"{what} is no array of numbers or names (Python objects are not read); save it as such")
