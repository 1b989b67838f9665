"""Kinetic energy that impacts of contacts that open take or bring along a run, for the balance of its energy."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from symfric.lower.impacts import impact_function

if TYPE_CHECKING:
    from symfric.solve.run import Run

_TOUCHES = 1e-8  # gap, relative to the sizes of its terms and the way of a step, below which a contact may strike


def struck(
    run: "Run",
    kinetic: ca.Function,
    parameters: Callable[[np.ndarray], np.ndarray],
    arrived: Mapping[int, np.ndarray],
) -> np.ndarray:
    r"""Return the kinetic energy that impacts bring at the end of every step of a run, shape (n,); losses are negative.

    The change of the velocities is explained by impulses along the normals and the slips of contacts that touch, none
    of them pulling: :math:`u^+ - u^- = M^{-1} J^T \Lambda`. What is left of it is no impact and shows in the balance.

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
    impact, owners = impact_function(scene)
    n_u, n = len(scene.system.q), len(owners)
    data = np.zeros(impact.numel_in(3))
    names = impact.name_out()
    for k in (path.jumps - 1).tolist():
        before = arrived.get(k, path.ends(np.array([k]))[:, 0])
        after, t = path.coefficients[k + 1, :, 0], path.t[k + 1]
        p = parameters(np.array([t]))[:, 0]
        found = dict(zip(names, (np.array(e).ravel() for e in impact(before, t, p, data)), strict=True))
        touching = found["gap"] <= _TOUCHES * (found["size"] + np.abs(found["rate"]) * path.h[k])
        spread = found["spread"].reshape(-1, n_u).T
        n_c = spread.shape[1] - n
        rubs = [i in {line for line, near in zip(owners, touching, strict=True) if near} for i in range(n_c)]
        columns = np.flatnonzero(np.append(rubs, touching))
        if not columns.size:
            continue
        impulses = np.linalg.lstsq(spread[:, columns], (after - before)[n_u : 2 * n_u], rcond=1e-12)[0]
        impulses = np.where(columns >= n_c, np.maximum(impulses, 0.0), impulses)
        reached = before.copy()
        reached[n_u : 2 * n_u] += spread[:, columns] @ impulses
        work[k] = float(kinetic(reached, p) - kinetic(before, p))
    return work
