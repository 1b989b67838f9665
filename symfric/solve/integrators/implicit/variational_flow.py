"""Motion of continuous laws with its derivatives, by CVODES: one implicit step for both.

With ``V = dy/ds`` for every direction s, ``V' = df/dy V + df/ds`` is integrated beside ``y' = f``, with the exact
Jacobian of both together. Where a slip turns, f has a kink but no jump, so V goes on continuously: the saltation
``(f- - f+) tau`` is zero. V' jumps there, in the layers of stiff bristles by so much that no step passes a fine
tolerance: for the derivatives of these states alone it is coarser, since their errors decay within the layer.
"""

from collections import OrderedDict
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symfric.locks import SYMBOLIC
from symfric.solve.integrators.implicit.stretch import Stretch, sizes_of, stretched
from symfric.solve.integrators.integrated_piece import SegmentStart

_STEPS, _DEEPEST = (
    20_000,
    12,
)  # steps of the integrator between restarts, and halvings of a motion until it needs no more
_STRETCHED = 1e6  # scaled length of a motion, since CasADi takes times less than 1e-9 apart for one
_KEPT = 16  # most integrators kept, one for each grid of times


@dataclass(frozen=True, eq=False)
class Scales:
    """Scales of the derivatives of a motion.

    Attributes
    ----------
    unit : ndarray, shape (n_s,)
        Sizes of the quantities to differentiate by.
    coarser : ndarray, shape (n, 1)
        Tolerance of the derivatives of each state and integral relative to that of the motion.
    """

    unit: np.ndarray
    coarser: np.ndarray


