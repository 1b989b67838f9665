"""The path of a body in the plane in which one of its contacts slides."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from symfric.model.numeric import numeric_function
from symfric.model.scene import Scene
from symfric.report.html.elements import Picture
from symfric.report.study.drawing.axes import BLUE, ORANGE, Axes, in_brackets, label, legend, new_axes, tidy, to_svg
from symfric.report.study.measurement import SampledMotion


@dataclass(frozen=True)
class PlanePath:
    """Where the body of contacts in the plane is, relative to what does not move with its coordinates.

    Attributes
    ----------
    contacts : tuple of str
        Which slide along these directions.
    across, up : Expr
        Of the coordinates: those whose rates are the two slips, without the speed of the table.
    """

    contacts: tuple[str, ...]
    across: sp.Expr
    up: sp.Expr


def paths_in_plane(scene: Scene) -> list[PlanePath]:
    """Return the paths of a scene, one for contacts in the plane that go the same ways; also of feet that turn."""
    contacts: dict[tuple[sp.Expr, sp.Expr], list[str]] = {}
    system, values = scene.system, scene.parameter_values()
    for contact in (c for c in scene.contacts if c.in_plane):
        slopes = [[w.diff(u).xreplace(values) for u in system.u] for w in contact.slips]
        ends = [_place(row, system.q) for row in slopes]
        if ends[0] is not None and ends[1] is not None:
            contacts.setdefault((ends[0], ends[1]), []).append(contact.name)
    return [PlanePath(tuple(names), *ends) for ends, names in contacts.items()]


def _place(slopes: Sequence[sp.Expr], q: Sequence[sp.Symbol]) -> sp.Expr | None:
    """Return the function of the coordinates with these derivatives, None if there is none in closed form."""
    place: sp.Expr = sp.S.Zero
    for e, own in zip(slopes, q, strict=True):
        if not e.free_symbols <= set(q):
            return None
        place += sp.integrate(e - place.diff(own), own)
    told = not place.has(sp.Integral)
    return place if told and all(sp.simplify(place.diff(k) - e) == 0 for e, k in zip(slopes, q, strict=True)) else None


def path_picture(motion: SampledMotion, path: PlanePath, units: Mapping[str, str]) -> Picture:
    """Return the picture of a path."""
    names = ", ".join(path.contacts)
    what = f"Path in the plane of {'contacts' if len(path.contacts) > 1 else 'contact'} {names}"
    return Picture(to_svg(plot_path(motion, path, units)), f"{what}: {path.up} against {path.across}", f"{what}.")


def plot_path(motion: SampledMotion, path: PlanePath, units: Mapping[str, str], ax: Axes | None = None) -> Axes:
    """Draw the path, both directions to the same scale, with the places where a contact sticks."""
    ax = new_axes() if ax is None else ax
    states = tuple(sorted(path.across.free_symbols | path.up.free_symbols, key=str))
    values = [motion.x[motion.names.index(s.name)] for s in states]
    x, y = (np.broadcast_to(numeric_function(states, e)(*values), motion.t.shape) for e in (path.across, path.up))
    ax.plot(x, y, color=BLUE, linewidth=0.9, label="path")
    on = motion.sticking(path.contacts)
    if on.any():
        ax.plot(np.where(on, x, np.nan), np.where(on, y, np.nan), ".", color=ORANGE, markersize=4, label="sticking")
    ax.plot(x[0], y[0], "o", color="black", markersize=5, fillstyle="none", label="start")
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel(_label(path.across, units))
    ax.set_ylabel(_label(path.up, units))
    legend(ax)
    return tidy(ax)


def _label(place: sp.Expr, units: Mapping[str, str]) -> str:
    """Return the name of a coordinate, or the sum of several, with its unit."""
    if place.is_Symbol:
        return label(place.name, units)
    shared = {units.get(s.name, "") for s in place.free_symbols}
    return str(place) + in_brackets(shared.pop() if len(shared) == 1 else "")
