"""Values that vary over many cases of one scene, read as a user gives them."""

import os
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from symfric.errors import SceneError
from symfric.model.symbols import Key, finite, name_of

NOT_COMPUTED = -3  # code of a case that was not reached, besides those of Status


class CaseValues(NamedTuple):
    """Values and starts that vary from case to case.

    Attributes
    ----------
    size : int
    values, initial : dict of str to ndarray or float
        By name: rows (n,), or a number for all cases.
    """

    size: int
    values: dict[str, Any]
    initial: dict[str, Any]

    def some(self, chosen: np.ndarray) -> "CaseValues":
        """Return some of the cases."""
        parts = ({n: v if isinstance(v, float) else v[chosen] for n, v in d.items()} for d in self[1:])
        return CaseValues(int(np.count_nonzero(chosen)), *parts)

    def of(self, k: int) -> tuple[dict[str, float], dict[str, float]]:
        """Return values and starts of one case."""
        values, initial = ({n: v if isinstance(v, float) else float(v[k]) for n, v in d.items()} for d in self[1:])
        return values, initial

    def given(self) -> dict[str, np.ndarray]:
        """Return every value and start as a row (n,)."""
        return {n: np.full(self.size, v, dtype=float) for n, v in (self.values | self.initial).items()}


def read_cases(values: Mapping[Key, Any] | None, initial: Mapping[Key, Any] | None) -> CaseValues:
    """Read numbers and rows of numbers by name.

    Raises
    ------
    SceneError
        If something is no finite number, rows have different lengths, or a name is given twice.
    """
    both: list[dict[str, Any]] = []
    lengths: dict[str, int] = {}
    for given, of in ((values, "values"), (initial, "initial values")):
        own: dict[str, Any] = {}
        if given is not None and not isinstance(given, Mapping):
            raise SceneError(f"the {of} are {given!r}; give a mapping of names to numbers or rows of numbers")
        for key, value in (given or {}).items():
            name = name_of(key)
            if name in own:
                raise SceneError(f"{name} is given twice in the {of}, as a symbol and by name")
            own[name] = _row(value, name)
            if not isinstance(own[name], float):
                lengths[name] = own[name].size
        both.append(own)
    sizes = set(lengths.values()) - {1} or set(lengths.values()) or {1}
    if len(sizes) > 1:
        told = ", ".join(f"{name} has {size}" for name, size in lengths.items())
        raise SceneError(f"the rows have different lengths: {told}; give rows of the same length, or single numbers")
    (size,) = sizes
    return CaseValues(size, *({n: _repeated(v, size) for n, v in rows.items()} for rows in both))


def _row(value: Any, name: str) -> Any:
    """Return a number as a float, or a row of numbers as an array (n,)."""
    if isinstance(value, str | bytes) or np.ndim(value) == 0:
        return finite(value.item() if isinstance(value, np.ndarray | np.generic) else value, "the value of ", name)
    row = np.asarray(value)
    if row.dtype == object:
        row = np.array([finite(v, f"value {k} of ", name) for k, v in enumerate(row.ravel())]).reshape(row.shape)
    if row.ndim != 1:
        raise SceneError(f"the values of {name} have shape {row.shape}; give a row (n,) or one number")
    if row.dtype.kind not in "iuf" and row.size:
        raise SceneError(f"the values of {name} are of type {row.dtype}; give a row of real numbers")
    row = np.ascontiguousarray(row, dtype=float)
    if not np.all(np.isfinite(row)):
        k = int(np.flatnonzero(~np.isfinite(row))[0])
        raise SceneError(f"value {k} of {name} is {row[k]}; it must be finite")
    return row


def _repeated(v: Any, size: int) -> Any:
    return v if isinstance(v, float) or v.size == size else np.repeat(v, size)


def refuse_lists(outputs: Mapping[str, Any]) -> None:
    """Raise if an output keeps a trajectory or a list of events."""
    for name, output in outputs.items():
        if output.keeps_path or output.keeps_events:
            raise SceneError(
                f"output {name!r} is {type(output).__name__}(): `map` keeps neither trajectories nor lists of events; "
                "prepare the scene with scalar outputs, such as scene.wanting({'x_max': sf.Max(x)})"
            )


def workers_of(threads: Any, what: str = "threads") -> int:
    """Return a number of threads; raise if it is none."""
    if isinstance(threads, bool) or not isinstance(threads, int | np.integer) or threads < -1 or threads == 0:
        raise SceneError(f"{what} is {threads!r}; give a positive number of threads, or -1 for all processors")
    return processors() if threads == -1 else int(threads)


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
