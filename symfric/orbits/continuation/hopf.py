"""Ends of a branch of limit cycles at Hopf points, and branches that start there."""

from functools import cache

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.model.scene import Scene
from symfric.orbits.shooting import Point, ShootingSystem, solve
from symfric.orbits.sizes import filled
from symfric.search import zero
from symfric.theory import equilibrium
from symfric.theory.hopf import HopfPoint, hopf
from symfric.theory.stability import stability

_SHARE = 0.02  # slip amplitude of the first cycle, relative to the slips at the equilibrium
_GENTLE = 1e-3  # first amplitude, relative to the one at which cubic terms give a growth rate equal to the frequency
_REACH = 3.0  # half width of the bracket of a Hopf point, in units of its extrapolated distance


def birth(scene: Scene, system: ShootingSystem, at: HopfPoint) -> tuple[Point, np.ndarray]:
    """Return a small cycle near a Hopf point, and the direction in which the cycles grow, (n_z,).

    The eigenvector belongs to the multiplier i of the flow map over a quarter of the period.
    """
    if not system.free:
        raise SceneError("a scene whose forces depend on time has no Hopf point; start from one of its orbits")
    flow, period = system.flow, 2 * np.pi / at.omega
    x = np.array(equilibrium(scene.where({at.parameter: at.value})).x)
    values = {**system.values, at.parameter: at.value}
    multipliers, vectors = np.linalg.eig(flow.run(x, values, 0.25 * period).by_start)
    mode = vectors[:, int(np.argmin(np.abs(multipliers - 1j)))]
    mode = mode / mode[0]  # `hopf` has checked that this entry is not zero
    slips = flow.slips(x, values)
    swing = np.max([np.abs(flow.slips(x + way, values) - slips) for way in (mode.real, mode.imag)], axis=0)
    size = np.min(_SHARE * np.abs(slips)[swing > 0] / swing[swing > 0], initial=np.inf)
    if at.first_lyapunov != 0:
        size = min(size, _GENTLE * np.sqrt(at.omega / abs(at.first_lyapunov)))
    if not np.isfinite(size):
        raise NotFound("no cycle grows from the Hopf point: the vibration is linear there")
    direction = np.concatenate([mode.real, np.zeros(2)])
    guess = np.concatenate([x + size * mode.real, [period, at.value]])
    normal = np.append(mode.real / filled(np.abs(mode), len(scene.system.q)) ** 2, [0.0, 0.0])
    return solve(system, guess, normal), direction


def vanishing_point(scene: Scene, parameter: str, values: np.ndarray, sizes: np.ndarray, period: float) -> float | None:
    """Return the value of the parameter at the Hopf point at the end of a branch, None if there is none.

    Steady sliding may be unstable on both sides of it, by another pair of eigenvalues.

    Parameters
    ----------
    scene : Scene
    parameter : str
    values, sizes : ndarray, shape (2,)
        Parameter and size of the last two cycles; the square of the size is nearly linear in the parameter.
    period : float
        Of the last cycle.
    """
    squares = sizes**2
    guess = values[1] - squares[1] * (values[1] - values[0]) / (squares[1] - squares[0])
    reach = _REACH * max(abs(guess - values[1]), 1e-6 * abs(guess))

    @cache
    def eigenvalues(value: float) -> np.ndarray:
        return stability(scene.where({parameter: value})).eigenvalues

    def growth(value: float) -> float:
        """Return the growth rate of the vibration of steady sliding with the frequency of the cycle."""
        rates = eigenvalues(value)
        return float(rates[np.argmin(np.abs(rates.imag - 2 * np.pi / period))].real)

    ends = guess - reach, guess + reach
    try:
        if np.sum(eigenvalues(ends[0]).real > 0) != np.sum(eigenvalues(ends[1]).real > 0):  # known long before a search
            return hopf(scene, parameter, ends).value
    except (NotFound, SceneError):
        pass
    try:
        return zero(growth, *ends, xtol=1e-14)
    except (NotFound, SceneError, ValueError):  # the last one: no change of sign
        return None
