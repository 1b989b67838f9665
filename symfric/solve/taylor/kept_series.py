"""Taylor series that an earlier process has written, from the disk cache."""

from dataclasses import fields
from functools import cache

import casadi as ca

from symfric.codegen.kept_functions import kept
from symfric.codegen.loop_loader import sources_key
from symfric.solve.loop.stepping.series import Series
from symfric.solve.taylor.expansion import expand


def kept_series(field: ca.Function, order: int, suffix: str = "") -> Series:
    """Return what `expand` does, with the same bits, in a small part of the time if the series is in the disk cache."""

    def make() -> dict[str, object]:
        series = expand(field, order, suffix)
        return {f.name: getattr(series, f.name) for f in fields(series)}

    found = kept(f"{_written_by()} {order} {suffix} {field.serialize()}", make)
    return Series(**{**found, "exposed": tuple(found["exposed"])})


@cache
def _written_by() -> str:
    """Return a key of the sources that write series."""
    return sources_key("symfric.solve.taylor.expansion")
