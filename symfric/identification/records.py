"""Measured records: from arrays, xarray or files, and checked; a bad record is one clear line."""

import sys
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.identification.tables import read_table
from symfric.model.scene import Scene
from symfric.model.symbols import expression, mapped, name_of, nearest

GAP = 10.0  # an interval this many times as long as the usual one is a gap
SECONDS = ("", "s", "sec", "second", "seconds")
LONG = 100.0  # a record that lasts this many times the scene's horizon is in another unit of time


@dataclass(frozen=True, eq=False)
class Channel:
    """One measured signal.

    Attributes
    ----------
    scene : str
        Label of the scene that it was measured on, empty if there is one scene only.
    name : str
        Of the record.
    expr : Expr
        What the sensor shows, in symbols of the scene.
    t, y : ndarray, shape (n,)
        Times, increasing, and values.
    sigma : ndarray, shape (n,), or None
        Standard deviations of the noise; None if not known.
    over : str
        What `t` is, if not time.
    """

    scene: str
    name: str
    expr: sp.Expr
    t: np.ndarray
    y: np.ndarray
    sigma: np.ndarray | None = None
    over: str = "t"

    @property
    def key(self) -> str:
        """The name, behind the label of the scene if there are several."""
        return f"{self.scene}.{self.name}" if self.scene else self.name


def places(channels: Sequence[Channel]) -> tuple[slice, ...]:
    """Return the place of each channel where all stand one behind the other."""
    ends = np.cumsum([0, *(c.y.size for c in channels)]).tolist()
    return tuple(slice(a, b) for a, b in pairwise(ends))


def read_channels(
    scenes: Mapping[str, Scene], records: Any, observed: Mapping[Any, Any] | None, sigma: Any
) -> tuple[Channel, ...]:
    """Read and check the records of all scenes.

    Parameters
    ----------
    scenes : mapping of str to Scene
        By label; the label of a single scene is empty.
    records, observed, sigma
        See `symfric.identification.identify.identify`.

    Raises
    ------
    SceneError
        If a record is bad; names it and the cure.
    """
    if observed is not None:
        mapped(observed, "observed", "{'column': expression}")
    if isinstance(scenes, Mapping) and "" in scenes:
        groups = {"": records}
    else:
        if not isinstance(records, Mapping) or set(records) - set(scenes):
            strange = sorted(set(records) - set(scenes)) if isinstance(records, Mapping) else []
            hint = f"; {strange[0]!r} is no label of a scene" if strange else ""
            raise SceneError(f"several scenes take the records of each by its label{hint}")
        groups = {label: records[label] for label in scenes if label in records}
    channels: list[Channel] = []
    for label, group in groups.items():
        for number, (name, record) in enumerate(_named(group, label).items(), 2):
            if isinstance(group, str | Path) and not _measures(scenes[label], name, label, observed):
                raise SceneError(
                    f"column {number} of {Path(group).name} has the name of no state; say what it measures with "
                    "observed={its name: ...}, or leave it out"
                )
            channels.append(_channel(scenes[label], label, name, record, observed, sigma))
    if not channels:
        raise SceneError("there are no records; give at least one, such as {'x': (t, y)}")
    known = {n for c in channels for n in (c.name, c.key)}
    for what, given in (("observed", observed), ("sigma", sigma)):
        strange = sorted({name_of(n) for n in given} - known) if isinstance(given, Mapping) else []
        if strange:
            raise SceneError(f"{what} names {strange[0]}, which is no record{nearest(strange[0], known)}")
    return tuple(channels)


def _named(group: Any, label: str) -> dict[str, Any]:
    """Return the records of one scene by name."""
    if isinstance(group, str | Path):
        return read_table(group)
    if _is_xarray(group, "Dataset"):
        return {str(n): group[n] for n in group.data_vars}
    if not isinstance(group, Mapping):
        of = f" of {label}" if label else ""
        raise SceneError(
            f"the records{of} are {type(group).__name__}; give a mapping such as {{'x': (t, y)}}, an xarray.Dataset or "
            "the path of a .csv, .txt or .npy file"
        )
    return {name_of(n): v for n, v in group.items()}


def _channel(
    scene: Scene, label: str, name: str, record: Any, observed: Mapping[Any, Any] | None, sigma: Any
) -> Channel:
    channel = Channel(label, name, _sensor(scene, name, label, observed), *_row(record, name))
    what = f"record {channel.key}"
    check_row(channel.t, channel.y, what)
    if channel.t[0] < 0:
        raise SceneError(f"{what} begins at t = {channel.t[0]:g}, before the run; subtract the time of its start")
    if channel.t[-1] <= 0:
        raise SceneError(f"{what} ends at t = 0; give samples later than the start of the run")
    if channel.t[-1] > LONG * scene.horizon:
        raise SceneError(
            f"{what} lasts until t = {channel.t[-1]:g}, the horizon of its scene is {scene.horizon:g}; convert the "
            "times to the scene's unit, or lengthen the scene with scene.until"
        )
    if channel.t[0] > scene.horizon:
        raise SceneError(
            f"{what} begins at t = {channel.t[0]:g}, after the horizon {scene.horizon:g} of its scene; subtract the "
            "time of its start, or lengthen the scene with scene.until"
        )
    own = _sigma(sigma, channel)
    return Channel(label, name, channel.expr, channel.t, channel.y, own)


def _measures(scene: Scene, name: str, label: str, observed: Mapping[Any, Any] | None) -> bool:
    """Whether it is known what a record measures."""
    given = {name_of(k) for k in observed or ()}
    return bool(given & {f"{label}.{name}", name}) or name in {s.name for s in scene.system.states}


