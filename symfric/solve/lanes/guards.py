"""Guards over one step in lanes: where they surely stay positive, and when the first becomes negative.

What is found is what `symfric.solve.loop.events.first_event` finds, to the bit; where it might not be, the lane is left
to it.
"""

from symfric.codegen.elementwise import choose, larger, smaller
from symfric.codegen.lane_values import Value, moves
from symfric.lower.mode_layout import contact_of, is_slip
from symfric.solve.lanes.kernel import Kernel, Row
from symfric.solve.lanes.polynomials import only_root
from symfric.solve.loop import statements
from symfric.solve.loop.events.bernstein import bernstein_columns
from symfric.solve.loop.precision import EPS, LEAST_TERM, NEAREST, TIE, TOUCH


def _begin(kernel: Kernel, i: int, row: Row, total: Value) -> Value:
    """Return the first value of a guard, shifted if it is that of a load; a float unless it moves."""
    layout = kernel.plan.automaton.layout
    k = i - layout.first_load
    if not 0 <= k < len(layout.loads):
        return row[0]
    touch = TOUCH * kernel.plan.tolerance * larger(_scale(kernel, i), total)
    return (row[0] + kernel.v[f"slack{k}"]) + touch


def _scale(kernel: Kernel, i: int) -> Value:
    return kernel.v[f"scale{kernel.plan.n_x + i}"]


def excluded(kernel: Kernel, i: int, row: Row, total: Value, far: Value) -> Value:
    """Where a guard surely does not become negative within `far`."""
    row, total, start = _begun(kernel, i, row, total, far, 3)
    fresh, scale = kernel.fresh(i), _scale(kernel, i)
    still = statements.is_still(start, total, scale)
    clear = (start > 2.0 * EPS * scale) | (row[1] >= 0.0) if moves(row[1]) else True
    if fresh is not False:
        clear, still = kernel.g.logic("or", fresh, clear), still & ~fresh
    return _stays(kernel, row, start, total, far, clear) | still


def _stays(kernel: Kernel, row: Row, begin: Value, total: Value, far: Value, clear: Value = True) -> Value:
    """Whether a polynomial stays positive: by its magnitude, or, where it is clear, by its first three terms."""
    plain = begin > total
    if kernel.plan.order < 2:
        return plain
    first, second = row[1] * far, row[2] * far * far
    rest = larger(total - abs(first) - abs(second), 0.0) + 1e-15 * total
    lowest = smaller(begin, begin + first + second)
    inside = (second > 0.0) & (-2.0 * second < first) & (first < 0.0)
    turn = begin - 0.25 * first * first / choose(inside, second, 1.0)
    return plain | (clear & (choose(inside, turn, lowest) > rest))


def _begun(kernel: Kernel, i: int, row: Row, total: Value, far: Value, n: int) -> tuple[Row, Value, Value]:
    """Return the first n coefficients of a guard without leading zeros, a bound of its terms, and its first value.

    One that starts its mode at zero loses one power of time or two.
    """
    start = _begin(kernel, i, row, total)
    row = [start, *row[1:]]
    fresh = kernel.fresh(i)
    if fresh is False:
        return row[:n], total, start
    g, v, layout = kernel.g, kernel.v, kernel.plan.automaton.layout
    square = far * far
    slips = layout.is_along_line(i) and is_slip(i)
    # guards before this one may have shortened the time for which the event loop looks at it
    least = LEAST_TERM if i == 0 else LEAST_TERM / NEAREST**2
    twice: Value = False
    if slips:
        little = statements.no_acceleration(v[f"little{contact_of(i)}"], v["t"], 2.0 * row[2])
        twice = fresh & (abs(row[1]) <= little)
    elif layout.is_switch(i):
        time = natural_time(kernel)
        twice = fresh & ~(abs(row[1]) * time > TIE * _scale(kernel, i))
        kernel.require(~twice | (abs(row[2]) > TIE * abs(row[3]) * time))
    if slips:  # less, and the event loop may take the slip for none
        kernel.require(~twice | (total > little * far))
    else:
        kernel.require(g.logic("or", ~fresh, g.logic("or", twice, abs(row[1]) * far > least * total)))
    if moves(twice):
        kernel.require(~twice | (abs(row[2]) * square > least * total))
    row = [*row, 0.0, 0.0]
    b = [choose(twice, row[k + 2], choose(fresh, row[k + 1], row[k])) for k in range(n)]
    whole = total / choose(twice, square, choose(fresh, far, 1.0))
    known = choose(fresh, abs(b[0]), 0.0) + choose(twice, abs(row[1]) / far, 0.0)
    kernel.require(~fresh | (b[0] >= 0.0))
    return b, whole - known + 1e-15 * whole, b[0]