class VariationalFlow:
    """The flow of a field with its derivatives; for one run at a time.

    Parameters
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)`` without jumps; the first rows are integrated too.
    n_integrals : int
    chosen : ndarray, shape (n_p, n_s)
        1 for the parameter of each direction that is one.
    stretch : Stretch, optional
        Change of variables.
    """

    def __init__(self, field: ca.Function, n_integrals: int, chosen: np.ndarray, stretch: Stretch | None) -> None:
        self._field, self._n_integrals, self._stretch = stretched(field, stretch), n_integrals, stretch
        self._chosen = chosen
        self._dae = self._equations(field.nnz_in(0) + n_integrals, chosen.shape[1])
        if stretch:
            self._enter, self._leave = (self._changed(e) for e in (stretch.inner, stretch.outer))
        self._made: OrderedDict[tuple[bytes, float], ca.Function] = OrderedDict()
        self.rough: ca.Function | None = None  # for the sizes of a motion
        self.steps = 0

    def _equations(self, n: int, n_s: int) -> dict[str, ca.SX]:
        """Return the equations of the scaled variables, derivatives behind states, for `casadi.integrator`."""
        field, chosen = self._field, self._chosen
        n_x = field.nnz_in(0)
        state, V, time = ca.SX.sym("state", n), ca.SX.sym("V", n, n_s), ca.SX.sym("time")
        p, m, size = ca.SX.sym("p", field.nnz_in(2)), ca.SX.sym("m", field.nnz_in(3)), ca.SX.sym("size", n)
        unit, coarser = ca.SX.sym("unit", n_s), ca.SX.sym("coarser", n)
        begin, length = ca.SX.sym("begin"), ca.SX.sym("length")
        inside = (state * size)[:n_x]
        rate, _, rows = field(inside, begin + length * time, p, m)
        integrals = rows[: self._n_integrals] if self._n_integrals else ca.SX(0, 1)
        ode = length * ca.vertcat(rate, integrals) / size
        scale = ca.repmat(coarser, 1, n_s)
        by_value = ca.jacobian(ode, p) @ (chosen * ca.repmat(unit.T, chosen.shape[0], 1))
        varied = (ca.jacobian(ode, state) @ (V * scale) + by_value) / scale
        data = ca.vertcat(p, m, size, unit, coarser, begin, length)
        return {"x": ca.vertcat(state, ca.vec(V)), "t": time, "p": data, "ode": ca.vertcat(ode, ca.vec(varied))}

    def _changed(self, change: ca.Function) -> ca.Function:
        """Return ``(y, t, p, V) -> V`` for the derivatives of the variables that a change gives."""
        y, t, p = (ca.SX.sym(name, change.nnz_in(k)) for k, name in enumerate(("y", "t", "p")))
        V, other = ca.SX.sym("V", y.numel(), self._chosen.shape[1]), change(y, t, p)
        by = ca.jacobian(other, y) @ V + ca.jacobian(other, p) @ self._chosen
        return ca.Function("changed", [y, t, p, V], [ca.densify(by)])

    def follow(
        self, start: SegmentStart, V: np.ndarray, scales: Scales, times: np.ndarray, tolerance: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return states and derivatives at some times.

        Parameters
        ----------
        start : SegmentStart
        V : ndarray, shape (n, n_s)
            Derivatives of states and integrals at the start.
        scales : Scales
        times : ndarray, shape (n_t,)
            Increasing, all behind the start.
        tolerance : float
            Of a step.

        Returns
        -------
        ndarray, shape (n, n_t); ndarray, shape (n_t, n, n_s)

        Raises
        ------
        RuntimeError
            If the integrator fails.
        """
        followed = self._between(start, V, scales, times, tolerance, 0)
        if not all(np.all(np.isfinite(e)) for e in followed):
            raise RuntimeError("the motion left the finite numbers")
        return followed

    def _between(
        self, start: SegmentStart, V: np.ndarray, scales: Scales, times: np.ndarray, tolerance: float, depth: int
    ) -> tuple[np.ndarray, np.ndarray]:
        try:
            return self._uninterrupted(start, V, scales, times, tolerance)
        except RuntimeError:
            if depth >= _DEEPEST:
                raise
        middle = (start.t + times[-1]) / 2
        early = times < middle
        state, slopes = self._between(start, V, scales, np.append(times[early], middle), tolerance, depth + 1)
        there = replace(start, t=middle, state=state[:, -1])
        then = self._between(there, slopes[-1], scales, times[~early], tolerance, depth + 1)
        return np.column_stack([state[:, :-1], then[0]]), np.concatenate([slopes[:-1], then[1]])

    def _uninterrupted(
        self, start: SegmentStart, V: np.ndarray, scales: Scales, times: np.ndarray, tolerance: float
    ) -> tuple[np.ndarray, np.ndarray]:
        n_x, size, state = self._field.nnz_in(0), start.size, start.state
        if self._stretch:
            size = sizes_of(self._stretch, size)
            V = np.concatenate([np.array(self._enter(state[:n_x], start.t, start.p, V[:n_x])), V[n_x:]])
            state = self._stretch.inside(state, start.t, start.p)
        unit, coarser = scales.unit, scales.coarser
        # V in units of states over those of the directions, so that one tolerance serves motion and derivatives
        scale = size[:, None] * coarser / unit
        length = times[-1] - start.t
        grid = (times - start.t) / length
        data = np.concatenate([start.p, start.m, size, unit, coarser[:, 0], [start.t, length / _STRETCHED]])
        integrator = self._integrator(grid, tolerance)
        try:
            scaled = np.array(integrator(x0=np.append(state / size, (V / scale).T), p=data)["xf"])
        finally:
            self.steps += integrator.stats().get("nsteps", 0)
        states = scaled[: size.size] * size[:, None]
        slopes = scaled[size.size :].T.reshape(times.size, unit.size, size.size).transpose(0, 2, 1) * scale
        if self._stretch:
            for k, t in enumerate(times):
                slopes[k, :n_x] = np.array(self._leave(states[:n_x, k], t, start.p, slopes[k, :n_x]))
            states = self._stretch.outside(states, times, start.p)
        return states, slopes

    def _integrator(self, grid: np.ndarray, tolerance: float) -> ca.Function:
        """Return the integrator for fractions of a time; those used last are kept."""
        key = grid.tobytes(), tolerance
        if key not in self._made:
            options = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": _STEPS, "show_eval_warnings": False}
            options["disable_internal_warnings"] = True  # of failures, which are answered by shorter parts
            with SYMBOLIC:
                made = ca.integrator("varied", "cvodes", self._dae, 0.0, (grid * _STRETCHED).tolist(), options)
            self._made[key] = made
            if len(self._made) > _KEPT:
                self._made.popitem(last=False)
        self._made.move_to_end(key)
        return self._made[key]
