"""Kinetic energy that impacts of contacts that open take or bring along a run, for the balance of its energy."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from scipy.optimize import nnls

from symfric.lower.impacts import impact_function
from symfric.lower.mode_layout import OPEN

if TYPE_CHECKING:
    from symfric.solve.run import Run

_TOUCHES = (
    1e-8  # gap, relative to its terms and to the way at its rate during the run, below which a contact may strike
)
_JUMP = 1e-13  # least jump of a velocity, relative to the largest one, that may be an impact


def struck(
    run: "Run",
    kinetic: ca.Function,
    parameters: Callable[[np.ndarray], np.ndarray],
    arrived: Mapping[int, np.ndarray],
) -> np.ndarray:
    r"""Return the kinetic energy that impacts bring at the end of every step of a run, shape (n,); losses are negative.

    The change of the velocities is explained by impulses along the normals and the slips of contacts that touch, none
    of them pulling: :math:`u^+ - u^- = M^{-1} J^T \Lambda`. Where several impulses do so, their work is the same. What
    is left of the change is no impact and shows in the balance.

    Parameters
    ----------
    run : Run
        With its trajectory.
    kinetic : casadi.Function
        See `symfric.lower.energy.energy_functions`.
    parameters : callable
        Returns parameters and inputs at times (n,), shape (n_p, n).
    arrived : mapping of int to ndarray, shape (n_x,)
        States after resets at the end of a step.
    """
    path, scene = run.path, run.base
    work = np.zeros(path.t.size)
    if not scene.contacts_that_open or path.t.size < 2:
        return work
    impact, owners, second = impact_function(scene)
    n_u, n = len(scene.system.q), len(owners)
    data = np.zeros(impact.numel_in(3))
    names = impact.name_out()
    stops = iter(range(path.mode.shape[1] - owners.count(-1), path.mode.shape[1]))
    closed = path.mode[:, [line if line >= 0 else next(stops) for line in owners]] != OPEN
    velocities = slice(n_u, 2 * n_u)
    ends, starts = path.ends(np.arange(path.t.size - 1)), path.coefficients[1:, :, 0].T
    jumps = np.max(np.abs(starts - ends)[velocities], axis=0)
    for k in np.flatnonzero(jumps > _JUMP * np.max(np.abs(starts[velocities]))).tolist():
        before, after, t = arrived.get(k, ends[:, k]), starts[:, k], path.t[k + 1]
        p = parameters(np.array([t]))[:, 0]
        quantities = dict(zip(names, (np.array(e).ravel() for e in impact(before, t, p, data)), strict=True))
        touching = quantities["gap"] <= _TOUCHES * (quantities["size"] + np.abs(quantities["rate"]) * run.t_final)
        touching |= closed[k] | closed[k + 1]
        spread = quantities["spread"].reshape(-1, n_u).T
        n_c = spread.shape[1] - n
        near = {line for line, close in zip(owners, touching, strict=True) if close}
        rubs = [i in near or (i in second and i - 1 in near) for i in range(n_c)]
        columns = np.hstack([spread[:, :n_c][:, rubs], -spread[:, :n_c][:, rubs], spread[:, n_c:][:, touching]])
        if not columns.size:
            continue
        lengths = np.linalg.norm(columns, axis=0)
        columns = columns[:, lengths > 0] / lengths[lengths > 0]
        reached = before.copy()
        reached[velocities] += columns @ nnls(columns, (after - before)[velocities])[0]
        work[k] = float(kinetic(reached, p) - kinetic(before, p))
    return work
