"""Plots of a run."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.axes import axes_for, in_letters
from symfric.locks import DRAWING, alone
from symfric.model.held import Held
from symfric.model.scene import Scene
from symfric.solve.sticking import stuck

if TYPE_CHECKING:
    from symfric.solve.run import Run

_NO_UNITS: Mapping[str, str] = MappingProxyType({})


def in_brackets(unit: str | None) -> str:
    """Return a unit in brackets, with dollar signs escaped; empty without one."""
    return " [" + unit.replace("$", r"\$") + "]" if unit else ""


def labelled(name: str, units: Mapping[str, str]) -> str:
    """Return a name, set as mathematics, with its unit in brackets."""
    return in_letters(name) + in_brackets(units.get(name))


def motion_to_draw(
    run: "Run", t: np.ndarray, contacts: Sequence[bool] | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a motion for drawing, so that jumps are no slanted lines.

    Parameters
    ----------
    run : Run
    t : ndarray, shape (n,)
        Increasing.
    contacts : sequence of bool, optional
        Which contacts count as sticking; all unless given.

    Returns
    -------
    t : ndarray, shape (m,)
        The given times; those of jumps between the first and the last twice, before and after.
    x : ndarray, shape (n_x, m)
    on : ndarray of bool, shape (m,)
        Whether some contact sticks.
    """
    if not run.path.t.size:  # it failed in its first step
        return t, run(t), np.zeros(t.shape, dtype=bool)
    t, x, step = run.path.line(t)
    on = np.any(stuck(run)[slice(None) if contacts is None else np.asarray(contacts, bool)], axis=0)
    return t, x, on[step]


def acting(scene: Scene) -> tuple[Held, ...]:
    """Return the held variables that the equations of motion contain, such as the command of a controller."""
    parts = (e.free_symbols for e in scene.system.expressions)
    used = set().union(*parts, *(c.free_symbols for c in scene.contacts))
    return tuple(h for h in scene.held if h.symbol in used)


@alone(DRAWING)
def plot_run(run: "Run", ax: Any = None, units: Mapping[str, str] = _NO_UNITS) -> Any:
    """Draw every coordinate against time, with a bar along the bottom where a contact sticks; return the Axes.

    Held variables that act on the motion are drawn as steps, on an axis of their own at the right.
    """
    ax = axes_for(ax)
    t, x, on = motion_to_draw(run, np.union1d(np.linspace(0, run.t_final, 2000), run.t))
    for i, q in enumerate(run.scene.system.q):
        own = "" if len({units.get(s.name, "") for s in run.scene.system.q}) == 1 else in_brackets(units.get(q.name))
        ax.plot(t, x[i], lw=1, label=q.name + own)
    if on.any():
        floor = ax.get_ylim()[0]
        ax.plot(t, np.where(on, floor, np.nan), color="0.35", lw=3, solid_capstyle="butt", label="a contact sticks")
    held = acting(run.base)
    lines, names = ax.get_legend_handles_labels()
    if held:
        right = ax.twinx()
        for k, h in enumerate(held):
            (line,) = right.plot(t, x[run.names.index(h.name)], lw=0.8, color=f"C{len(lines) + k}")
            lines, names = [*lines, line], [*names, h.name + in_brackets(units.get(h.name))]
        right.set_ylabel("held")
        ax.set_zorder(right.get_zorder() + 1)
        ax.patch.set_visible(False)
    ax.set_xlabel("time t" + in_brackets(units.get("t")))
    own_units = {units.get(q.name, "") for q in run.scene.system.q}
    shared = own_units.pop() if len(own_units) == 1 else ""
    ax.set_ylabel(("coordinate" if len(run.scene.system.q) > 1 else run.names[0]) + in_brackets(shared))
    ax.legend(lines, names, loc="best", fontsize="small")
    return ax
