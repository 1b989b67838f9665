"""The onset of flutter over a second parameter."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric.axes import Axes
from symfric.errors import SceneError
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model.arguments import instance
from symfric.model.results import ArrayResult, Drawable, Labelled
from symfric.model.symbols import finite, shortened
from symfric.structures.flutter import Flutter, flutter
from symfric.structures.followed_crossings import Critical
from symfric.structures.structure import Structure


@dataclass(frozen=True, eq=False, repr=False)
class FlutterMap(ArrayResult, Drawable):
    """The onset of flutter over a second parameter.

    `plot` draws the lowest critical mu against the parameter.

    Attributes
    ----------
    name : str
    values : ndarray, shape (n,)
        Of the second parameter; fewer than were given after an interrupt, see `symfric.keep_when_interrupted`.
    mu, omega : ndarray, shape (n,)
        The lowest critical mu and its frequency; NaN where no mode begins to grow.
    found : tuple of Flutter
        Everything, one for each value.

    Examples
    --------
    >>> import symfric as sf
    >>> damped = lambda c: sf.structures.ziegler(damping=c)
    >>> found = sf.structures.flutter_map(damped, [0.0, 0.1], mu=(0, 4), count=2, name="damping")
    >>> found.mu.shape
    (2,)
    >>> sorted(found.to_dict())[:2]
    ['damping', 'mu']
    >>> len(found.to_xarray().data_vars) > 0
    True
    >>> ax = found.plot()
    """

    name: str
    values: np.ndarray
    mu: np.ndarray
    omega: np.ndarray
    found: tuple[Flutter, ...]

    def _labelled(self) -> Labelled:
        return {"mu": (self.name, self.mu), "omega": (self.name, self.omega)}, {self.name: self.values}, {}

    def to_dict(self) -> dict[str, Any]:
        return {self.name: self.values.tolist(), "mu": self.mu.tolist(), "omega": self.omega.tolist()}

    def _draw(self, ax: Axes | None) -> Axes:
        from symfric.structures.pictures import plot_map

        return plot_map(self, ax)

    def __repr__(self) -> str:
        known = np.isfinite(self.mu)
        low = f"least critical mu {np.nanmin(self.mu):.6g}" if known.any() else "no flutter"
        return f"FlutterMap({self.values.size} values of {self.name}; {low})"


@logged
def flutter_map(
    make: Callable[[float], Structure],
    values: Sequence[float] | np.ndarray,
    mu: tuple[float, float],
    count: int = 8,
    near: complex | float = 0.0,
    name: str = "parameter",
) -> FlutterMap:
    """Compute the onset of flutter for several values of a second parameter.

    Parameters
    ----------
    make : callable
        ``make(value) -> Structure``: a speed in gyroscopic terms, a stiffness, a pressure.
    values : array_like, shape (n,)
    mu, count, near
        See `flutter`.
    name : str
        Of the parameter.

    Returns
    -------
    FlutterMap

    Raises
    ------
    SceneError, NotFound
        As `flutter`.

    Examples
    --------
    >>> import symfric as sf
    >>> damped = lambda c: sf.structures.ziegler(damping=c)
    >>> found = sf.structures.flutter_map(damped, [1e-3, 1e-2], mu=(0.5, 3.0), count=2)
    >>> found.mu.round(4).tolist()
    [1.4643, 1.4643]
    """
    if not callable(make):
        raise SceneError(f"make is {shortened(make)}; give a function, make(value) -> Structure")
    numbers = np.array([finite(v, f"a value of {name}") for v in np.atleast_1d(values)])
    maps: list[Flutter] = []
    with until_interrupted("flutter_map"):
        for k, v in enumerate(numbers.tolist()):
            tell(f"{name} = {v:.5g}", k / numbers.size)
            maps.append(flutter(instance(make(v), Structure, f"make({v:g})"), mu, count, near))
    if numbers.size and not maps:
        raise KeyboardInterrupt
    first = [f.critical[0] if f.critical else Critical(np.nan, np.nan, (-1, -1)) for f in maps]
    mus, omegas = np.array([p.mu for p in first]), np.array([p.omega for p in first])
    return FlutterMap(name, numbers[: len(maps)], mus, omegas, tuple(maps))
