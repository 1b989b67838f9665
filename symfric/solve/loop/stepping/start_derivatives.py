"""Derivatives over the start of a contact in the plane.

The direction of the slip w is given there, and it has derivatives of its own: its part across w is that of the slip
over |w|, so that the equations of the derivatives V have friction across the slip of ``B/|w|``, without bound at the
start. Their solution is smooth, as the slips are. With the motion of the start at the nodes of Radau, all behind it,

    sum_j D_ij (V_j - V_0) = T (A_i V_i + f_i)

for the derivatives V_i at the nodes, the differentiation matrix D and the length T of the start: collocation, which is
stable for any stiffness. A and f come from the rates of the slipping contact, linear in V, at unit vectors and at zero.

References
----------
Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.5: the methods Radau IIA.
"""

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.arithmetic import value
from symfric.solve.loop.stepping.calls import probe_trial
from symfric.solve.loop.stepping.elimination import solve_in_place
from symfric.solve.loop.workspace import LoopArrays


@compiled
def vary_start(w: LoopArrays, n_x: int, time: float) -> None:
    """Write the series of the derivatives over the start of this length into ``w.c``, with those of observables.

    The contacts slip in the present mode; the series of their motion are in ``w.c``. Second derivatives, which hold
    without events only, are not among them.
    """
    f, n_s = w.starts, w.limits.directions
    n_y, d = n_x // (1 + w.limits.varied), f.nodes.size - 1
    n = d * n_y
    for a in range(n):
        for b in range(n + n_s):
            f.equations[a, b] = 0.0
    for i in range(d):
        _equate(w, n_x, i, time)
    solve_in_place(f.equations, n, n_s)
    for s in range(n_s):
        for r in range(n_y):
            row, power = n_y + s * n_y + r, 1.0
            for k in range(1, w.c.shape[1]):
                total = 0.0
                power *= time
                if k <= d:
                    for j in range(d):
                        total += f.powers[k, j + 1] * f.equations[j * n_y + r, n + s]
                w.c[row, k] = total / power if power > 0.0 else 0.0
    _observe(w, n_x, time)


@compiled
def _equate(w: LoopArrays, n_x: int, i: int, time: float) -> None:
    """Write the equations of node i + 1; behind the matrix their right sides."""
    f, n_s = w.starts, w.limits.directions
    n_y, d, now = n_x // (1 + w.limits.varied), f.nodes.size - 1, w.step.end
    first, n = i * n_y, d * n_y
    _move(w, n_x, f.nodes[i + 1] * time)
    for r in range(n_y, n_x):
        now[r] = 0.0
    probe_trial(w)
    for s in range(n_s):
        for r in range(n_y):
            f.equations[first + r, n + s] = time * w.probe[n_y + s * n_y + r, 1]
    for begin in range(0, n_y, n_s):
        count = min(n_s, n_y - begin)
        for s in range(count):
            now[n_y + s * n_y + begin + s] = 1.0
        probe_trial(w)
        for s in range(count):
            now[n_y + s * n_y + begin + s] = 0.0
            for r in range(n_y):
                own = f.equations[first + r, n + s]  # without the unit vector
                f.equations[first + r, first + begin + s] = own - time * w.probe[n_y + s * n_y + r, 1]
    for s in range(n_s):
        for r in range(n_y):
            for k in range(n_y):
                f.equations[first + r, n + s] -= f.equations[first + r, first + k] * w.y[n_y + s * n_y + k]
    for j in range(d):
        for r in range(n_y):
            f.equations[first + r, j * n_y + r] += f.rates[i, j + 1]


@compiled
def _move(w: LoopArrays, n_x: int, t: float) -> None:
    """Set the motion of the trial state to that after a time t."""
    for r in range(n_x // (1 + w.limits.varied)):
        w.step.end[r] = value(w.c[r], w.c.shape[1] - 1, t)
    w.step.end[n_x] = w.y[n_x] + (w.clock.t_low + t)


@compiled
def _observe(w: LoopArrays, n_x: int, time: float) -> None:
    """Write the series of the derivatives of observables, through their values at the nodes."""
    f, n_s = w.starts, w.limits.varied
    n_y, d, order = n_x // (1 + n_s), f.nodes.size - 1, w.c.shape[1] - 1
    count = w.limits.followed * n_s
    last = w.c.shape[0] - count
    if count == 0:
        return
    for i in range(d):
        t = f.nodes[i + 1] * time
        _move(w, n_x, t)
        for r in range(n_y, n_x):
            w.step.end[r] = value(w.c[r], order, t)
        probe_trial(w)
        for e in range(count):
            f.rows[e, i] = w.probe[last + e, 0]
    for e in range(count):
        power = 1.0
        for k in range(order + 1):
            total = 0.0
            if k < d:
                for i in range(d):
                    total += f.inner[k, i] * f.rows[e, i]
            w.c[last + e, k] = total / power if power > 0.0 else 0.0
            power *= time
