"""What is wanted of a motion, over one step in lanes: integrals, ranges, and whether a value is due.

As in `symfric.solve.loop.recording.accumulation` and `symfric.solve.loop.events.polynomials`.
"""

from collections.abc import Sequence

from symfric.codegen.elementwise import choose, larger, smaller
from symfric.codegen.lane_values import Value, moves
from symfric.model.rows import FOLLOW, INTEGRAL, RANGE, VALUES
from symfric.solve.lanes.fields import NOTED
from symfric.solve.lanes.kernel import Kernel, Row
from symfric.solve.lanes.polynomials import parabola_root
from symfric.solve.loop import statements
from symfric.solve.loop.precision import HALF_OF_DIGITS, LATE

CARRIED = (RANGE, INTEGRAL, VALUES, FOLLOW)  # kinds of rows that lanes can carry


def extended(kernel: Kernel, e: int, rows: Sequence[Row], h: Value) -> tuple[Value, Value]:
    """Return the two numbers of a wanted row after a step; `rows` are those of all wanted ones."""
    plan, v, row = kernel.plan, kernel.v, rows[e]
    first, second = v[f"first{e}"], v[f"second{e}"]
    kind, followers = plan.rows[e].kind, plan.followers(e)
    if kind == FOLLOW:  # left together with the row that it follows
        return first, second
    if kind == INTEGRAL:
        total, low = statements.summed(first, second, statements.area(row, plan.order, h))
        return total, low
    if kind == VALUES:  # the first number is the time of the next one
        left = ~((first - v["t"]) - v["t_low"] > h * (1.0 + LATE))
    elif followers:
        left = _beyond(kernel, row, h, first, second)
    else:
        first, second, left = _range(kernel, row, h, first, second)
    _leave(kernel, {e: row} | {f: rows[f] for f in followers}, left, h)
    return first, second


def _leave(kernel: Kernel, rows: dict[int, Row], lanes: Value, h: Value) -> None:
    """Leave a row of some lanes, with those that follow it, to the loop over lanes."""
    g, plan, v = kernel.g, kernel.plan, kernel.v
    kernel.owed[next(iter(rows))] = lanes

    def note(_: Row) -> Row:
        for k, value in enumerate((h, v["t"], v["t_low"])):
            g.note(k, value)
        for e, row in rows.items():
            for k, value in enumerate((*row, v[f"scale{plan.n_x + plan.n_g + e}"])):
                g.note(NOTED + e * plan.noted + k, value)
        return []

    if moves(lanes):
        g.branch(lanes, [], note)


def _scaled(kernel: Kernel, row: Row, h: Value) -> list[Value]:
    """Return the coefficients of a row in powers of the fraction of the step."""
    b, power = [row[0]], h
    for e in row[1:]:
        b.append(kernel.g.rounded(e * power))
        power = power * h
    return b


def _beyond(kernel: Kernel, row: Row, h: Value, low: Value, high: Value) -> Value:
    """Return where a row may leave its range in a step."""
    if not any(moves(e) for e in row[1:]):
        return kernel.g.opposite((row[0] >= low) & (row[0] <= high))
    return _leaves(kernel, _scaled(kernel, row, h), low, high)[0]


def _leaves(kernel: Kernel, b: Row, low: Value, high: Value) -> tuple[Value, Value, Value]:
    """Return where a scaled row may leave its range, and bounds of slope and bend of its higher terms."""
    first, second, rest, steep, bend = b[1], b[2], 0.0, 0.0, 0.0
    for k in range(3, len(b)):
        size = abs(b[k])
        rest, steep, bend = rest + size, steep + k * size, bend + float(k * (k - 1)) * size
    bottom, top = smaller(b[0], b[0] + first + second), larger(b[0], b[0] + first + second)
    if moves(second):
        bent = (abs(first) < 2.0 * abs(second)) & (first * second < 0.0)
        turn = b[0] - 0.25 * first * first / choose(bent, second, 1.0)
        bottom, top = choose(bent, smaller(bottom, turn), bottom), choose(bent, larger(top, turn), top)
    return kernel.g.opposite((bottom - rest >= low) & (top + rest <= high)), steep, bend


