"""Plots of a run."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.axes import axes_for, in_letters
from symfric.locks import DRAWING, alone

if TYPE_CHECKING:
    from symfric.solve.run import Run

_NO_UNITS: Mapping[str, str] = MappingProxyType({})


def in_brackets(unit: str | None) -> str:
    """Return a unit in brackets, with dollar signs escaped; empty without one."""
    return " [" + unit.replace("$", r"\$") + "]" if unit else ""


def labelled(name: str, units: Mapping[str, str]) -> str:
    """Return a name, set as mathematics, with its unit in brackets."""
    return in_letters(name) + in_brackets(units.get(name))


def sticking(run: "Run", t: np.ndarray, contacts: Sequence[bool] | None = None) -> np.ndarray:
    """Return whether some contact sticks at given times of a run, shape (n_t,); `contacts`: which ones, all if None."""
    on = (run.mode[slice(None) if contacts is None else np.asarray(contacts, bool)] == 0).any(axis=0)
    return on[np.clip(np.searchsorted(run.t, t, side="right") - 1, 0, run.t.size - 1)]


@alone(DRAWING)
def plot_run(run: "Run", ax: Any = None, units: Mapping[str, str] = _NO_UNITS) -> Any:
    """Draw every coordinate against time, with a bar along the bottom where a contact sticks; return the Axes."""
    ax = axes_for(ax, layout="constrained")
    t = np.union1d(np.linspace(0, run.t_final, 2000), run.t)
    x = run(t)
    for i, q in enumerate(run.scene.system.q):
        own = "" if len({units.get(s.name, "") for s in run.scene.system.q}) == 1 else in_brackets(units.get(q.name))
        ax.plot(t, x[i], lw=1, label=q.name + own)
    on = sticking(run, t)
    if on.any():
        floor = ax.get_ylim()[0]
        ax.plot(t, np.where(on, floor, np.nan), color="0.35", lw=3, solid_capstyle="butt", label="a contact sticks")
    ax.set_xlabel("time t" + in_brackets(units.get("t")))
    own_units = {units.get(q.name, "") for q in run.scene.system.q}
    shared = own_units.pop() if len(own_units) == 1 else ""
    ax.set_ylabel(("coordinate" if len(run.scene.system.q) > 1 else run.names[0]) + in_brackets(shared))
    ax.legend(loc="best", fontsize="small")
    return ax
