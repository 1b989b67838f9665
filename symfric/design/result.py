"""Result of a design."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from symfric.axes import axes_for
from symfric.model.results import Drawable, Result
from symfric.model.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class Curve:
    """The limiting condition of a design, as a curve over the variable for which it must hold.

    Attributes
    ----------
    x, y : ndarray, shape (n,)
        NaN in `y` separates branches.
    level : float
        Limit of the condition.
    xlabel, ylabel : str
    marks : tuple of float
        Values of `x` where the condition is active.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> curve = sf.design.quench(belt, speeds=(0.1, 0.4), Omega=(20, 60), a=(0, 0.02)).curve
    >>> curve.x.shape == curve.y.shape
    True
    """

    x: np.ndarray
    y: np.ndarray
    level: float
    xlabel: str
    ylabel: str
    marks: tuple[float, ...] = ()


class Checked(Protocol):
    """Base of the verification of an optimum on the full model."""

    @property
    def agrees(self) -> bool:
        """Whether the requirement holds on the full model."""

    @property
    def disagreements(self) -> tuple[str, ...]:
        """Disagreements, one line of text each; empty if `agrees`."""

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""


@dataclass(frozen=True, eq=False, repr=False)
class Design(Result, Drawable):
    """An optimum and its verification on the full model.

    Attributes
    ----------
    values : dict of str to float
        By the names of the parameters that were optimised.
    objective : float
        Objective at the optimum.
    active : tuple of str
        Conditions and bounds that hold with equality.
    scene : Scene
        The given one with `values`.
    check : object
        Verification on the full event-driven model; has ``agrees``, ``to_dict()`` and a readable ``str``.
    status : str
        "optimal": the requirement holds on the full model, and designs beside it are worse or violate a condition;
        "infimum": likewise, but the conditions hold for parameters as near to `values` as one likes, not at them;
        "best found": the requirement holds on the full model, but better designs may exist;
        "unverified": the full model disagrees.
    curve : Curve
        What `plot` draws.
    corrected : dict of str to float, or None
        The optimum on the full model, where `values` are that of an averaged one.
    doubts : tuple of str
        Why the status is no better.
    neighbours : tuple of dict
        Designs beside this one that were computed: how each differs, its objective, and by how much it violates the
        conditions (relative; not positive where all hold).

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> found = sf.design.quench(belt, speeds=(0.1, 0.4), Omega=(20, 60), a=(0, 0.02))
    >>> found.status
    'optimal'
    >>> sorted(found.to_dict())[:2]
    ['active', 'check']
    >>> ax = found.plot()
    """

    _told = ("values", "objective", "active", "status", "doubts", "neighbours", "corrected", "check")

    values: dict[str, float]
    objective: float
    active: tuple[str, ...]
    scene: Scene
    check: Checked
    status: str
    curve: Curve = field(repr=False)
    corrected: dict[str, float] | None = None
    doubts: tuple[str, ...] = ()
    neighbours: tuple[dict[str, object], ...] = field(default=(), repr=False)

    def __repr__(self) -> str:
        values = ", ".join(f"{k}={v:.6g}" for k, v in self.values.items())
        doubts = f", but {'; '.join(self.doubts)}" if self.doubts else ""
        active = "; ".join(self.active)
        return f"Design({self.status}, {values}, objective={self.objective:.6g}, active: {active}{doubts})"

    def _draw(self, ax: "Axes | None") -> "Axes":
        ax = axes_for(ax)
        curve = self.curve
        ax.plot(curve.x, curve.y)
        ax.axhline(curve.level, color="0.4", linewidth=0.8, linestyle="--")
        for x in curve.marks:
            ax.plot([x], [curve.level], "o", color="C3")
        seen = curve.y[np.isfinite(curve.y)]
        low, high = min(float(np.min(seen)), curve.level), max(float(np.quantile(seen, 0.9)), curve.level)
        room = 0.1 * (max(high - low, 1e-3 * abs(low)) or 1.0)  # the damping is infinite just below v_b = a Omega
        ax.set_ylim(low - room, high + room)
        ax.set_xlabel(curve.xlabel)
        ax.set_ylabel(curve.ylabel)
        return ax
