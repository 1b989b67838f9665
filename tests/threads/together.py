"""Calls from several threads at once, and comparison of whatever they return, bit for bit."""

import dataclasses
import sys
import threading
from collections.abc import Mapping

import casadi as ca
import numpy as np
import sympy as sp

import symfric as sf

THREADS = 4


def together(work, threads=THREADS):
    """Call work(k) in every thread k at the same moment; return the results, or raise the first failure."""
    found, start, interval = [None] * threads, threading.Barrier(threads), sys.getswitchinterval()

    def run(k):
        start.wait()
        try:
            found[k] = work(k)
        except BaseException as failure:
            found[k] = failure

    crew = [threading.Thread(target=run, args=(k,)) for k in range(threads)]
    sys.setswitchinterval(1e-6)
    try:
        for thread in crew:
            thread.start()
        for thread in crew:
            thread.join()
    finally:
        sys.setswitchinterval(interval)
    for failure in found:
        if isinstance(failure, BaseException):
            raise failure
    return found


def difference(a, b, place=""):
    """Return where two results differ, and how; empty if they are the same to the last bit."""
    if type(a) is not type(b):
        return f"{place}: {type(a).__name__} and {type(b).__name__}"
    if isinstance(a, sf.Run):
        names = ["final", "t_final", "status", "stats", "outputs", *(["t", "x", "mode"] if a.raw.path else [])]
        return _first(difference(getattr(a, n), getattr(b, n), f"{place}.{n}") for n in names)
    if isinstance(a, np.ndarray):
        same = a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()
        return "" if same else f"{place}: {a} and {b}"
    if isinstance(a, float | complex | np.generic):
        return difference(np.array(a), np.array(b), place)
    if isinstance(a, sp.Basic | sp.MatrixBase):
        return "" if a == b else f"{place}: {a} and {b}"
    if isinstance(a, Mapping):
        keys = "" if list(a) == list(b) else f"{place}: {list(a)} and {list(b)}"
        return keys or _first(difference(a[k], b[k], f"{place}[{k!r}]") for k in a)
    if isinstance(a, tuple | list):
        length = "" if len(a) == len(b) else f"{place}: {len(a)} and {len(b)} entries"
        return length or _first(difference(x, y, f"{place}[{k}]") for k, (x, y) in enumerate(zip(a, b, strict=True)))
    if isinstance(a, ca.DM):
        return difference(np.array(a), np.array(b), place)
    if dataclasses.is_dataclass(a):
        names = [f.name for f in dataclasses.fields(a)]
        return _first(difference(getattr(a, n), getattr(b, n), f"{place}.{n}") for n in names)
    if hasattr(a, "to_xarray") or hasattr(a, "identical"):
        a, b = (e if hasattr(e, "identical") else e.to_xarray() for e in (a, b))
        return "" if a.identical(b) else f"{place}: two data sets"
    if callable(a):
        return ""
    return "" if a == b else f"{place}: {a!r} and {b!r}"


def _first(differences):
    return next(filter(None, differences), "")
