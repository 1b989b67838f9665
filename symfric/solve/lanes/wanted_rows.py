"""What is wanted of a motion, over one step in all lanes: integrals, ranges, and whether a value is due.

As in `symfric.solve.loop.event_loop` and `symfric.solve.loop.polynomials`, operation by operation.
"""

from collections.abc import Sequence
from typing import Any

from symfric.codegen.lane_ir import LaneCode
from symfric.codegen.lane_values import moves
from symfric.model.outputs import FOLLOW, INTEGRAL, RANGE, VALUES
from symfric.solve.lanes.fields import NOTED, Plan
from symfric.solve.loop.precision import HALF_OF_DIGITS

CARRIED = (RANGE, INTEGRAL, VALUES, FOLLOW)  # kinds of rows that lanes can carry
LATE = 1.0 + 1e-9  # part of a step behind its end at which a value is not yet due


class WantedRows:
    """Writes what a step does to the rows that are wanted.

    Attributes
    ----------
    g : LaneCode
    plan : Plan
    v : dict
        Values of the fields, by name.
    plain, called : mask or bool
        Lanes in which nothing is left to the event loop, and lanes that the kernel is for.
    owed : dict of int to mask
        Lanes in which a wanted row is left to the loop over lanes, which has the code of the event loop for that.
    """

    g: LaneCode
    plan: Plan
    v: dict[str, Any]
    plain: Any
    called: Any
    owed: dict[int, Any]

    def require(self, mask) -> None:
        """Leave lanes that are not in the mask to the event loop."""
        self.plain = self.g.logic("and", self.plain, mask)

    def extended(self, e: int, rows: list[list], h) -> tuple:
        """Return the two numbers of a wanted row after a step; `rows` are those of all wanted ones."""
        first, second, row = self.v[f"first{e}"], self.v[f"second{e}"], rows[e]
        kind, followers = self.plan.rows[e].kind, self.plan.followers(e)
        if kind == FOLLOW:  # left together with the row that it follows
            return first, second
        if kind == INTEGRAL:
            return self._area(row, h, first, second)
        if kind == VALUES:  # the first number is the time of the next one
            left = ~((first - self.v["t"]) - self.v["t_low"] > h * LATE)
        elif followers:
            left = self._beyond(row, h, first, second)
        else:
            first, second, left = self._range(row, h, first, second)
        self._leave({e: row} | {f: rows[f] for f in followers}, left, h)
        return first, second

    def _leave(self, rows: dict[int, list], lanes, h) -> None:
        """Leave a row of some lanes, with those that follow it, to the loop over lanes."""
        g, plan = self.g, self.plan
        self.owed[next(iter(rows))] = lanes

        def note(_: Sequence) -> list:
            for k, value in enumerate((h, self.v["t"], self.v["t_low"])):
                g.note(k, value)
            for e, row in rows.items():
                for k, value in enumerate((*row, self.v[f"scale{plan.n_x + plan.n_g + e}"])):
                    g.note(NOTED + e * plan.noted + k, value)
            return []

        if moves(lanes):
            g.branch(lanes, [], note)

    def _area(self, row: list, h, total, low) -> tuple:
        """Add the integral of a row over a step."""
        area = 0.0
        for k in range(self.plan.order, -1, -1):
            area = area * h + row[k] / (k + 1)
        area = area * h + low
        new = total + area
        return new, area - (new - total)

    def _scaled(self, row: list, h) -> list:
        """Return the coefficients of a row in powers of the fraction of the step."""
        b, power = [row[0]], h
        for e in row[1:]:
            b.append(self.g.rounded(e * power))
            power = power * h
        return b

    def _beyond(self, row: list, h, low, high):
        """Return where a row may leave its range in a step."""
        if not any(moves(e) for e in row[1:]):
            return self.g.logic("xor", (row[0] >= low) & (row[0] <= high), True)
        return self._leaves(self._scaled(row, h), low, high)[0]

    def _leaves(self, b: list, low, high) -> tuple:
        """Return where a scaled row may leave its range, and bounds of slope and bend of its higher terms."""
        g = self.g
        first, second, rest, steep, bend = b[1], b[2], 0.0, 0.0, 0.0
        for k in range(3, len(b)):
            size = g.abs(b[k])
            rest, steep, bend = rest + size, steep + k * size, bend + float(k * (k - 1)) * size
        bottom, top = g.min(b[0], b[0] + first + second), g.max(b[0], b[0] + first + second)
        if moves(second):
            bent = (g.abs(first) < 2.0 * g.abs(second)) & (first * second < 0.0)
            turn = b[0] - 0.25 * first * first / g.select(bent, second, 1.0)
            bottom, top = g.select(bent, g.min(bottom, turn), bottom), g.select(bent, g.max(top, turn), top)
        inside = (bottom - rest >= low) & (top + rest <= high)
        return g.logic("xor", inside, True), steep, bend

    def _range(self, row: list, h, low, high) -> tuple:
        """Return a range extended by a row over a step, and where that is left because the row may turn twice."""
        g, n = self.g, self.plan.order
        if not any(moves(e) for e in row[1:]):
            return g.min(low, row[0]), g.max(high, row[0]), False
        b = self._scaled(row, h)
        first, second = b[1], b[2]
        leaves, steep, bend = self._leaves(b, low, high)
        need = g.logic("and", g.logic("and", leaves, self.plain), self.called)

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

        new_low, new_high, many = g.branch(need, [low, high, False], look)
        return g.select(many, low, new_low), g.select(many, high, new_high), many

    def _turn(self, b: list, lanes, one_way, low, high, _) -> list:
        """Extend a range by the value where the slope of b is zero; where that may be so twice it is left."""
        g, n = self.g, self.plan.order
        slope = [g.rounded((k + 1) * b[k + 1]) for k in range(n)]
        first, last = slope[0], slope[n - 1]
        for k in range(n - 2, -1, -1):
            last = last + slope[k]
        turns = lanes & ((first < 0.0) ^ (last < 0.0))
        t, inner = self.summit(b, n, first, last, turns)
        t = g.select(turns, t, 0.5)
        curve = change = 0.0
        for k in range(n, 1, -1):
            curve = curve * t + float(k * (k - 1)) * b[k]
            change = change + float(k * (k - 1) * (k - 2)) * g.abs(b[k])
        one_way = g.logic("or", one_way, g.abs(curve) > change * g.max(t, 1.0 - t))
        low, high = g.select(turns, g.min(low, inner), low), g.select(turns, g.max(high, inner), high)
        return [low, high, g.logic("and", lanes, g.logic("xor", one_way, True))]

    def summit(self, b: list, n: int, first, last, lanes) -> tuple:
        """Return place and value of the extremum of b in (0, 1), as the function of this name does for one case."""
        g = self.g
        zero, bend = first - first, 2.0 * b[2]
        rises, curve = first < 0.0, (last - first) - bend
        root = g.sqrt(g.max(g.rounded(bend * bend) - g.rounded(4.0 * g.rounded(first * curve)), 0.0))
        s = 2.0 * g.abs(first) / (root + g.select(rises, bend, -bend))
        begins = first >= 0.0

        def body(state: Sequence) -> list:
            go, s, lo, hi, place, value, rounds = state
            s = g.select((lo < s) & (s < hi), s, 0.5 * (lo + hi))
            f, slope, curve = b[n], 0.0, 0.0
            for k in range(n - 1, -1, -1):
                curve, slope, f = curve * s + slope, slope * s + f, f * s + b[k]
            curve = 2.0 * curve
            same = g.logic("xor", g.logic("xor", slope >= 0.0, begins), True)
            low, high = g.select(same, s, lo), g.select(same, hi, s)
            flat, middle = g.equal(curve, 0.0), 0.5 * (low + high)
            new = g.select(flat, middle, s - slope / g.select(flat, 1.0, curve))
            done = (low <= new) & (new <= high) & (g.abs(new - s) <= HALF_OF_DIGITS)
            found = g.select(done, f + 0.5 * slope * (new - s), f)
            new = g.select((low < new) & (new < high), new, middle)
            stuck = ~((low < new) & (new < high))
            rounds = rounds - 1.0
            return [
                go & ~done & ~stuck & (rounds > 0.0),
                g.select(go, new, state[1]),
                g.select(go, low, lo),
                g.select(go, high, hi),
                g.select(go, s, place),
                g.select(go, found, value),
                rounds,
            ]

        start = [lanes, s, zero, zero + 1.0, zero + 0.5, zero, zero + 100.0]
        _, _, _, _, place, value, _ = g.loop(start, body)
        return place, value
