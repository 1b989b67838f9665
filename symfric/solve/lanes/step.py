"""One step of the event loop for all lanes at once, as straight-line code.

What it computes is what `symfric.solve.loop` does, operation by operation. A lane in which a step is anything but plain
is left as it was, and said so in the masks: the event loop makes that step.
"""

import math
from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

from symfric.codegen.lane_ir import LaneCode
from symfric.codegen.lane_values import moves
from symfric.codegen.llvm_ir import Written
from symfric.solve.lanes.fields import CALLED, LEFT, OWED, OWED_OF, Plan
from symfric.solve.lanes.wanted_rows import WantedRows
from symfric.solve.loop.decay_weights import LONGEST, PREFERRED, weights
from symfric.solve.loop.precision import EPS
from symfric.solve.loop.series import reach

ONE, CUT, PART = 2**52, 22, 2.0**20  # of logarithms in fixed point, see `symfric.solve.loop.step_size`
INFINITE, MOST = 2047 * ONE, 1023 << 30
TINY = 1e-300
STRETCH = 1.05  # see `symfric.solve.loop.event_loop`
SLACK, NOTHING = 50.0, 1e-150  # see `symfric.solve.loop.step_acceptance`


class Step(WantedRows):
    """Writes a kernel.

    Parameters
    ----------
    plan : Plan
    name : str
    width : int
        Number of lanes.
    variant : int
        Of the series.
    called : bool
        Whether it is for some lanes only.
    """

    def __init__(self, plan: Plan, name: str, width: int, variant: int = 0, called: bool = False):
        self.plan, self.variant = plan, plan.variants[variant]
        self.g = LaneCode(name, width)
        self.at = plan.names()
        self.v: dict[str, Any] = {n: self.g.load(k) for n, k in self.at.items()}
        self.called: Any = self.g.load_mask(CALLED) if called else True
        self.exposed = sorted({r for v in plan.variants for r in v.exposed})
        self.checked = bool(self.exposed)
        self.starting = plan.starting if called or plan.settles else ()  # guards that may start at zero
        self.plain: Any = True  # lanes in which nothing is left to the event loop
        self.owed: dict[int, Any] = {}

    def of(self, name: str, n: int) -> list:
        """Return some fields of one kind."""
        return [self.v[f"{name}{i}"] for i in range(n)]

    def fresh(self, i: int):
        """Return where guard i starts its mode at zero; False if it never does so here."""
        return self.v[f"fresh{i}"] > 0.0 if i in self.starting else False

    def finish(self, old: dict, last, masks: dict[int, object]) -> None:
        """Store the fields that changed, and the masks; `last` says where the run or the slope of an input ends."""
        kept = self.g.logic("and", self.plain, self.called)
        for name, k in self.at.items():
            if self.v[name] is not old[name]:
                self.g.store(k, self.g.select(kept, self.v[name], old[name]))
        self.g.store_mask(LEFT, self.g.logic("or", self.g.logic("xor", self.plain, True), last))
        owed: Any = False
        for e in range(len(self.plan.rows)):
            lanes = self.g.logic("and", kept, self.owed.get(e, False))
            owed = self.g.logic("or", owed, lanes)
            self.g.store_mask(OWED_OF + e, lanes)
        self.g.store_mask(OWED, owed)
        for k, mask in masks.items():
            self.g.store_mask(k, self.g.logic("and", kept, mask))

    def coefficients(self, f: ca.Function | Written | None, aux: Sequence, state: Sequence | None = None) -> list[list]:
        """Return the rows of a series or a short one, at the present state and time unless given."""
        assert isinstance(f, ca.Function), "see plan_of"
        state = [*self.of("y", self.plan.n_x), self.v["t"]] if state is None else state
        (flat,) = self.g.graph(f, [state, aux])
        n = len(flat) // self.plan.n_r
        return [flat[i : i + n] for i in range(0, len(flat), n)]

    def series(self) -> list[list]:
        """Return the coefficients of all rows."""
        return self.coefficients(self.variant.series, self.of("aux", self.variant.prelude.nnz_out(0)))

    def reaches(self, c: list[list], h, far) -> tuple[list, list]:
        """Return what a step h adds to the states, and by how much one of length `far` can change the guards."""
        plan = self.plan
        flat = [e for row in c[: plan.n_x + plan.n_g] for e in row]
        (found,) = self.g.graph(reach(plan.n_x, plan.n_g, plan.order), [[h, far], flat])
        return found[: plan.n_x], found[plan.n_x :]

    # -- the length of a step
    def lengths(self, c: list[list]) -> tuple:
        """Return the rows, how long a step is, how far guards are looked at, and whether the run ends with it."""
        g, v, n = self.g, self.v, self.plan.order
        limit = _logarithm(self.plan.tolerance)
        h = self._size(c, n, limit, limit)
        if self.plan.exact:
            c, h = self._weighted(c, h)
        left = (v["end"] - v["t"]) - v["t_low"]
        last = h * STRETCH >= left
        far = g.select(last, left, h * STRETCH)
        h = g.select(last, left, h)
        self.require(last | (h > 2.0 * EPS * g.abs(v["t"])))
        self.require((v["t"] < v["end"]) & (v["steps"] < v["mark_steps"]))
        return c, h, far, last

    def _weighted(self, c: list[list], h) -> tuple:
        """Return the rows and the length of a step with weighted coefficients in lanes where that is longer."""
        g, last, damping = self.g, self.plan.exact + 2, weights(self.plan.order)
        limits = (_logarithm(self.plan.tolerance / (1.0 - float(damping[k]))) for k in (last, last - 1))
        longer = self._size(c, last, *limits)
        use = longer > PREFERRED * h
        weighted = lambda k, e: g.select(use, g.rounded(g.mul(e, float(damping[k]))), e)  # noqa: E731
        c = [[*row[: last - 1], *(weighted(k, e) for k, e in enumerate(row) if k > self.plan.exact)] for row in c]
        return c, g.select(use, g.min(longer, LONGEST * h), h)

    def _size(self, c: list[list], n: int, limit: int, limit_below: int):
        g, v, fine = self.g, self.v, self.plan.tolerance
        top: Any = None
        worst: list[Any] = [None, None]
        for r, row in enumerate(c):
            ends = [row[n], row[n - 1]]
            if not any(moves(e) for e in ends):
                continue
            a = [g.bits(g.abs(e)) for e in ends if moves(e)]
            most = a[0] if len(a) == 1 else g.best("sgt", *a)
            top = most if top is None else g.best("sgt", top, most)
            scale = g.max(g.max(v[f"scale{r}"], g.abs(row[1]) * v["h_last"]), EPS / fine * g.abs(row[0]))
            if self.checked and self.plan.n_x <= r < self.plan.n_x + self.plan.n_g:
                near = g.max(g.max(g.abs(row[0]), g.abs(row[1]) * v["h_last"]), EPS / fine * scale)
                fresh = self.fresh(r - self.plan.n_x)
                scale = near if fresh is False else g.select(fresh, scale, near)
            ends_early = g.compare_whole("eq", most, 0)  # nothing to compare with the scale, which may be zero
            self.require((scale >= TINY) | ends_early)
            size = g.bits(g.select(ends_early, 1.0, scale))
            for k, e in enumerate(ends):
                if moves(e):
                    part = g.whole("sub", g.bits(g.abs(e)), size)
                    worst[k] = part if worst[k] is None else g.best("sgt", worst[k], part)
        least = None
        for k, (order, within) in enumerate(((n, limit), (n - 1, limit_below))):
            if worst[k] is not None:
                self.require(g.compare_whole("slt", worst[k], 1024 * ONE))
                e = g.whole("sub", within, g.whole("ashr", worst[k], CUT))
                e = g.whole("mul", e, int(PART / order))
                least = e if least is None else g.best("slt", least, e)
        if least is None:  # nothing limits it
            return 2.0 * ((v["end"] - v["t"]) - v["t_low"])
        self.require(g.compare_whole("slt", top, INFINITE))
        return self._power_of_two(g.whole("ashr", least, 20))

    def _power_of_two(self, x):
        g = self.g
        x = g.best("slt", x, MOST)
        whole = g.from_bits(g.whole("shl", g.whole("add", g.whole("ashr", x, 30), 1023), 52))
        part = g.whole("shl", g.whole("and", x, 2**30 - 1), CUT)
        part = g.from_bits(g.whole("or", part, 1023 << 52))
        return whole * (0.6870 + part * (part * 0.3435 - 0.0305))

    # -- step acceptance
    def accept(self, c: list[list], h, gains: list) -> None:
        """Leave a step to the event loop that may miss something; see `symfric.solve.loop.step_acceptance`."""
        if not self.checked:
            return
        g, v, plan = self.g, self.v, self.plan
        aux = self.of("aux", self.variant.prelude.nnz_out(0))
        self._hide_nothing(c, h, aux)
        end = [*(row[0] + e for row, e in zip(c, gains, strict=False)), v["t"] + (v["t_low"] + h)]
        found = self.coefficients(self.variant.probe, aux, end)
        fine = SLACK * plan.tolerance
        for r in range(plan.automaton.n_q, plan.n_x):
            start, truth = g.abs(c[r][1]), found[r][1]
            rate = 0.0
            for k in range(plan.order, 0, -1):
                rate = rate * h + float(k) * c[r][k]
            scale = g.max(g.max(v[f"scale{r}"], start * h), g.abs(truth) * h)
            allowed = fine * scale + h * (1e-12 * (start + g.abs(truth)) + NOTHING)
            self.require(g.abs(rate - truth) * h <= allowed)
        for r in self.exposed:
            if r >= plan.n_x:
                truth, value = found[r][0], c[r][plan.order]
                for k in range(plan.order - 1, -1, -1):
                    value = value * h + c[r][k]
                size = g.max(self._size_of(c, r, h), g.abs(truth))
                self.require(g.abs(value - truth) <= (fine + 1e-12) * size + NOTHING)

    def _hide_nothing(self, c: list[list], h, aux: list) -> None:
        """Require that what may be unseen on the whole step stays below the tolerance."""
        if self.variant.unseen is None:
            return
        g, v, plan = self.g, self.v, self.plan
        middles, radii = [], []
        for row in c[: plan.n_x]:
            step, rest = h * row[1], 0.0
            for k in range(plan.order, 1, -1):
                rest = rest * h + g.abs(row[k])
            middles.append(row[0] + 0.5 * step)
            radii.append(0.5 * g.abs(step) + rest * h * h)
        half = 0.5 * h
        box = [*middles, v["t"] + (v["t_low"] + half), *radii, half]
        (bound,) = g.graph(self.variant.unseen, [box, aux])
        for r in self.exposed:
            if r < plan.n_x:
                allowed = plan.tolerance * g.max(v[f"scale{r}"], g.abs(c[r][1]) * h) / h + NOTHING
            else:
                allowed = plan.tolerance * self._size_of(c, r, h) + NOTHING
            self.require(allowed >= bound[r])

    def _size_of(self, c: list[list], r: int, h):
        g = self.g
        return g.max(g.max(self.v[f"scale{r}"], g.abs(c[r][0])), g.abs(c[r][1]) * h)

    # -- the end of a step
    def advance(self, c: list[list], h, gains: list, last) -> None:
        """Move states, time, scales and what is wanted to the end of a step."""
        g, v, plan = self.g, self.v, self.plan
        new: dict[str, Any] = {}
        for r, row in enumerate(c):
            s = v[f"scale{r}"]
            if r < plan.n_x:
                y = row[0] + gains[r]
                self.require(g.abs(y) < np.inf)
                new[f"y{r}"] = y
                s = g.max(g.max(s, g.abs(y - v[f"start{r}"])), g.abs(row[1]) * h)
            elif r < plan.n_x + plan.n_g:
                s = g.max(s, g.abs(row[0]))
            else:
                e = r - plan.n_x - plan.n_g
                new[f"first{e}"], new[f"second{e}"] = self.extended(e, c[plan.n_x + plan.n_g :], h)
                s = g.max(s, g.abs(row[1]) * h)
            new[f"scale{r}"] = s
        gain = h + v["t_low"]
        t = v["t"] + gain
        new["t"] = g.select(last, v["end"], t)
        new["t_low"] = g.select(last, 0.0, gain - (t - v["t"]))
        new["h_last"] = g.max(h, 0.1 * v["h_last"])
        new["steps"] = v["steps"] + 1.0
        new |= {f"fresh{i}": v[f"fresh{i}"] - v[f"fresh{i}"] for i in self.starting}
        v.update(new)
        if "rest" in v and plan.automaton.n_q > 1:  # a contact may leave some of them free
            v["rest"] = g.select(self.drifts(), math.nan, v["rest"])

    def drifts(self):
        """Where something moves by more than rounding."""
        g, v, n_q = self.g, self.v, self.plan.automaton.n_q
        size = 0.0
        for i in range(n_q):
            size = g.max(g.max(v[f"scale{i}"] / self.plan.horizon, v[f"scale{n_q + i}"]), size)
        fastest = 0.0
        for i in range(n_q, 2 * n_q):
            fastest = g.max(fastest, g.abs(v[f"y{i}"]))
        return fastest > self.plan.tolerance * size


def _logarithm(x: float) -> int:
    return (_bits(x) - 1023 * ONE) >> CUT


def _bits(x: float) -> int:
    return int(np.float64(x).view(np.int64))
