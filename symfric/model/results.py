"""Bases of all results: plain data from their fields, tables for notebooks, arrays with named axes."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np

from symfric.locks import DRAWING, alone
from symfric.model.notebook import html_table

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Labelled: TypeAlias = tuple[Mapping[str, Any], Mapping[str, Any], Mapping[str, Any]]


def plain(value: Any) -> Any:
    """Return plain data: arrays and tuples as lists, complex numbers as [real, imaginary], records as mappings.

    Parameters
    ----------
    value : object
        What is none of these is returned as it is.
    """
    if isinstance(value, np.ndarray | np.generic):
        return (_pairs(value) if np.iscomplexobj(value) else value).tolist()
    if isinstance(value, complex):
        return [value.real, value.imag]
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, Result):
        return value.to_dict()
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return plain(value._asdict())
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Mapping):
        return {k: plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    return str(value) if isinstance(value, Path) else value


def _pairs(value: np.ndarray | np.generic) -> np.ndarray:
    return np.stack([value.real, value.imag], -1)


def as_plain(convert: Callable[[Any, Any], Any]) -> dict[str, Any]:
    """Return the metadata of a field whose plain data is ``convert(value, result)``."""
    return {"plain": convert}


COMPLEX = as_plain(lambda value, _: _pairs(value).tolist())  #: [real, imaginary], also where every entry is real
BY_NAME = as_plain(lambda value, result: dict(zip(result.names, value.tolist(), strict=True)))  #: rows by `names`
IN_WORDS = as_plain(lambda value, _: str(value))  #: an expression as its text


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """A frozen dataclass whose fields become plain data.

    `_told` names what `to_dict` returns, in this order: fields and properties. Unless it is given, these are the fields
    without those that are private or that the repr leaves out. Metadata of a field may say how it becomes plain
    (`COMPLEX`, `BY_NAME`, `IN_WORDS`, `as_plain`). A result with other data overrides `to_dict`.
    """

    _told: ClassVar[tuple[str, ...]] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, strings, lists and mappings of them; complex numbers as [real, imaginary].

        Returns
        -------
        dict
            Plain numbers, strings and lists.

        Examples
        --------
        >>> import symfric as sf
        >>> sf.theory.drive.positioning_error(-0.5, 0.8, 4.0).to_dict()["type"]
        'c'
        """
        own = {f.name: f for f in fields(self)}
        told = self._told or [n for n, f in own.items() if f.repr and not n.startswith("_")]
        converted = {n: f.metadata["plain"] for n, f in own.items() if "plain" in f.metadata}
        values = {n: getattr(self, n) for n in told}
        return {n: converted[n](v, self) if n in converted else plain(v) for n, v in values.items()}

    def _repr_html_(self) -> str:
        return html_table(type(self).__name__, self.to_dict())


@dataclass(frozen=True, eq=False, repr=False)
class ArrayResult(Result, ABC):
    """A result with arrays over named axes, which `_labelled` describes."""

    @abstractmethod
    def _labelled(self) -> Labelled:
        """Return data, coordinates and attributes, as `xarray.Dataset` takes them."""

    def to_xarray(self) -> "xr.Dataset":
        """Return the arrays over their named axes, with single numbers and words as attributes.

        Returns
        -------
        xarray.Dataset

        Examples
        --------
        >>> import symfric as sf
        >>> chain = sf.structures.chain(3)
        >>> chain.modes(2).to_xarray()["shapes"].dims
        ('dof', 'mode')
        """
        import xarray as xr

        return xr.Dataset(*self._labelled())


class Drawable(ABC):
    """Something that draws itself: `_draw` takes the Axes given, or None for a new figure, and returns those used."""

    @abstractmethod
    def _draw(self, ax: "Axes | None") -> "Axes": ...

    @alone(DRAWING)
    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw what the class describes and return the Axes.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw; a new figure unless given.

        Returns
        -------
        matplotlib Axes

        Examples
        --------
        >>> import symfric as sf
        >>> ax = sf.average(sf.scenes.mass_on_belt(v_b=0.42)).plot()
        >>> ax.get_xlabel()
        'amplitude A'
        """
        return self._draw(ax)
