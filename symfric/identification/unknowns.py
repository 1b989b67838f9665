"""The unknowns of a fit: values of scenes, start values, offsets and scales of sensors, each between two bounds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from symfric.errors import SceneError
from symfric.identification.records import Channel
from symfric.model.scene import Scene
from symfric.model.symbols import finite, name_of, nearest

WIDE = 100.0  # bounds above zero with this ratio or more are searched by their logarithm
VALUE, START, OFFSET, SCALE = "value", "start", "offset", "scale"


class Target(NamedTuple):
    """What an unknown sets: a value or a start of a scene, or a number of a sensor.

    Attributes
    ----------
    kind : str
        "value", "start", "offset" or "scale".
    label : str
        Of the scene, or key of the channel.
    name : str
        Of the parameter or state.
    """

    kind: str
    label: str
    name: str


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Names, bounds and meaning of the unknowns of a fit.

    Attributes
    ----------
    names : tuple of str
    low, high : ndarray, shape (n_p,)
        Bounds.
    targets : tuple of tuple of Target
        What each unknown sets.
    logarithmic : ndarray of bool, shape (n_p,)
        Which are searched by their logarithm.
    """

    names: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray
    targets: tuple[tuple[Target, ...], ...]
    logarithmic: np.ndarray

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.names)

    def inner(self, values: np.ndarray) -> np.ndarray:
        """Return the coordinates in [0, 1] of values between the bounds, shape (..., n_p)."""
        low, high, v = (np.where(self.logarithmic, _log(a), a) for a in (self.low, self.high, values))
        return np.asarray((v - low) / (high - low))

    def outer(self, inner: np.ndarray) -> np.ndarray:
        """Return the values at coordinates in [0, 1], shape (..., n_p); they stay between the bounds."""
        low, high = (np.where(self.logarithmic, _log(a), a) for a in (self.low, self.high))
        v = low + (high - low) * inner
        return np.clip(np.where(self.logarithmic, np.exp(np.where(self.logarithmic, v, 0.0)), v), self.low, self.high)

    def stretch(self, values: np.ndarray) -> np.ndarray:
        """Return d value / d coordinate, shape (n_p,)."""
        low, high = (np.where(self.logarithmic, _log(a), a) for a in (self.low, self.high))
        return (high - low) * np.where(self.logarithmic, values, 1.0)


def _log(values: np.ndarray) -> np.ndarray:
    return np.log(np.where(values > 0, values, 1.0))


def read_unknowns(parameters: Any, scenes: Mapping[str, Scene], channels: Sequence[Channel]) -> Unknowns:
    """Read the unknowns of a fit.

    Parameters
    ----------
    parameters : mapping of name to (low, high)
        A value of the scene, a state (its start), or ``record.offset`` and ``record.scale`` of a sensor; behind
        ``label.`` for one of several scenes.
    scenes : mapping of str to Scene
    channels : sequence of Channel

    Raises
    ------
    SceneError
        If a name is unknown or given twice, or the bounds are none.
    """
    unknowns = read_bounds(parameters)
    targets = []
    taken: dict[Target, str] = {}
    for name in unknowns.names:
        own = _targets(name, scenes, channels)
        for target in own:
            if target in taken:
                raise SceneError(f"{taken[target]} and {name} in parameters set the same {target.kind}; keep one")
            taken[target] = name
        targets.append(own)
    return replace(unknowns, targets=tuple(targets))


def read_bounds(parameters: Any) -> Unknowns:
    """Read names and bounds of unknowns that set nothing in scenes.

    Raises
    ------
    SceneError
        If a name is given twice, or the bounds are none.
    """
    if not isinstance(parameters, Mapping) or not parameters:
        raise SceneError("parameters must name at least one unknown with its bounds, such as {'mu_s': (0.1, 0.8)}")
    bounds: dict[str, tuple[float, float]] = {}
    for key, limits in parameters.items():
        name = name_of(key)
        if name in bounds:
            raise SceneError(f"{name} is given twice in parameters, as a symbol and by name")
        bounds[name] = _bounds(limits, name)
    low, high = np.array(list(bounds.values())).T
    wide = (low > 0) & (high >= WIDE * np.where(low > 0, low, 1.0))
    return Unknowns(tuple(bounds), low, high, ((),) * len(bounds), wide)


def _bounds(limits: Any, name: str) -> tuple[float, float]:
    try:
        low, high = limits
    except (TypeError, ValueError):
        raise SceneError(f"the bounds of {name} are {limits!r}; give (smallest, largest)") from None
    low, high = finite(low, f"the lower bound of {name}"), finite(high, f"the upper bound of {name}")
    if not low < high:
        raise SceneError(f"the bounds of {name} are ({low:g}, {high:g}); the first must be smaller")
    return low, high


def _targets(name: str, scenes: Mapping[str, Scene], channels: Sequence[Channel]) -> tuple[Target, ...]:
    """Return what an unknown sets."""
    record, _, what = name.rpartition(".")
    if what in (OFFSET, SCALE):
        targets = [Target(what, c.key, what) for c in channels if record in (c.key, c.name)]
        if targets:
            return tuple(targets)
    targets = []
    for label, scene in scenes.items():
        own = name.removeprefix(f"{label}.") if label else name
        if own in (s.name for s in scene.parameters):
            targets.append(Target(VALUE, label, own))
        elif own in (s.name for s in scene.system.states):
            targets.append(Target(START, label, own))
    if targets:
        return tuple(targets)
    known = {s.name for scene in scenes.values() for s in (*scene.parameters, *scene.system.states)}
    known |= {f"{c.key}.{what}" for c in channels for what in (OFFSET, SCALE)}
    raise SceneError(f"{name} is no value, state, offset or scale to fit{nearest(name, known)}")