def _sensor(scene: Scene, name: str, label: str, observed: Mapping[Any, Any] | None) -> sp.Expr:
    """Return the expression that a record measures."""
    given = {} if observed is None else {name_of(k): v for k, v in observed.items()}
    for key in (f"{label}.{name}", name):
        if key in given:
            return expression(given[key], f"what {name} observes")
    states = {s.name: s for s in scene.system.states}
    if name not in states:
        raise SceneError(
            f"record {name} is no state{nearest(name, states)}; say what it measures with observed={{{name!r}: ...}}"
        )
    return states[name]


def _row(record: Any, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values of one record."""
    if _is_xarray(record, "DataArray"):
        return _of_xarray(record, name)
    try:
        if isinstance(record, Mapping | str):
            raise TypeError
        t, y = record
    except (TypeError, ValueError):
        raise SceneError(f"record {name} is {type(record).__name__}; give times and values, (t, y)") from None
    return numbers(t, f"the times of record {name}"), numbers(y, f"the values of record {name}")


def _is_xarray(value: Any, kind: str) -> bool:
    """Whether a value is of a class of xarray, which is not loaded if nobody has made one."""
    xarray = sys.modules.get("xarray")
    return xarray is not None and isinstance(value, getattr(xarray, kind))


def _of_xarray(record: Any, name: str) -> tuple[np.ndarray, np.ndarray]:
    if len(record.dims) != 1 or record.dims[0] not in record.coords:
        raise SceneError(f"record {name} has dimensions {tuple(record.dims)}; give one over time, with a coordinate")
    time = record[record.dims[0]]
    t = np.asarray(time.values)
    if t.dtype.kind == "M":
        t = (t - t[0]) / np.timedelta64(1, "ns") * 1e-9 if t.size else np.zeros(0)
    elif t.dtype.kind == "m":
        t = t / np.timedelta64(1, "ns") * 1e-9
    elif str(time.attrs.get("units", "")).strip() not in SECONDS:
        raise SceneError(f"the time of record {name} is in {time.attrs['units']!r}; convert it to seconds")
    return numbers(t, f"the times of record {name}"), numbers(record.values, f"the values of record {name}")


def numbers(values: Any, what: str) -> np.ndarray:
    """Return a row of real numbers."""
    if isinstance(values, np.ma.MaskedArray) and np.any(np.ma.getmaskarray(values)):
        raise SceneError(f"{what} are masked in part; leave those samples out")
    if np.asarray(values).dtype.kind in "Mm":
        raise SceneError(f"{what} are dates or durations; give numbers of seconds, or an xarray.DataArray")
    try:
        row = np.asarray(values)
        if row.dtype.kind not in "iuf" and row.dtype != object:
            raise TypeError
        row = np.array(row, dtype=float)
    except (TypeError, ValueError):
        raise SceneError(f"{what} are not real numbers; give a sequence of them") from None
    if row.ndim != 1:
        raise SceneError(f"{what} have shape {row.shape}; give a row (n,)")
    return row


def check_row(t: np.ndarray, y: np.ndarray, what: str, over: str = "t") -> None:
    """Raise on a record that cannot be fitted; warn of gaps.

    Raises
    ------
    SceneError
        If it is empty, of two lengths, not finite, not in the order of time, or constant.
    """
    if t.size != y.size:
        raise SceneError(f"{what} has {t.size} times and {y.size} values; give one value for each time")
    if t.size < 2:
        raise SceneError(f"{what} has {t.size or 'no'} sample{'s'[: t.size != 1]}; a fit needs many")
    for row, of in ((t, over), (y, "y")):
        bad = np.flatnonzero(~np.isfinite(row))
        if bad.size:
            raise SceneError(
                f"{what} has {of}[{bad[0]}] = {row[bad[0]]}{f' and {bad.size - 1} more' if bad.size > 1 else ''}; "
                "leave out samples that are not finite"
            )
    back = np.flatnonzero(np.diff(t) <= 0)
    if back.size:
        k = int(back[0])
        if t[k] == t[k + 1]:
            raise SceneError(f"{what} has {over} = {t[k]:.9g} twice (samples {k} and {k + 1}); keep one of them")
        raise SceneError(
            f"{what} is not in the order of {over}: {t[k]:.9g}, then {t[k + 1]:.9g} (sample {k + 1}); sort it"
        )
    if np.ptp(y) <= 1e-14 * np.max(np.abs(y)):
        raise SceneError(f"{what} is constant ({y[0]:.6g}) and says nothing of the motion; check the sensor")
    step = np.diff(t)
    usual = float(np.median(step))
    if np.max(step) > GAP * usual:
        k = int(np.argmax(step))
        warnings.warn(
            f"{what} has a gap from {over} = {t[k]:.6g} to {t[k + 1]:.6g}, where samples are usually {usual:.3g} "
            "apart; the fit uses the samples that are there",
            stacklevel=5,  # of who calls `identify`
        )


def _sigma(sigma: Any, channel: Channel) -> np.ndarray | None:
    """Return the standard deviation of every sample of a channel."""
    if isinstance(sigma, Mapping):
        given = {name_of(k): v for k, v in sigma.items()}
        sigma = given.get(channel.key, given.get(channel.name))
        if sigma is None:
            raise SceneError(f"sigma has no entry for record {channel.key}; give one for each, or none at all")
    if sigma is None:
        return None
    try:
        row = np.broadcast_to(np.asarray(sigma, dtype=float), channel.y.shape)
    except (TypeError, ValueError):
        raise SceneError(
            f"sigma of record {channel.key} has shape {np.shape(sigma)}; give a number or one for each of its "
            f"{channel.y.size} samples"
        ) from None
    if not np.all(row > 0):
        raise SceneError(f"sigma of record {channel.key} is not positive; give standard deviations of the noise")
    return np.array(row)
