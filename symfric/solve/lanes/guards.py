"""Guards over one step in all lanes: where they surely stay positive, and when the first becomes negative.

What is found is what `symfric.solve.loop.event_loop` finds, to the bit; where it might not be, the lane is left to it.
"""

from collections.abc import Sequence
from typing import Any

from symfric.codegen.lane_values import moves
from symfric.lower.mode_layout import contact_of, is_slip
from symfric.solve.lanes.step import Step
from symfric.solve.loop.precision import EPS, MARCHES, TIE, TOUCH

LEAST_TERM = 1e-13  # first term of a guard that starts at zero, relative to all of them, that decides its sign
NEAREST = 1e-3  # part of a step over which guards are followed at least


class GuardedStep(Step):
    """Writes a step and what its guards do."""

    def begin_of(self, i: int, row: Sequence, total):
        """Return the first value of a guard, shifted if it is that of a load; a float unless it moves."""
        layout = self.plan.automaton.layout
        k = i - layout.first_load
        if not 0 <= k < len(layout.loads):
            return row[0]
        touch = TOUCH * self.plan.tolerance * self.g.max(self.v[f"scale{self.plan.n_x + i}"], total)
        return (row[0] + self.v[f"slack{k}"]) + touch

    def excluded(self, i: int, row: Sequence, total, far):
        """Where a guard surely does not become negative within `far`."""
        row, total, start = self.begun(i, row, total, far, 3)
        fresh, scale = self.fresh(i), self.v[f"scale{self.plan.n_x + i}"]
        still = self.is_still(start, total, scale)
        clear = (start > 2.0 * EPS * scale) | (row[1] >= 0.0) if moves(row[1]) else True
        if fresh is not False:
            clear, still = self.g.logic("or", fresh, clear), still & ~fresh
        return self.stays(row, self.plan.order, start, total, far, clear) | still

    def is_still(self, begin, total, scale):
        """Where a guard is zero throughout, up to rounding."""
        return total + self.g.abs(begin) <= 8.0 * EPS * scale

    def stays(self, row: Sequence, n: int, begin, total, far, clear: Any = True):
        """Whether a polynomial stays positive: by its magnitude, or, where it is clear, by its first three terms."""
        g = self.g
        plain = begin > total
        if n < 2:
            return plain
        first, second = row[1] * far, row[2] * far * far
        rest = g.max(total - g.abs(first) - g.abs(second), 0.0) + 1e-15 * total
        lowest = g.min(begin, begin + first + second)
        inside = (second > 0.0) & (-2.0 * second < first) & (first < 0.0)
        turn = begin - 0.25 * first * first / g.select(inside, second, 1.0)
        return plain | (clear & (g.select(inside, turn, lowest) > rest))

    def begun(self, i: int, row: Sequence, total, far, n: int) -> tuple:
        """Return the first n coefficients of a guard without leading zeros, a bound of its terms, and its first value.

        One that starts its mode at zero loses one power of time or two.
        """
        start = self.begin_of(i, row, total)
        row = [start, *row[1:]]
        fresh = self.fresh(i)
        if fresh is False:
            return row[:n], total, start
        g, v, layout = self.g, self.v, self.plan.automaton.layout
        square = far * far
        slips = layout.is_along_line(i) and is_slip(i)
        # guards before this one may have shortened the time for which the event loop looks at it
        least = LEAST_TERM if i == 0 else LEAST_TERM / NEAREST**2
        twice: Any = False
        if slips:
            second = 2.0 * row[2]
            little = g.max(v[f"little{contact_of(i)}"], 4.0 * EPS * g.abs(v["t"]) * g.abs(second))
            twice = fresh & (g.abs(row[1]) <= little)
        elif layout.is_switch(i):
            time = self.natural_time()
            twice = fresh & ~(g.abs(row[1]) * time > TIE * v[f"scale{self.plan.n_x + i}"])
            self.require(~twice | (g.abs(row[2]) > TIE * g.abs(row[3]) * time))
        if not slips:
            self.require(g.logic("or", ~fresh, g.logic("or", twice, g.abs(row[1]) * far > least * total)))
        if slips:  # less, and the event loop may take the slip for none
            self.require(~twice | (total > little * far))
        if moves(twice):
            self.require(~twice | (g.abs(row[2]) * square > least * total))
        row = [*row, 0.0, 0.0]
        b = [g.select(twice, row[k + 2], g.select(fresh, row[k + 1], row[k])) for k in range(n)]
        whole = total / g.select(twice, square, g.select(fresh, far, 1.0))
        known = g.select(fresh, g.abs(b[0]), 0.0) + g.select(twice, g.abs(row[1]) / far, 0.0)
        self.require(~fresh | (b[0] >= 0.0))
        return b, whole - known + 1e-15 * whole, b[0]

    def first(self, row: list, i: int, total, far, tau, which) -> tuple:
        """Return the time of the first event and its guard, this guard included."""
        g, n = self.g, self.plan.order
        near = g.min(far, g.max(tau * (1.0 + 8.0 * EPS), NEAREST * far))
        row, total, start = self.begun(i, row, total, far, n + 1)
        fresh = self.fresh(i)
        still = self.is_still(start, total, self.v[f"scale{self.plan.n_x + i}"])
        done = (start > total) | (still if fresh is False else still & ~fresh)
        need = g.logic("and", g.logic("and", ~done, self.plain), self.called)

        def find(olds: Sequence) -> list:
            t, doubt = self.crossing(row, i, total, near, need)
            sooner = need & (t < olds[0])
            tie = need & ~sooner & (olds[0] < far) & (t <= olds[0] * (1.0 + 4.0 * EPS))
            return [g.select(sooner, t, olds[0]), g.select(sooner, float(i), olds[1]), doubt | tie]

        tau, which, doubt = g.branch(need, [tau, which, False], find)
        self.require(~doubt)
        return tau, which

    def crossing(self, row: list, i: int, total, near, need) -> tuple:
        """Return when a guard becomes negative, and where that is in doubt; see `symfric.solve.loop.polynomials`."""
        g, n, begin = self.g, self.plan.order, row[0]
        scale = self.v[f"scale{self.plan.n_x + i}"]
        edge = (begin <= 2.0 * EPS * scale) & (row[1] < 0.0)
        fresh = self.fresh(i)
        doubt = need & ((begin < 0.0) | (edge if fresh is False else edge & ~fresh))
        bend, power, weight, more = 0.0, 1.0, 2.0, 4.0
        for k in range(2, n + 1):
            bend = bend + g.rounded(weight * (power * g.abs(row[k])))
            power = power * near
            weight, more = weight + more, more + 2.0
        straight = g.equal(bend, 0.0) if moves(bend) else True
        steep = begin < -row[1] * near
        line = g.select(steep, -begin / g.select(steep, row[1], 1.0), 2.0 * near)
        if not moves(bend):
            return line, doubt
        search = need & ~doubt & ~straight & ~self.stays(row, n, begin, total, near)

        def body(state: Sequence) -> list:
            go, t, f, slope, found, lost, rounds = state
            falls = slope < 0.0
            root = g.sqrt(g.rounded(slope * slope) + g.rounded(2.0 * bend * f))
            step = g.select(falls, 2.0 * f, slope + root) / g.select(falls, root - slope, bend)
            near_enough = go & falls & (bend * step * step <= -1e-16 * slope * t)
            new = t + step
            inside = new < near
            found = g.select(near_enough & inside, new, found)
            go = go & ~near_enough & inside
            lost = lost | (go & g.equal(new, 0.0))
            f_new, slope_new = self.value_and_slope(row, n, new)
            on = go & (f_new <= 0.0)
            found = g.select(on, new, found)
            rounds = rounds - 1.0
            live = go & ~on & ~g.equal(new, 0.0)
            late = live & ~(rounds > 0.0)
            live = live & ~late
            return [
                live,
                g.select(live, new, t),
                g.select(live, f_new, f),
                g.select(live, slope_new, slope),
                found,
                lost | late,
                rounds,
            ]

        zero = near - near
        never = g.select(straight, line, 2.0 * near)
        start = [search, zero, begin, row[1], never, search & ~search, zero + float(MARCHES)]
        _, _, _, _, found, lost, _ = g.loop(start, body)
        return found, doubt | lost

    def value_and_slope(self, b: list, n: int, t) -> tuple:
        """Return a polynomial and its derivative, as the function of this name does for one case."""
        g = self.g
        apart = lambda x, y: g.rounded(g.mul(x, y))  # noqa: E731
        square = apart(t, t)
        fourth = apart(square, square)
        a, d = [0.0] * 4, [0.0] * 4
        power, weight = 1.0, 0.0
        for k in range(0, n + 1, 4):
            for j in range(4):
                part = apart(power, b[k + j] if k + j <= n else 0.0)
                a[j], d[j] = g.add(a[j], part), g.add(d[j], apart(weight + j, part))
            power = apart(power, fourth)
            weight += 4.0
        value = (a[0] + apart(t, a[1])) + apart(square, a[2] + apart(t, a[3]))
        return value, (d[1] + apart(t, d[2])) + (d[0] / t + apart(square, d[3]))

    def natural_time(self):
        """Return range over speed of the coordinate for which it is longest."""
        g, v, n, horizon = self.g, self.v, self.plan.automaton.n_q, self.plan.horizon
        time = 0.0
        for i in range(n):
            moving = v[f"scale{n + i}"] > 0.0
            own = v[f"scale{i}"] / g.select(moving, v[f"scale{n + i}"], 1.0)
            time = g.max(time, g.select(moving, own, 0.0))
        return g.select(time > 0.0, g.min(time, horizon), 1e-3 * horizon)
