"""Taylor series that were made before: by this process, for one of its last scenes, or by an earlier one."""

from dataclasses import fields
from functools import cache, lru_cache

import casadi as ca

from symfric.codegen.kept_functions import kept
from symfric.codegen.loop_loader import sources_key
from symfric.lower.automaton import VariedField
from symfric.solve.loop.stepping.series import Series
from symfric.solve.taylor import expansion

_SCENES = 8  # scenes whose series are kept in memory: those of the same equations with other numbers share them
_Columns = tuple[str, tuple[int, ...], int]  # a `VariedField`, its field as text


def kept_series(field: ca.Function, order: int, suffix: str = "", varied: VariedField | None = None) -> Series:
    """Return what `expand` does, with the same bits, in a small part of the time if it was made before."""
    columns = (varied.field.serialize(), varied.directions, varied.followed) if varied else None
    return _kept(field.serialize(), order, suffix, expansion.LONG, columns)


@lru_cache(maxsize=_SCENES)
def _kept(field: str, order: int, suffix: str, longest: int, columns: _Columns | None) -> Series:
    """Return the series of a field given as text, in which equal fields are the same."""

    def make() -> dict[str, object]:
        varied = VariedField(ca.Function.deserialize(columns[0]), *columns[1:]) if columns else None
        series = expansion.expand(ca.Function.deserialize(field), order, suffix, varied)
        return {f.name: getattr(series, f.name) for f in fields(series)}

    stored = kept(f"{_written_by()} {order} {longest} {suffix} {field} {columns}", make)
    return Series(**{**stored, "exposed": tuple(stored["exposed"])})


@cache
def _written_by() -> str:
    """Return a key of the sources that write series."""
    return sources_key("symfric.solve.taylor.expansion")
