"""Pictures of modes and of flutter."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.axes import Axes, axes_for, in_letters
from symfric.locks import DRAWING, alone

if TYPE_CHECKING:
    from symfric.structures.flutter import Flutter
    from symfric.structures.flutter_map import FlutterMap


@alone(DRAWING)
def plot_shapes(
    shapes: np.ndarray, frequency: np.ndarray, ax: Axes | None = None, modes: Sequence[int] = (0, 1, 2), at: Any = None
) -> Axes:
    """Draw mode shapes over the degrees of freedom, or over places; return the Axes.

    Parameters
    ----------
    shapes : ndarray, shape (n, count)
    frequency : ndarray, shape (count,)
    ax : Axes, optional
    modes : sequence of int
        Which ones; those that are not there are left out.
    at : array_like, shape (n,), optional
        Places of the degrees of freedom; NaN leaves one out.
    """
    ax = axes_for(ax)
    places = np.arange(len(shapes)) if at is None else np.asarray(at, dtype=float)
    shown = np.flatnonzero(np.isfinite(places))
    shown = shown[np.argsort(places[shown], kind="stable")]
    for k in (k for k in modes if k < shapes.shape[1]):
        shape = shapes[shown, k].real
        size = np.max(np.abs(shape)) or 1.0
        ax.plot(places[shown], shape / size, label=f"omega = {frequency[k]:.4g}")
    ax.set_xlabel("degree of freedom" if at is None else "place")
    ax.set_ylabel("shape")
    ax.legend()
    return ax


@alone(DRAWING)
def plot_flutter(flutter: "Flutter", ax: Axes | None = None) -> Axes:
    """Draw imaginary parts against mu in the Axes, and real parts in a panel under it; return the Axes."""
    from mpl_toolkits.axes_grid1 import make_axes_locatable

    ax = axes_for(ax)
    below = make_axes_locatable(ax).append_axes("bottom", size="70%", pad=0.15, sharex=ax)
    for values in flutter.eigenvalues:
        (line,) = ax.plot(flutter.mu, values.imag, linewidth=1.2)
        below.plot(flutter.mu, values.real, linewidth=1.2, color=line.get_color())
    below.axhline(0.0, color="0.6", linewidth=0.8)
    for point in flutter.critical:
        ax.plot(point.mu, point.omega, "k.")
        below.axvline(point.mu, color="0.6", linestyle=":", linewidth=0.8)
    ax.tick_params(labelbottom=False)
    ax.set_ylabel("imaginary part")
    below.set_ylabel("real part")
    below.set_xlabel(in_letters("mu"))
    return ax


@alone(DRAWING)
def plot_map(result: "FlutterMap", ax: Axes | None = None) -> Axes:
    """Draw the lowest critical mu against the second parameter; return the Axes."""
    ax = axes_for(ax)
    ax.plot(result.values, result.mu, "o-", markersize=3)
    ax.set_xlabel(in_letters(result.name))
    ax.set_ylabel(f"critical {in_letters('mu')}")
    return ax
