"""The growth rate of small vibration about steady sliding, at the worst speed of a range."""

from collections.abc import Callable
from typing import Any

import numpy as np
import sympy as sp

from symfric.design.damper.cycles import Requirement
from symfric.locks import SYMBOLIC, alone
from symfric.lower.law_features import features
from symfric.model.laws import Law
from symfric.model.scene import Scene
from symfric.search import ROUNDING, minimum_near, valleys, zero, zeros
from symfric.theory.equilibrium import solve
from symfric.theory.sliding import field_of
from symfric.theory.stability import linearise

SPEEDS = 33  # equally spaced starting speeds, besides those at features of the laws
_POLISHED = 3  # number of local maxima that are polished
_FALLS = 3  # steepest falls of the laws at which cycles are sought


class Growth:
    """The growth rate of small vibration about steady sliding, as a function of speed and damping.

    Parameters
    ----------
    scene : Scene
    r : Requirement
    """

    def __init__(self, scene: Scene, r: Requirement):
        self._scene, self._r = scene, r
        self._symbols = scene.parameter(r.speed), scene.parameter(r.name)
        self._field = field_of(scene, vary=self._symbols)
        numbers, self._others = scene.numbers(), scene.parameter_values()
        self._x = np.array([numbers[s] for s in self._field.states])
        self.speeds = speeds_of(scene, r)

    def at(self, speed: float, damping: float) -> float:
        """Return the largest real part of the eigenvalues, 1/time."""
        values = {**self._others, self._symbols[0]: speed, self._symbols[1]: damping}
        p = self._field.vector(values)
        self._x = self._equilibrium(p)
        return float(np.max(np.linalg.eigvals(linearise(self._field, p, self._x)[3]).real))

    def _equilibrium(self, p: np.ndarray) -> np.ndarray:
        """Return steady sliding by Newton's method from the last one, or by a new search if that fails."""
        field, x = self._field, self._x.copy()
        free = np.r_[0 : field.n, 2 * field.n : x.size]
        for _ in range(6):
            signs = field.directions(x, p)
            slopes, value = field.jacobian(x, p, signs)[:, free], field.value(x, p, signs)
            if not (np.all(np.isfinite(slopes)) and np.all(np.isfinite(value))):
                break
            step = np.linalg.lstsq(slopes, value, rcond=None)[0]
            x[free] -= step
            if np.max(np.abs(step)) <= 1e-13 * np.max(np.abs(x)):
                return x
        return solve(field, p, self._x)

    def worst(self, damping: float, polished: bool = True) -> tuple[float, float]:
        """Return the largest growth rate over the speeds, and its speed; on the grid only unless `polished`."""
        v = self.speeds
        rates = np.array([self.at(float(e), damping) for e in v])
        k = int(np.argmax(rates))
        best = float(rates[k]), float(v[k])
        for i in valleys(-rates)[: _POLISHED if polished else 0]:
            top = minimum_near(lambda e: -self.at(float(e), damping), v, i, xatol=1e-10 * v[i + 1])
            best = max(best, (-top.value, top.place))
        return best

    def least(self, speed: float) -> float:
        """Return the damping at which sliding becomes stable at one speed; NaN outside the bounds."""
        low, high = self._r.bounds
        if self.at(speed, low) * self.at(speed, high) > 0:
            return np.nan
        return zero(lambda value: self.at(speed, value), low, high, xtol=1e-12 * high, rtol=ROUNDING)


def speeds_of(scene: Scene, r: Requirement) -> np.ndarray:
    """Return speeds over the range, including those at which the slip of a contact is at a feature of its law."""
    low, high = max(r.speeds[0], 1e-9 * r.speeds[1]), r.speeds[1]
    grid, reached = np.linspace(low, high, SPEEDS), []
    for law, slip in _sliding(scene, r):
        slips = slip(grid)
        ends = float(np.min(np.abs(slips))), float(np.max(np.abs(slips)))
        if ends[0] < ends[1]:
            for v in features(law, *ends):
                reached += _reaching(slip, grid, v)
    return np.unique([*grid, *reached])


def steepest_falls(scene: Scene, r: Requirement) -> np.ndarray:
    """Return the few speeds inside the range at which a law falls steepest."""
    low, high = max(r.speeds[0], 1e-9 * r.speeds[1]), r.speeds[1]
    grid, falls = np.linspace(low, high, SPEEDS), []
    for law, slip in _sliding(scene, r):
        slips = np.abs(slip(grid))
        if np.min(slips) < np.max(slips):
            # the slope is least where the second derivative changes its sign, or at a break of the law
            at = features(law, float(np.min(slips)), float(np.max(slips)), orders=(2,))
            step = 1e-7 * np.max(slips)
            slopes = [(law(v + step) - law(v - step)) / (2 * step) for v in at]
            falls += [(slope, e) for slope, v in zip(slopes, at, strict=True) for e in _reaching(slip, grid, v)]
    return np.array([v for slope, v in sorted(falls)[:_FALLS] if slope < 0])


@alone(SYMBOLIC)
def _sliding(scene: Scene, r: Requirement) -> list[tuple[Law, Callable[[np.ndarray], np.ndarray]]]:
    """Return the law of every contact, in numbers, and its slip in steady sliding as a function of the speed."""
    given = scene.numbers()
    laws: list[tuple[Law, Callable[[np.ndarray], np.ndarray]]] = []
    symbol = scene.parameter(r.speed)
    still = dict.fromkeys((*scene.system.u, *scene.system.rows), 0)
    for contact in scene.contacts:
        law = contact.law.where({k: given[k] for k in contact.law.free_symbols if k in given})
        slip = sp.sympify(contact.slip).subs(still).subs({k: v for k, v in given.items() if k != symbol})
        if not law.free_symbols and slip.free_symbols == {symbol}:
            laws.append((law, np.vectorize(sp.lambdify(symbol, slip, "numpy"), otypes=[float])))
    return laws


def _reaching(slip: Callable[..., Any], grid: np.ndarray, v: float) -> list[float]:
    """Return the speeds of the range at which a contact has the slip v or -v."""
    speeds: list[float] = []
    for sign in (1.0, -1.0):

        def gap(e: Any, at: float = sign * v) -> Any:
            return slip(e) - at

        speeds += zeros(gap, grid, gap(grid), xtol=2e-12, rtol=ROUNDING)
    return speeds
