"""Roots of polynomials in kernels, as `symfric.solve.loop.events.polynomials` finds them for one case."""

from collections.abc import Sequence

from symfric.codegen.elementwise import choose, larger
from symfric.codegen.lane_values import Value
from symfric.solve.lanes.kernel import Kernel, Row
from symfric.solve.loop import statements
from symfric.solve.loop.precision import LAST_STEP

_MOST_STEPS = 12.0  # of Newton's method, beyond which a lane is left to the event loop; three are usual


def parabola_root(kernel: Kernel, first: Value, last: Value, slope: Value) -> Value:
    """Return the root between 0 and 1 of the parabola with these ends and this slope at 0."""
    g = kernel.g
    with g.apart():
        root = g.sqrt(larger(slope * slope - 4.0 * (first * ((last - first) - slope)), 0.0))
    return 2.0 * abs(first) / (root + choose(first < 0.0, slope, -slope))


def only_root(kernel: Kernel, b: Row, last: Value, lanes: Value) -> tuple[Value, Value]:
    """Return the only root of b in (0, 1), as the function of this name does for one case, and where it takes long."""
    g, n, zero = kernel.g, len(b) - 1, last - last
    padded = [*b, 0.0, 0.0, 0.0]

    def body(state: Sequence[Value]) -> Row:
        go, s, lo, hi, root, lost, rounds = state
        s = choose((lo < s) & (s < hi), s, 0.5 * (lo + hi))
        with g.apart():
            f, slope = statements.value_and_slope(padded, n, s)
        right = f >= 0.0
        low, high = choose(right, s, lo), choose(right, hi, s)
        new = s - f / slope
        done = (low <= new) & (new <= high) & (abs(new - s) <= LAST_STEP * s)
        rounds = rounds - 1.0
        late = go & ~done & ~(rounds > 0.0)
        news = [choose(go, a, o) for a, o in ((new, state[1]), (low, lo), (high, hi), (new, root))]
        return [go & ~done & ~late, *news, lost | late, rounds]

    start = [lanes, parabola_root(kernel, b[0], last, b[1]), zero, zero + 1.0, zero, lanes & ~lanes, zero + _MOST_STEPS]
    _, _, _, _, root, lost, _ = g.loop(start, body)
    return root, lost
