"""One step of the event loop for all lanes at once, as straight-line code.

What it computes is what `symfric.solve.loop` does, operation by operation. A lane in which a step is anything but plain
is left as it was, and said so in the masks: the event loop makes that step.
"""

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

from symfric.codegen.lane_ir import LaneCode, moves
from symfric.codegen.llvm_ir import Written
from symfric.lower.mode_layout import backward
from symfric.model.outputs import INTEGRAL
from symfric.solve.lanes.fields import CALLED, LEFT, Plan
from symfric.solve.loop.precision import EPS
from symfric.solve.loop.series import reach

ONE, CUT, PART = 2**52, 22, 2.0**20  # of logarithms in fixed point, see `symfric.solve.loop.step_size`
INFINITE, MOST = 2047 * ONE, 1023 << 30
TINY = 1e-300
STRETCH = 1.05  # see `symfric.solve.loop.event_loop`
SLACK, NOTHING = 50.0, 1e-150  # see `symfric.solve.loop.step_acceptance`


class Step:
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
        self.plain: Any = True  # lanes in which nothing is left to the event loop

    def of(self, name: str, n: int) -> list:
        """Return some fields of one kind."""
        return [self.v[f"{name}{i}"] for i in range(n)]

    def require(self, mask) -> None:
        """Leave lanes that are not in the mask to the event loop."""
        self.plain = self.g.logic("and", self.plain, mask)

    def finish(self, old: dict, masks: dict[int, object]) -> None:
        """Store the fields that changed, and the masks."""
        kept = self.g.logic("and", self.plain, self.called)
        for name, k in self.at.items():
            if self.v[name] is not old[name]:
                self.g.store(k, self.g.select(kept, self.v[name], old[name]))
        self.g.store_mask(LEFT, self.g.logic("xor", self.plain, True))
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
        """Return the length of a step, how far guards are looked at, and whether the run ends with it."""
        g, v = self.g, self.v
        h = self._size(c)
        left = (v["end"] - v["t"]) - v["t_low"]
        last = h * STRETCH >= left
        far = g.select(last, left, h * STRETCH)
        h = g.select(last, left, h)
        self.require(last | (h > 2.0 * EPS * g.abs(v["t"])))
        self.require((v["t"] < v["end"]) & (v["steps"] < v["mark_steps"]))
        return h, far, last

    def _size(self, c: list[list]):
        g, n, v, fine = self.g, self.plan.order, self.v, self.plan.tolerance
        limit = (_bits(fine) - 1023 * ONE) >> CUT
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
                begins = self.plan.events and r == self.plan.n_x + backward(0)
                scale = g.select(v["fresh"] > 0.0, scale, near) if begins else near
            self.require((scale >= TINY) | g.compare_whole("eq", most, 0))
            size = g.bits(scale)
            for k, e in enumerate(ends):
                if moves(e):
                    part = g.whole("sub", g.bits(g.abs(e)), size)
                    worst[k] = part if worst[k] is None else g.best("sgt", worst[k], part)
        least = None
        for k, order in enumerate((n, n - 1)):
            if worst[k] is not None:
                self.require(g.compare_whole("slt", worst[k], 1024 * ONE))
                e = g.whole("sub", limit, g.whole("ashr", worst[k], CUT))
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

    # -- guards
    def stays(self, row: Sequence, n: int, begin, total, far):
        """Whether a polynomial stays positive: by its magnitude, or by its first three terms."""
        g = self.g
        plain = begin > total
        if n < 2:
            return plain
        first, second = row[1] * far, row[2] * far * far
        rest = g.max(total - g.abs(first) - g.abs(second), 0.0) + 1e-15 * total
        lowest = g.min(begin, begin + first + second)
        inside = (second > 0.0) & (-2.0 * second < first) & (first < 0.0)
        turn = begin - 0.25 * first * first / g.select(inside, second, 1.0)
        return plain | (g.select(inside, turn, lowest) > rest)

    def begins(self, row: Sequence, total, far):
        """Whether the guard of a slip, which may start it at zero, stays positive; without its leading zeros."""
        g, v, n = self.g, self.v, self.plan.order
        fresh = v["fresh"] > 0.0
        second = 2.0 * row[2]
        little = g.max(v["little"], 4.0 * EPS * g.abs(v["t"]) * g.abs(second))
        twice = fresh & (g.abs(row[1]) <= little)
        square = far * far
        self.require(~twice | (g.abs(row[2]) * square > 1e-13 * total))
        b = [g.select(twice, row[k + 2], g.select(fresh, row[k + 1], row[k])) for k in range(3)]
        whole = total / g.select(twice, square, g.select(fresh, far, 1.0))
        known = g.select(fresh, g.abs(b[0]), 0.0) + g.select(twice, g.abs(row[1]) / far, 0.0)
        return self.stays(b, n, b[0], whole - known + 1e-15 * whole, far)

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
                of = self._area if plan.rows[e].kind == INTEGRAL else self._range
                new[f"first{e}"], new[f"second{e}"] = of(row, h, v[f"first{e}"], v[f"second{e}"])
                s = g.max(s, g.abs(row[1]) * h)
            new[f"scale{r}"] = s
        gain = h + v["t_low"]
        t = v["t"] + gain
        new["t"] = g.select(last, v["end"], t)
        new["t_low"] = g.select(last, 0.0, gain - (t - v["t"]))
        new["h_last"] = g.max(h, 0.1 * v["h_last"])
        new["steps"] = v["steps"] + 1.0
        v.update(new)

    def _area(self, row: list, h, total, low) -> tuple:
        """Add the integral of a row over a step."""
        area = 0.0
        for k in range(self.plan.order, -1, -1):
            area = area * h + row[k] / (k + 1)
        area = area * h + low
        new = total + area
        return new, area - (new - total)

    def _range(self, row: list, h, low, high) -> tuple:
        """Extend a range by a row over a step; a row that may turn twice is left to the event loop."""
        g, n = self.g, self.plan.order
        if not any(moves(e) for e in row[1:]):
            return g.min(low, row[0]), g.max(high, row[0])
        b, power = [row[0]], h
        for k in range(1, n + 1):
            b.append(g.rounded(row[k] * power))
            power = power * h
        first, second, rest, steep, bend = b[1], b[2], 0.0, 0.0, 0.0
        for k in range(3, n + 1):
            size = g.abs(b[k])
            rest, steep, bend = rest + size, steep + k * size, bend + float(k * (k - 1)) * size
        bottom, top = g.min(b[0], b[0] + first + second), g.max(b[0], b[0] + first + second)
        if moves(second):
            bent = (g.abs(first) < 2.0 * g.abs(second)) & (first * second < 0.0)
            turn = b[0] - 0.25 * first * first / g.select(bent, second, 1.0)
            bottom, top = g.select(bent, g.min(bottom, turn), bottom), g.select(bent, g.max(top, turn), top)
        inside = (bottom - rest >= low) & (top + rest <= high)
        need = g.logic("and", g.logic("and", g.logic("xor", inside, True), self.plain), self.called)

        def look(olds: Sequence) -> list:
            old_low, old_high, _ = olds
            end = b[n]
            for k in range(n - 1, -1, -1):
                end = end + b[k]
            new_low = g.min(g.min(old_low, b[0]), end)
            new_high = g.max(g.max(old_high, b[0]), end)
            turns = g.logic("and", need, g.logic("xor", g.abs(first) > 2.0 * g.abs(second) + steep, True))
            least = 2.0 * g.abs(second) > bend
            *found, many = g.branch(turns, [new_low, new_high, False], lambda o: self._turn(b, turns, least, *o))
            return [*(g.select(need, a, o) for a, o in zip(found, olds, strict=False)), many]

        low, high, many = g.branch(need, [low, high, False], look)
        self.require(g.logic("xor", many, True))
        return low, high

    def _turn(self, b: list, lanes, one_way, low, high, _) -> list:
        """Extend a range by the value where the slope of b is zero; where that may be so twice it is left."""
        g, n = self.g, self.plan.order
        slope = [g.rounded((k + 1) * b[k + 1]) for k in range(n)]
        first, last = slope[0], slope[n - 1]
        for k in range(n - 2, -1, -1):
            last = last + slope[k]
        turns = lanes & ((first < 0.0) ^ (last < 0.0))
        t = g.select(turns, self.polish(slope, n - 1, first, last, turns), 0.5)
        curve = change = 0.0
        for k in range(n, 1, -1):
            curve = curve * t + float(k * (k - 1)) * b[k]
            change = change + float(k * (k - 1) * (k - 2)) * g.abs(b[k])
        one_way = g.logic("or", one_way, g.abs(curve) > change * g.max(t, 1.0 - t))
        inner = b[n]
        for k in range(n - 1, -1, -1):
            inner = inner * t + b[k]
        low, high = g.select(turns, g.min(low, inner), low), g.select(turns, g.max(high, inner), high)
        return [low, high, g.logic("and", lanes, g.logic("xor", one_way, True))]

    def polish(self, b: list, n: int, f_lo, f_hi, lanes):
        """Return the only root of b in (0, 1), by Newton's method kept between ends of different signs."""
        g = self.g
        zero = f_lo - f_lo
        small, large = g.min(g.abs(f_lo), g.abs(f_hi)), g.max(g.abs(f_lo), g.abs(f_hi))
        clear = small > 1e-6 * large
        s = g.select(clear, f_lo / (f_lo - g.select(clear, f_hi, f_lo - 1.0)), zero + 0.5)
        begins = f_lo >= 0.0

        def body(state: Sequence) -> list:
            go, s, lo, hi, rounds = state
            inside = (lo < s) & (s < hi)
            s = g.select(inside, s, 0.5 * (lo + hi))
            stuck = ~((lo < s) & (s < hi))
            f, rate = b[n], 0.0
            for k in range(n - 1, -1, -1):
                rate, f = rate * s + f, f * s + b[k]
            same = g.logic("xor", g.logic("xor", f >= 0.0, begins), True)
            low, high = g.select(same, s, lo), g.select(same, hi, s)
            flat = g.equal(rate, 0.0)
            new = g.select(flat, 0.5 * (low + high), s - f / g.select(flat, 1.0, rate))
            done = (low <= new) & (new <= high) & (g.abs(new - s) <= 1e-9 * s)
            rounds = rounds - 1.0
            live = go & ~stuck
            return [
                live & ~done & (rounds > 0.0),
                g.select(live, new, g.select(go, hi, state[1])),
                g.select(live, low, lo),
                g.select(live, high, hi),
                rounds,
            ]

        return g.loop([lanes, s, zero, zero + 1.0, zero + 100.0], body)[1]


def smooth_step(plan: Plan, width: int, name: str = "smooth") -> Written:
    """Return the kernel of steps without events, in the one mode that there are series for or in that of slipping."""
    k = Step(plan, name, width)
    g, old, n_x = k.g, dict(k.v), plan.n_x
    c = k.series()
    h, far, last = k.lengths(c)
    gains, totals = k.reaches(c, h, far)
    for i in range(plan.n_g):
        row = c[n_x + i]
        if any(moves(e) for e in row[1:]):
            begins = plan.events and i == backward(0)
            k.require(k.begins(row, totals[i], far) if begins else k.stays(row, plan.order, row[0], totals[i], far))
        elif moves(row[0]):
            k.require(row[0] > 0.0)
    k.accept(c, h, gains)
    k.advance(c, h, gains, last)
    if plan.events:
        k.v["fresh"] = k.v["fresh"] - k.v["fresh"]
    k.finish(old, {})
    return g.written()


def _bits(x: float) -> int:
    return int(np.float64(x).view(np.int64))
