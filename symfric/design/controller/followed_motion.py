"""Follow a motion that hunts to lower values, down to where it comes to rest.

Where hunting begins few starts lead to it. A motion that hunts already stays near its cycle while the value is lowered
in small steps, each run starting where the last one was at a sampling instant.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

from symfric.design.controller.settling_motions import SettlingMotions
from symfric.model.outputs import Trajectory
from symfric.solve.protocol import Program
from symfric.solve.routes import prepare

_FIRST, _LEAST, _MOST = 1e-3, 1e-8, 80  # relative steps, and number of runs
_FASTER, _SLOWER = 1.5, 0.3  # next step after one that hunts, and after one that does not


@dataclass(frozen=True, eq=False)
class FollowedMotion:
    """A motion that hunts at one sampling period.

    Attributes
    ----------
    motions : SettlingMotions
        What settling means.
    period : float or None
        Value of its second parameter.
    """

    motions: SettlingMotions
    period: float | None

    @cached_property
    def _program(self) -> Program:
        motions = self.motions
        return prepare(motions.scene.wanting({"path": Trajectory()}), motions.tolerance, motions.route())

    def from_starts(self, value: float) -> dict[str, float] | None:
        """Return the state to which one of the starts has led that does not settle, None if all do."""
        hunts = (start for start in self.motions.starts if not self._settles(value, start))
        return next((self._later(value, start) for start in hunts), None)

    def lowest(self, value: float, least: float, state: dict[str, float]) -> tuple[float, float, dict[str, float]]:
        """Return the largest value at which the motion settles, the next at which it does not, and its state there.

        Parameters
        ----------
        value : float
            At which it hunts.
        least : float
            Lowest value to look at.
        state : dict of str to float
            At a sampling instant.
        """
        step, below = _FIRST, least
        for _ in range(_MOST):
            new = max(value * (1 - step), least)
            if new >= value or (below > least and step < _LEAST):
                break
            if self._settles(new, state):
                below, step = max(below, new), _SLOWER * step
            else:
                value, step = new, _FASTER * step
                state = self._later(value, state)
                step = min(step, 0.5 * (1 - below / value)) if below > least else step
        return below, value, state

    def _settles(self, value: float, start: Mapping[str, float]) -> bool:
        periods = None if self.period is None else np.array([self.period])
        return bool(self.motions.rests(np.array([value]), periods, [start])[0])

    def _later(self, value: float, start: Mapping[str, float]) -> dict[str, float]:
        """Return the state after the last whole number of sampling periods."""
        motions, scene = self.motions, self.motions.scene
        changes = {motions.name: value} | ({} if self.period is None else {str(motions.period): self.period})
        run = self._program.run(changes, dict(start))
        numbers = {s: changes.get(s.name, v) for s, v in scene.values.items()}
        periods = [float(sp.sympify(h.every).subs(numbers)) for h in scene.held if h.every is not None]
        last = run.t_final
        if periods:
            last = max(periods) * np.floor(last / max(periods) * (1 - 1e-9))
        return dict(zip(run.names, run.before(last).tolist(), strict=True))
