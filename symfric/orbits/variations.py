"""Derivatives of a motion of many states by its start and parameters, along the recorded steps of one run.

Between events the variational equations are followed in channels, see `symfric.lower.channels` and
`symfric.orbits.gauss_steps`; at an event of the guard g the derivatives V jump by the saltation

    V+ = V- + (f- - f+) tau,   tau = -(dg/dy V + dg/ds)/g',

after which slips that stick are held at zero, see `symfric.lower.variational_equations`. A period costs as much as one
run and products of matrices with a few rows, whatever the number of states.
"""

import itertools
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from symfric.errors import NoRoute
from symfric.lower.automaton import Automaton
from symfric.lower.channels import Channels
from symfric.lower.constraint_forces import HOLDS
from symfric.lower.mode_layout import ModeLayout, contact_of
from symfric.orbits.gauss_steps import NODES, REACH, Coupling, Motion, advance, gauss, motion_of
from symfric.orbits.recorded_steps import Steps

_APART = 1e-6  # relative difference of event times up to which events count as simultaneous
_AGREES = 1e-9  # relative error of the slopes from channels
_SEED = 7  # of the points at which channels are compared; fixed, so that a scene always takes the same way


class Slopes(NamedTuple):
    """Derivatives along a motion.

    Attributes
    ----------
    end : ndarray, shape (n_x, n_s)
        Of the end by the start and the parameters.
    rows : ndarray, shape (n_r, n_s)
        Of the least local minima of the first rows; zero where there is none.
    doubtful : bool
        Whether an event has no derivatives.
    """

    end: np.ndarray
    rows: np.ndarray
    doubtful: bool


