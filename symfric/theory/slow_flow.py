"""Slow flow: the averaged equation of one amplitude, and its stationary amplitudes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from symfric.axes import Axes, axes_for
from symfric.errors import SceneError
from symfric.model.notebook import html_table
from symfric.model.numeric import numeric
from symfric.model.results import IN_WORDS, ArrayResult, Drawable, Labelled
from symfric.model.symbols import Key, name_of, nearest
from symfric.search import zero

_ANY_UNIT = np.geomspace(1e-40, 1e40, 641)  # amplitudes in whatever unit, eight to a decade
_BENT = 0.5  # relative change of the relative rate that tells the scale of the amplitudes
_AROUND = 1e-6, 1e3  # of the least and of the largest amplitude at which the formula changes: where zeros are sought
_DENSITY = 120  # amplitudes in a decade of the search
_BESIDE = 10.0 ** np.linspace(-14, -0.5, 82)  # distances from such an amplitude, where the rate may have a root of it
_NOISE = 1e-13  # of the median relative rate: a rate below it is rounding, whose sign means nothing


@dataclass(frozen=True, eq=False, repr=False)
class SlowFlow(ArrayResult, Drawable):
    """Slow flow of an amplitude: ``A' = rate(A)``.

    Call it with numbers, ``flow(A)`` or ``flow(A, {"v_b": 0.3})``, for the rate.

    `plot` draws the rate against the amplitude with the stationary amplitudes.

    Attributes
    ----------
    amplitude : Symbol
        A, the amplitude of the coordinate (of its first harmonic for order 2); a length.
    rate : Expr
        A', in A and the parameters.
    frequency : Expr
        Of the oscillation at amplitude A, rad/time.
    amplitudes : ndarray, shape (n,)
        Stationary amplitudes A > 0, increasing; for order 2 half ranges. A = 0, steady sliding itself, is always
        stationary and not listed.
    stable : ndarray of bool, shape (n,)
        Whether neighbouring amplitudes return to each.
    order : int
    values : dict of Symbol to float
        Parameters of `rate` and their numbers; empty where numbers had to be put in.
    positive : tuple of Expr
        Must stay positive for the formulas to hold: the sliding speeds and the slopes of the slips.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> flow = sf.average(belt)
    >>> [round(float(a), 4) for a in flow.amplitudes]
    [0.2011]
    >>> round(float(flow.frequency_at(0.2)), 6)
    1.0
    >>> sorted(flow.to_dict())[:2]
    ['amplitudes', 'frequency']
    >>> len(flow.to_xarray().data_vars) > 0
    True
    >>> ax = flow.plot()
    """

    amplitude: sp.Symbol
    rate: sp.Expr = field(metadata=IN_WORDS)
    frequency: sp.Expr = field(metadata=IN_WORDS)
    amplitudes: np.ndarray
    stable: np.ndarray
    order: int
    values: dict[sp.Symbol, float]
    positive: tuple[sp.Expr, ...] = ()
    _told = ("order", "rate", "frequency", "amplitudes", "stable")

    def _labelled(self) -> Labelled:
        data = {"amplitudes": ("cycle", self.amplitudes), "stable": ("cycle", self.stable)}
        return data, {}, {"rate": str(self.rate), "frequency": str(self.frequency), "order": self.order}

    def __call__(self, A: Any, values: Mapping[Key, float] | None = None) -> Any:
        """Return the rate A' at amplitudes A, any shape, for other values of some parameters if given."""
        return evaluator(self, self.rate, values)(A)

    def frequency_at(self, A: Any, values: Mapping[Key, float] | None = None) -> Any:
        """Return the frequency at amplitudes A, any shape.

        Parameters
        ----------
        A : float or array_like
        values : mapping of symbol or name to number, optional
            Of parameters, instead of the present ones.

        Returns
        -------
        float
        """
        return evaluator(self, self.frequency, values)(A)

    def _draw(self, ax: Axes | None) -> Axes:
        ax = axes_for(ax)
        top = 1.5 * self.amplitudes.max() if self.amplitudes.size else 1.0
        A = np.linspace(top / 400, top, 400)
        ax.axhline(0.0, color="0.6", linewidth=0.8)
        ax.plot(A, self(A))
        for a, good in zip(self.amplitudes, self.stable, strict=True):
            ax.plot(a, 0.0, "o", color="k", fillstyle="full" if good else "none")
        ax.set_xlabel("amplitude A")
        ax.set_ylabel("rate A'")
        return ax

    def __repr__(self) -> str:
        pairs = zip(self.amplitudes, self.stable, strict=True)
        amplitudes = ", ".join(f"{a:.6g} {'stable' if s else 'unstable'}" for a, s in pairs) or "none but zero"
        return f"SlowFlow(order {self.order}; stationary amplitudes: {amplitudes})"

    def _repr_html_(self) -> str:
        return html_table("SlowFlow", {**self.to_dict(), "rate": self.rate, "frequency": self.frequency})


