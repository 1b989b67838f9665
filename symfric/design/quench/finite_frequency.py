"""Correction of a quench for its finite frequency: the amplitude at which the full model is at the margin."""

from dataclasses import replace

import numpy as np

from symfric.design.quench.belt_scene import AMPLITUDE, FREQUENCY, SPEED_NAME, Belt
from symfric.errors import NotFound
from symfric.orbits.flow_map import flow_of
from symfric.orbits.passages import Passage
from symfric.orbits.shooting import ShootingSystem, TestFunction, solve

_FAR = 0.2  # relative correction of the amplitude above which it belongs to another orbit


def corrected(belt: Belt, excitation: tuple[float, float], v_b: float, rest: float, margin: float) -> float | None:
    """Return the amplitude at which phase-plane areas about the forced orbit of the full model shrink by the margin.

    Parameters
    ----------
    belt : Belt
    excitation : (float, float)
        a and Omega of the averaged optimum.
    v_b : float
        Critical belt speed at this optimum.
    rest : float
        Quasi-equilibrium of the averaged model.
    margin : float
        Least damping.

    Returns
    -------
    float or None
        None if the full model has no such orbit; with sticking, areas shrink to zero.

    Notes
    -----
    The unknowns are the start of the orbit and a; the last equation is ``ln det Phi = -margin T/m`` with the monodromy
    matrix Phi over the forcing period T: at margin 0 the Neimark-Sacker point, Thomsen's bound at finite frequency.
    """
    a, Omega = excitation
    scene = belt.single.where({AMPLITUDE: a, FREQUENCY: Omega, SPEED_NAME: v_b})
    flow = flow_of(scene, (AMPLITUDE,))
    values = {s.name: v for s, v in scene.parameter_values().items()}
    assert flow.period is not None
    target = margin * flow.period(values) / belt.mass

    def shrinks(z: np.ndarray, passage: Passage) -> float:
        area = abs(np.linalg.det(passage.by_start))
        return np.log(area) + target if area > 0 else np.nan

    start = np.array([rest, 0.0]) + belt.fast_start(a, Omega)
    forced = ShootingSystem(flow, values, multiple=1, widths=(a,))
    try:
        orbit = solve(forced, forced.pack(start, 0.0, values), np.array([0.0, 0.0, 1.0]))
        amplitude = solve(replace(forced, test=TestFunction(shrinks)), orbit.z).z[-1]
    except (NotFound, np.linalg.LinAlgError):
        return None
    return float(amplitude) if abs(amplitude - a) < _FAR * a else None