def first(kernel: Kernel, row: Row, i: int, total: Value, far: Value, tau: Value, which: Value) -> tuple[Value, Value]:
    """Return the time of the first event and its guard, this guard included."""
    g = kernel.g
    near = smaller(far, larger(tau * (1.0 + 8.0 * EPS), NEAREST * far))
    row, total, start = _begun(kernel, i, row, total, far, kernel.plan.order + 1)
    fresh = kernel.fresh(i)
    still = statements.is_still(start, total, _scale(kernel, i))
    done = (start > total) | (still if fresh is False else still & ~fresh)
    need = g.logic("and", g.logic("and", ~done, kernel.plain), kernel.called)

    def find(olds: Row) -> Row:
        t, doubt = _crossing(kernel, row, i, total, near, need)
        sooner = need & (t < olds[0])
        tie = need & ~sooner & (olds[0] < far) & (t <= olds[0] * (1.0 + 4.0 * EPS))
        return [choose(sooner, t, olds[0]), choose(sooner, float(i), olds[1]), doubt | tie]

    tau, which, doubt = g.branch(need, [tau, which, False], find)
    kernel.require(~doubt)
    return tau, which


def _crossing(kernel: Kernel, row: Row, i: int, total: Value, near: Value, need: Value) -> tuple[Value, Value]:
    """Return when a guard becomes negative, and where that is in doubt; see `first_crossing`.

    A guard whose Bernstein coefficients change their sign more than once is.
    """
    g, begin = kernel.g, row[0]
    edge = (begin <= 2.0 * EPS * _scale(kernel, i)) & (row[1] < 0.0)
    fresh = kernel.fresh(i)
    doubt = need & ((begin < 0.0) | (edge if fresh is False else edge & ~fresh))
    square = near * near
    b, powers = [begin], [near, square]
    for e in row[1:]:
        b.append(g.rounded(e * powers[0]))
        powers = [powers[1], powers[0] * square]
    bent = sum((abs(e) for e in b[3:]), abs(b[2]))
    straight = g.equal(bent, 0.0) if moves(bent) else True
    steep = begin < -row[1] * near
    line = choose(steep, -begin / choose(steep, row[1], 1.0), 2.0 * near)
    if not moves(bent):
        return line, doubt
    never = choose(straight, line, 2.0 * near)
    search = need & ~doubt & ~straight & ~_stays(kernel, row, begin, total, near)
    first, several = g.branch(search, [never, False], lambda olds: _by_signs(kernel, b, near, search, olds[0]))
    return first, g.logic("or", doubt, several)


def _by_signs(kernel: Kernel, b: Row, near: Value, search: Value, never: Value) -> Row:
    """Return the time of the only change of sign in some lanes, and where there may be several."""
    g, table, last = kernel.g, bernstein_columns(kernel.plan.order, 1), b[0]
    falls: Value = False
    several: Value = False
    for j in range(1, len(b)):
        last = 0.0
        for k in range(j + 1):
            last = g.fma(float(table[k, j]), b[k], last)
        falls, before = last < 0.0, falls
        several = g.logic("or", several, g.logic("and", before, g.opposite(falls)))
    alone = search & g.logic("and", falls, g.opposite(several))
    time, lost = only_root(kernel, b, last, alone)
    return [choose(alone, g.rounded(near * time), never), g.logic("or", g.logic("and", search, several), lost)]


def natural_time(kernel: Kernel) -> Value:
    """Return range over speed of the coordinate for which it is longest."""
    n, horizon = kernel.plan.automaton.n_q, kernel.plan.horizon
    return statements.natural_time(kernel.of("scale", 2 * n), n, horizon)
