"""Energy balance along a computed motion: a check independent of the solver's error estimate."""

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
import sympy as sp

from symfric.lower.energy import energy_functions
from symfric.model.numeric import gauss_legendre
from symfric.model.outputs import Trajectory
from symfric.model.scene import Scene
from symfric.solve.impact_work import struck
from symfric.solve.input_segments import segments
from symfric.solve.kicks import brought
from symfric.solve.lowered import LoweredScene
from symfric.time_limit import check_time

if TYPE_CHECKING:
    from symfric.solve.run import Run

_AT_ONCE = 2**20  # numbers of all states at all nodes that are computed together: 8 MB
_NODES = 16  # quadrature nodes in every step; a step spans a fraction of the radius of convergence


def energy_residual(run: "Run") -> float:
    r"""Return the largest imbalance of energy along a run, relative to the largest energy converted.

    .. math:: T(t) - T(0) - \int_0^t \left(u^T f + \tfrac12 u^T \dot M u + \lambda^T J u\right) dt
        - \sum \tfrac12 (u^+ + u^-)^T M (u^+ - u^-)

    with T the kinetic energy, f all forces but the contacts (potential, damping and input together) and lambda the
    friction forces, and the sum over the resets up to t, taken at the end of every step. Kinetic energy comes from the
    states, the powers from the equations of motion evaluated on the dense output and the kicks from the expressions of
    the resets, so a wrong mode, a missed event or a jump of the state that no reset makes shows. An impact does the
    work of its impulses, of which none may pull.

    Parameters
    ----------
    run : Run
        If it kept no trajectory, it is repeated with one.

    Returns
    -------
    float
        Dimensionless; about the tolerance for a correct run.
    """
    if run.raw.path is None:
        run = run.settings.build(LoweredScene(run.scene.wanting({"path": Trajectory()})), run.tolerance).run()
    return imbalance(run, *energy_functions(run.scene), run.scene.numbers())


def imbalance(run: "Run", power: ca.Function, kinetic: ca.Function, numbers: Mapping[sp.Symbol, float]) -> float:
    """Return the residual of a run that kept its trajectory.

    Parameters
    ----------
    run : Run
    power, kinetic : casadi.Function
        `energy_functions` of its scene; they serve for any values of the parameters.
    numbers : mapping of Symbol to float
        Parameters of the run.
    """
    path = run.path
    if path.coefficients.shape[0] == 0:
        return 0.0
    parameters_at = partial(_parameters, run.base, numbers)
    kicks, arrived = brought(run, kinetic, numbers, parameters_at)
    kicks = kicks + struck(run, kinetic, parameters_at, arrived)
    worst, largest, start, work, moved = 0.0, 1e-300, 0.0, 0.0, 0.0
    steps = max(1, _AT_ONCE // (_NODES * path.coefficients.shape[1]))
    for first in range(0, len(path.h), steps):
        check_time()
        piece = slice(first, first + steps)
        parameters, applied, contact = _powers(run, power, numbers, piece)
        share = path.h[piece, None] * gauss_legendre(_NODES)[1]
        worked = np.cumsum([work, *((share * (applied + contact)).sum(axis=1) + kicks[piece])])[1:]
        shifted = np.cumsum([moved, *((share * applied).sum(axis=1) + kicks[piece])])[1:]
        after = path.coefficients[first + 1 : first + 1 + len(worked), :, 0].T
        ends = np.column_stack([path.coefficients[first, :, 0], after, *([run.final] * (len(worked) - after.shape[1]))])
        energy = np.array(kinetic(ends, parameters[:, :1])).ravel()
        start = energy[0] if first == 0 else start
        worst = np.maximum(worst, np.max(np.abs(energy[1:] - start - worked)))
        largest = max(largest, np.max(energy), np.max(np.abs(shifted)), np.max(np.abs(kicks[piece]), initial=0.0))
        work, moved = worked[-1], shifted[-1]
    return float(worst / largest)


def _powers(run: "Run", power: ca.Function, numbers: Mapping[sp.Symbol, float], piece: slice) -> tuple[np.ndarray, ...]:
    """Return parameters (n_p, n), and the powers of applied and contact forces (steps, nodes), over some steps."""
    path = run.path
    coefficients, begins, h = path.coefficients[piece], path.t[piece], path.h[piece]
    inner = h[:, None] * gauss_legendre(_NODES)[0]
    times = begins[:, None] + inner
    states = coefficients[:, None, :, -1]
    for k in range(coefficients.shape[2] - 2, -1, -1):
        states = states * inner[:, :, None] + coefficients[:, None, :, k]
    states = states.reshape(-1, coefficients.shape[1]).T
    parameters = _parameters(run.base, numbers, np.repeat(begins, _NODES))
    modes = np.repeat(path.mode[piece], _NODES, axis=0).T
    applied, contact = (
        np.array(e).reshape(times.shape) for e in power(states, times.reshape(1, -1), parameters, modes)
    )
    return parameters, applied, contact


def _parameters(scene: Scene, numbers: Mapping[sp.Symbol, float], times: np.ndarray) -> np.ndarray:
    """Return parameters, then start, value and slope of every input, at each time: shape (n_p, n_t)."""
    fixed = np.array([numbers[s] for s in scene.parameters])
    edges, data = segments(list(scene.inputs.values()), scene.horizon)
    row = np.clip(np.searchsorted(edges, times, side="right") - 1, 0, data.shape[0] - 1)
    return np.vstack([np.repeat(fixed[:, None], times.size, axis=1), data[row].T])