class Variations:
    """The variational equations of a scene from matrices.

    Parameters
    ----------
    automaton : Automaton
        Its parameters begin with those of the channels.
    channels : Channels
    parameters : sequence of str
        Parameters to differentiate by.
    n_rows : int
        Number of first rows with derivatives.

    Raises
    ------
    NoRoute
        If the channels do not give the slopes of the automaton.
    """

    def __init__(self, automaton: Automaton, channels: Channels, parameters: tuple[str, ...], n_rows: int):
        self._automaton, self._channels, self._n_rows = automaton, channels, n_rows
        field, layout = automaton.field, automaton.layout
        y, t, p, m = (ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in()))
        names = [s.name for s in automaton.parameters]
        self._chosen = [names.index(name) for name in parameters]
        rate, guards, rows = field(y, t, p, m)
        felt = ca.vertcat(guards, rows[:n_rows])
        seed, free = ca.SX.sym("seed", felt.numel()), [p[k] for k in self._chosen]
        row = ca.jtimes(felt, ca.vertcat(y, t, p), seed, True)
        n_x = y.numel()
        picked = ca.vertcat(row[: n_x + 1], *(row[n_x + 1 + k] for k in self._chosen))
        self._felt = ca.Function("felt", [y, t, p, m, seed], [ca.densify(picked)])
        by_value = ca.jacobian(rate, ca.vertcat(*free)) if free else ca.SX(n_x, 0)
        self._source = ca.Function("source", [y, t, p, m], [ca.densify(by_value)])
        w = automaton.gauge(y, t, p)[0]
        dragged = ca.jacobian(w, ca.vertcat(*free)) if free else ca.SX(w.numel(), 0)
        self._drag = ca.Function("drag", [y, t, p], [ca.densify(dragged)])
        self._jumps = None
        if automaton.transition:
            hit = ca.SX.sym("hit", layout.n_guards - layout.first_other)
            then = automaton.transition(y, t, p, m, hit, ca.SX.zeros(hit.numel()))[0]
            both = ca.jacobian(then, ca.vertcat(y, *free))
            self._jumps = ca.Function("jumps", [y, t, p, m, hit], [ca.densify(both)])
        v = ca.SX.sym("v", n_x)
        self._check(ca.Function("along", [y, t, p, m, v], [ca.densify(ca.jtimes(rate, y, v))]))

    def _check(self, along: ca.Function) -> None:
        """Compare the channels with derivatives of the equations, slipping and sticking."""
        rng, n_x, n_c = np.random.default_rng(_SEED), len(self._automaton.states), len(self._automaton.contacts)
        p = rng.uniform(0.5, 1.5, self._automaton.field.nnz_in(2))
        m = np.zeros(self._automaton.layout.n_mode)
        m[n_c : self._automaton.layout.first_variable] = 1.0
        for stuck in (None, *[i for i in range(n_c) if self._automaton.sticks[i]][:1]):
            if stuck is not None:
                m[stuck] = HOLDS
            y, v = rng.standard_normal(n_x), rng.standard_normal(n_x)
            free = self._channels.free(p[: self._own])
            B, U, R = self._channels.held(m, free)
            D = self._D(y[:, None], np.zeros(1), p, m)[0]
            product = free @ v + B @ (D @ (self._channels.rows @ v)) + U @ (R @ v)
            exact = np.array(along(y, 0.0, p, m, v)).ravel()
            if not np.max(np.abs(product - exact)) <= _AGREES * np.max(np.abs(exact)):
                raise NoRoute("the channels do not have the slopes of the equations")

    @property
    def _own(self) -> int:
        return self._channels.slopes.nnz_in(3)

    def _D(self, y: np.ndarray, t: np.ndarray, p: np.ndarray, m: np.ndarray) -> np.ndarray:
        """Return D at states (n_x, n) and times (n,), shape (n, n_phi, n_xi)."""
        slopes, n = self._channels.slopes, len(t)
        xi = self._channels.rows[: slopes.nnz_in(0)] @ y
        D = np.array(slopes(xi, y, t[None, :], _wide(p[: self._own], n), _wide(m, n)))
        return D.reshape(D.shape[0], n, -1).transpose(1, 0, 2)

    def along(self, steps: Steps, p: np.ndarray) -> Slopes:
        """Return the derivatives along a run with parameters p."""
        free = self._channels.free(p[: self._own])
        motion, n_x = motion_of(free), len(free)
        V = self._held(np.hstack([np.eye(n_x), np.zeros((n_x, len(self._chosen)))]), steps, 0, p)
        slopes, doubtful = np.zeros((self._n_rows, V.shape[1])), False
        places = _last_places(steps.places)
        for begin, end in _pieces(steps):
            inside = [(steps.t[k] + at * (steps.t[k + 1] - steps.t[k]), r) for r, (k, at) in places if begin <= k < end]
            coupled = self._channels.held(steps.mode[begin], free)
            time = steps.t[begin]
            for until, row in [*sorted(inside), (steps.t[end], None)]:
                V = self._smooth(motion, coupled, steps, (begin, end), (time, until), p, V)
                time = until
                if row is not None:
                    seed = self._automaton.layout.n_guards + row
                    slopes[row] = self._gain(
                        state_at(steps, np.array([time]))[:, 0], time, p, steps.mode[begin], seed, V
                    )[0]
            if end < len(steps.mode):
                V, doubt = self._jump(steps, end, p, V)
                doubtful = doubtful or doubt
        return Slopes(V, slopes, doubtful)

    def _smooth(
        self, motion: Motion, coupled: Any, steps: Steps, piece: Any, span: Any, p: np.ndarray, V: np.ndarray
    ) -> np.ndarray:
        """Return V after a time without events."""
        length = span[1] - span[0]
        if not length > 0:
            return V
        m, (B, U, R) = steps.mode[piece[0]], coupled
        rows = np.vstack([self._channels.rows, R])
        n_phi, n_xi, n_s = B.shape[1], len(self._channels.rows), len(self._chosen)
        share = int(np.count_nonzero((steps.t > span[0]) & (steps.t < span[1]))) + 1
        count = max(share, int(np.ceil(motion.fastest * length / REACH)))
        while True:
            t = span[0] + length / count * (np.arange(count)[:, None] + gauss()[0])
            y = state_at(steps, t.ravel())
            D = self._D(y, t.ravel(), p, m)
            more = float(np.max(np.linalg.norm(self._channels.rows @ B @ D, axis=(1, 2)), initial=0.0)) * length / REACH
            if count >= more:
                break
            count = int(np.ceil(more))
        used = np.flatnonzero(np.any(D != 0.0, axis=(0, 1)))
        slopes = np.zeros((len(D), n_phi + len(R), used.size + len(R)))
        slopes[:, :n_phi, : used.size] = D[:, :, used]
        slopes[:, n_phi:, used.size :] = np.eye(len(R))
        acting = np.any(slopes != 0.0, axis=(0, 2))
        rows = np.vstack([rows[used], rows[n_xi:]]) @ motion.X
        pushes = motion.inverse @ np.hstack([B, U])[:, acting]
        slopes = slopes[:, acting].reshape(count, NODES, int(np.sum(acting)), len(rows))
        source = None
        if n_s:
            s = np.array(self._source(y, t.ravel()[None, :], _wide(p, t.size), _wide(m, t.size)))
            source = (motion.inverse @ s).reshape(len(s), count, NODES, n_s).transpose(1, 2, 0, 3)
        return np.asarray(
            motion.X @ advance(motion, length / count, Coupling(rows, pushes, slopes, source), motion.inverse @ V)
        )

    def _gain(self, y: np.ndarray, t: float, p: np.ndarray, m: Any, k: int, V: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the derivatives of guard (or, behind them, row) k at a fixed time, and its rate."""
        seed = np.zeros(self._felt.nnz_in(4))
        seed[k] = 1.0
        row = np.array(self._felt(y, t, p, m, seed)).ravel()
        n_x, n_s = len(y), len(self._chosen)
        gain = row[:n_x] @ V
        gain[V.shape[1] - n_s :] += row[n_x + 1 :]
        return gain, float(row[:n_x] @ self._rate(y, t, p, m) + row[n_x])

    def _rate(self, y: np.ndarray, t: float, p: np.ndarray, m: Any) -> np.ndarray:
        return np.array(self._automaton.field(y, t, p, m)[0]).ravel()

    def _jump(self, steps: Steps, k: int, p: np.ndarray, V: np.ndarray) -> tuple[np.ndarray, bool]:
        """Return V after the event at the start of step k, and whether it has no derivatives."""
        layout, t, y = self._automaton.layout, steps.t[k], steps.ends[k - 1]
        before, after, hit = steps.mode[k - 1], steps.mode[k], np.flatnonzero(steps.hit[k - 1])
        doubt = self._unforeseen(before, after, hit)
        gain, slope = self._gain(y, t, p, before, hit[0], V)
        if abs(slope) <= steps.least[k - 1, hit[0]] and not _is_switch(layout, hit[0]):
            doubt = True
        tau = -gain / slope if slope != 0.0 else np.zeros(len(gain))
        for g in hit[1:]:
            gain, slope = self._gain(y, t, p, before, g, V)
            apart = np.abs(slope * tau + gain)
            doubt = doubt or np.max(apart) > _APART * np.max(np.abs(slope * tau) + np.abs(gain))
        n_x, n_s, rate = len(y), len(self._chosen), self._rate(y, t, p, before)
        if self._jumps is not None and hit[-1] >= layout.first_other:
            both = np.array(self._jumps(y, t, p, before, steps.hit[k - 1][layout.first_other :]))
            V, rate = both[:, :n_x] @ V, both[:, :n_x] @ rate
            V[:, V.shape[1] - n_s :] += both[:, n_x:]
        start = steps.coefficients[k][:, 0]
        V = V + np.outer(rate - self._rate(start, t, p, after), tau)
        return self._held(V, steps, k, p), doubt

    def _unforeseen(self, before: np.ndarray, after: np.ndarray, hit: np.ndarray) -> bool:
        """Whether a contact changes its mode although neither its guard fell nor that of one with the same slip."""
        layout, parallels = self._automaton.layout, self._automaton.parallels
        expected = {parallels[contact_of(g)] for g in hit if g < layout.slips.stop}
        changed = np.flatnonzero(layout.modes(before) != layout.modes(after))
        return any(parallels[i] not in expected for i in changed if i < len(layout.lines))

    def _held(self, V: np.ndarray, steps: Steps, k: int, p: np.ndarray) -> np.ndarray:
        """Return V with the slips that stick from step k on held at zero."""
        channels, n = self._channels, self._channels.n
        on = np.flatnonzero(steps.mode[k][: len(channels.slips)] == HOLDS)
        if not on.size:
            return V
        J, back, n_s = channels.slips[on], channels.spread[:, on], len(self._chosen)
        slips = J @ V[n : 2 * n]
        slips[:, V.shape[1] - n_s :] += np.array(self._drag(steps.coefficients[k][:, 0], steps.t[k], p))[on]
        V = V.copy()
        V[n : 2 * n] -= back @ np.linalg.lstsq(J @ back, slips, rcond=None)[0]
        return V


def _is_switch(layout: ModeLayout, g: int) -> bool:
    return bool(layout.slips.stop <= g < layout.first_load)


def _pieces(steps: Steps) -> list[tuple[int, int]]:
    """Return ranges of steps between events."""
    cuts = [0, *(k + 1 for k in range(len(steps.mode) - 1) if np.any(steps.hit[k])), len(steps.mode)]
    return list(itertools.pairwise(cuts))


def _last_places(places: np.ndarray) -> list[tuple[int, tuple[int, float]]]:
    """Return for each row with a minimum the step that holds the least one, and where in it."""
    last_places = []
    for r in range(places.shape[1]):
        at = np.flatnonzero(places[:, r] >= 0)
        if at.size:
            last_places.append((r, (int(at[-1]), float(places[at[-1], r]))))
    return last_places


def state_at(steps: Steps, t: np.ndarray) -> np.ndarray:
    """Return states at some times, shape (n_x, n)."""
    k = np.clip(np.searchsorted(steps.t, t, side="right") - 1, 0, len(steps.mode) - 1)
    s, c = (t - steps.t[k])[:, None], steps.coefficients
    value = c[k, :, -1]
    for j in range(c.shape[2] - 2, -1, -1):
        value = value * s + c[k, :, j]
    return value.T


def _wide(values: Any, n: int) -> np.ndarray:
    """Return a column as n equal ones."""
    return np.repeat(np.asarray(values)[:, None], n, axis=1)