def evaluator(flow: SlowFlow, expr: sp.Expr, values: Mapping[Key, float] | None) -> Callable[[Any], Any]:
    """Return an expression of a slow flow as a function of amplitudes, any shape, for other values of some parameters.

    Raises
    ------
    SceneError
        If a name is no parameter, or if averaging does not hold for the values.
    """
    numbers = dict(flow.values)
    named = {s.name: s for s in numbers}
    for key, value in (values or {}).items():
        name = name_of(key)
        if name not in named:
            raise SceneError(f"{name} is no parameter of the slow flow{nearest(name, named)}")
        numbers[named[name]] = float(value)
    for e in flow.positive:
        if values and not float(e.subs(numbers)) > 0:
            raise SceneError(f"{e} is not positive for these values; average the scene with them instead")
    compiled = numeric((flow.amplitude, *numbers), (expr,))

    def at(A: Any) -> Any:
        (result,) = compiled(A, *numbers.values())
        return result.copy() if np.ndim(result) else float(result)

    return at


def _where_it_bends(rate: Callable[..., Any]) -> float:
    """Return about the least amplitude at which the relative rate deviates from that of small amplitudes; else 1."""
    grid = _ANY_UNIT
    with np.errstate(all="ignore"):
        relative = rate(grid) / grid
    known = np.flatnonzero(np.isfinite(relative))
    if not known.size:
        return 1.0
    first = relative[known[0]]
    bent = known[np.abs(relative[known] - first) > _BENT * np.abs(first)]
    return float(grid[bent[0]]) if bent.size else 1.0


def stationary(rate: Callable[..., Any], edges: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return all stationary amplitudes, at which the rate changes its sign, and whether each is stable.

    Parameters
    ----------
    rate : callable
        Vectorised ``A -> A'``.
    edges : tuple of float
        Amplitudes at which the formula changes; the search is dense on both sides of each and goes from
        1e-6 times the first to 1e3 times the last; without any, about the amplitude that changes the relative rate.
    """
    inner = [e for e in edges if e > 0] or [_where_it_bends(rate)]
    low, high = _AROUND[0] * min(inner), _AROUND[1] * max(inner)
    grid = np.geomspace(low, high, int(np.log10(high / low) * _DENSITY))
    grid = np.unique(np.concatenate([grid, *(e * (1 + side * _BESIDE) for e in inner for side in (-1, 1))]))
    values = rate(grid)
    good = np.isfinite(values)
    grid, values = grid[good], values[good]
    if not grid.size:
        return np.array([]), np.array([], dtype=bool)
    relative = np.abs(values) / grid
    kept = relative > _NOISE * np.median(relative)
    grid, values = grid[kept], values[kept]
    turns = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    roots = [zero(lambda a: float(rate(a)), grid[k], grid[k + 1], rtol=1e-15) for k in turns]
    return np.array(roots), values[turns] > 0 if turns.size else np.array([], dtype=bool)