def _range(kernel: Kernel, row: Row, h: Value, low: Value, high: Value) -> tuple[Value, Value, Value]:
    """Return a range extended by a row over a step, and where that is left because the row may turn twice."""
    g, n = kernel.g, kernel.plan.order
    if not any(moves(e) for e in row[1:]):
        return smaller(low, row[0]), larger(high, row[0]), False
    b = _scaled(kernel, row, h)
    first, second = b[1], b[2]
    leaves, steep, bend = _leaves(kernel, b, low, high)
    need = g.logic("and", g.logic("and", leaves, kernel.plain), kernel.called)

    def look(olds: Row) -> Row:
        old_low, old_high, _ = olds
        end = statements.value(b, n, 1.0)
        new_low = smaller(smaller(old_low, b[0]), end)
        new_high = larger(larger(old_high, b[0]), end)
        turns = g.logic("and", need, g.opposite(abs(first) > 2.0 * abs(second) + steep))
        least = 2.0 * abs(second) > bend
        *found, many = g.branch(turns, [new_low, new_high, False], lambda o: _turn(kernel, b, turns, least, *o[:2]))
        return [*(choose(need, a, o) for a, o in zip(found, olds, strict=False)), many]

    new_low, new_high, many = g.branch(need, [low, high, False], look)
    return choose(many, low, new_low), choose(many, high, new_high), many


def _turn(kernel: Kernel, b: Row, lanes: Value, one_way: Value, low: Value, high: Value) -> Row:
    """Extend a range by the value where the slope of b is zero; where that may be so twice it is left."""
    g, n = kernel.g, kernel.plan.order
    slope = [g.rounded((k + 1) * b[k + 1]) for k in range(n)]
    first, last = slope[0], statements.value(slope, n - 1, 1.0)
    turns = lanes & ((first < 0.0) ^ (last < 0.0))
    t, inner = _summit(kernel, b, first, last, turns)
    t = choose(turns, t, 0.5)
    curve = change = 0.0
    for k in range(n, 1, -1):
        curve = curve * t + float(k * (k - 1)) * b[k]
        change = change + float(k * (k - 1) * (k - 2)) * abs(b[k])
    one_way = g.logic("or", one_way, abs(curve) > change * larger(t, 1.0 - t))
    low, high = choose(turns, smaller(low, inner), low), choose(turns, larger(high, inner), high)
    return [low, high, g.logic("and", lanes, g.opposite(one_way))]


def _summit(kernel: Kernel, b: Row, first: Value, last: Value, lanes: Value) -> tuple[Value, Value]:
    """Return place and value of the extremum of b in (0, 1), as the function of this name does for one case.

    Coefficients that are known to be zero are kept as lanes: sums without them would be rounded elsewhere.
    """
    g, n, zero = kernel.g, kernel.plan.order, first - first
    b = [e if moves(e) else zero + e for e in b]
    s = parabola_root(kernel, first, last, 2.0 * b[2])

    def body(state: Row) -> Row:
        go, s, lo, hi, place, value, rounds = state
        s = choose((lo < s) & (s < hi), s, 0.5 * (lo + hi))
        f, slope, curve = b[n], 0.0, 0.0
        for k in range(n - 1, -1, -1):
            curve, slope, f = curve * s + slope, slope * s + f, f * s + b[k]
        curve = 2.0 * curve
        same = ~((slope >= 0.0) ^ (first >= 0.0))
        low, high = choose(same, s, lo), choose(same, hi, s)
        flat, middle = g.equal(curve, 0.0), 0.5 * (low + high)
        new = choose(flat, middle, s - slope / choose(flat, 1.0, curve))
        done = (low <= new) & (new <= high) & (abs(new - s) <= HALF_OF_DIGITS)
        found = choose(done, f + 0.5 * slope * (new - s), f)
        inside = (low < new) & (new < high)
        new = choose(inside, new, middle)
        stuck = ~((low < new) & (new < high))
        rounds = rounds - 1.0
        news = [
            choose(go, a, o) for a, o in zip((new, low, high, s, found), (state[1], lo, hi, place, value), strict=True)
        ]
        return [go & ~done & ~stuck & (rounds > 0.0), *news, rounds]

    start = [lanes, s, zero, zero + 1.0, zero + 0.5, zero, zero + 100.0]
    _, _, _, _, place, value, _ = g.loop(start, body)
    return place, value
