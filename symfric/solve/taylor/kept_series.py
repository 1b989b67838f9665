"""Taylor series that were made before: by this process, for one of its last scenes, or by an earlier one."""

from dataclasses import fields
from functools import cache, lru_cache

import casadi as ca

from symfric.codegen.kept_functions import kept
from symfric.codegen.loop_loader import sources_key
from symfric.solve.loop.stepping.series import Series
from symfric.solve.taylor import expansion

_SCENES = 8  # scenes whose series are kept in memory: those of the same equations with other numbers share them


def kept_series(field: ca.Function, order: int, suffix: str = "") -> Series:
    """Return what `expand` does, with the same bits, in a small part of the time if it was made before."""
    return _kept(field.serialize(), order, suffix, expansion.LONG)


@lru_cache(maxsize=_SCENES)
def _kept(field: str, order: int, suffix: str, longest: int) -> Series:
    """Return the series of a field given as text, in which equal fields are the same."""

    def make() -> dict[str, object]:
        series = expansion.expand(ca.Function.deserialize(field), order, suffix)
        return {f.name: getattr(series, f.name) for f in fields(series)}

    found = kept(f"{_written_by()} {order} {longest} {suffix} {field}", make)
    return Series(**{**found, "exposed": tuple(found["exposed"])})


@cache
def _written_by() -> str:
    """Return a key of the sources that write series."""
    return sources_key("symfric.solve.taylor.expansion")
