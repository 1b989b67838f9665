"""What a step of the event loop and a step in lanes compute alike: stated once, so that both end at the same bits.

Compiled by `.arithmetic` for the event loop, with numbers; called with `Lanes` by what writes the kernels. What depends
on a condition is chosen, not branched to. Coefficients are a row ``c[0..n]``, an array or a list.
"""

from symfric.codegen.elementwise import bits_of, choose, larger, of_bits, smaller
from symfric.codegen.lane_values import Value
from symfric.solve.loop.precision import EPS, MOST_DOUBT, ROUNDING, TIE

# -- logarithms and powers of two, in fixed point
# With those of the C library, the length of a step would take an eighth of the time of a run; converted between
# integers and floats, a twelfth.
ONE = 2**52  # the number one in the fixed-point format of logarithms
CUT = 22  # bits of a logarithm that are dropped before a multiplication
PART = 2.0**20  # the number one in the fixed-point format of the reciprocal order
INFINITE = 2047 * ONE  # bits of infinity, and less than those of NaN
_LARGEST = 1023 << 30

# -- step acceptance
SLACK = 50.0  # largest defect at a checked point, in tolerances
NOTHING = 1e-150  # negligible size, such as the tail of a pulse that acts on a body at rest
_SUMS = 1e-12  # rounding error of a sum of a whole series, relative to its size


def logarithm(x: Value) -> Value:
    """Return log2 x in the fixed-point format.

    The bits of x >= 0 are 2^52 (1023 + log2 x), too small by up to 0.09 x 2^52, which is negligible after a root of the
    series' order.
    """
    return (bits_of(x) - 1023 * ONE) >> CUT


def power_of_two(x: Value) -> Value:
    """Return 2^(x 2^-30), to 3 in a thousand: bits again, and a parabola between the powers of two."""
    x = smaller(x, _LARGEST)
    whole = of_bits(((x >> 30) + 1023) << 52)
    part = of_bits(((x & (2**30 - 1)) << CUT) | (1023 << 52))  # mantissa from 1 to 2
    return whole * (0.6870 + part * (part * 0.3435 - 0.0305))


def largest_of_row(first: Value, rate: Value, before: Value, grain: Value, second: Value) -> Value:
    """Return what the last terms of a row are compared with: its scale, its change over the last step, its rounding."""
    return larger(larger(first, abs(rate) * before), grain * second)


# -- polynomials
def value(b: Value, n: Value, s: Value) -> Value:
    """Evaluate by Horner's rule."""
    r = b[n]
    for k in range(n - 1, -1, -1):
        r = r * s + b[k]
    return r


def slope(c: Value, t: Value) -> Value:
    """Evaluate the derivative of a polynomial."""
    rate = 0.0
    for k in range(len(c) - 1, 0, -1):
        rate = rate * t + k * c[k]
    return rate


def area(c: Value, n: Value, t: Value) -> Value:
    """Evaluate the integral of a polynomial from zero."""
    total = 0.0
    for k in range(n, -1, -1):
        total = total * t + c[k] / (k + 1)
    return total * t


def value_and_slope(b: Value, n: Value, t: Value) -> Value:
    """Evaluate b, zero beyond n, and its derivative at t > 0, in four chains of every fourth power; none is fused."""
    square = t * t
    fourth = square * square
    a0, a1, a2, a3, d0, d1, d2, d3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    power, weight = 1.0, 0.0
    for k in range(0, n + 1, 4):  # upward, because numba checks the sign of decreasing indices
        b0, b1, b2, b3 = power * b[k], power * b[k + 1], power * b[k + 2], power * b[k + 3]
        a0, d0 = a0 + b0, d0 + weight * b0
        a1, d1 = a1 + b1, d1 + (weight + 1.0) * b1
        a2, d2 = a2 + b2, d2 + (weight + 2.0) * b2
        a3, d3 = a3 + b3, d3 + (weight + 3.0) * b3
        power *= fourth
        weight += 4.0
    return (a0 + t * a1) + square * (a2 + t * a3), (d1 + t * d2) + (d0 / t + square * d3)


# -- the end of a step
def summed(total: Value, low: Value, more: Value) -> Value:
    """Add to a sum and its rounding error (Kahan, Communications of the ACM 8, 1965); return both."""
    more = more + low
    new = total + more
    return new, more - (new - total)


def scale_of_state(scale: Value, y: Value, start: Value, rate: Value, h: Value) -> Value:
    """Return the scale of a state after a step h: its largest distance from the start, or change over a step."""
    return larger(larger(scale, abs(y - start)), abs(rate) * h)


def drifts(y: Value, scale: Value, n_q: Value, horizon: Value, tolerance: Value) -> Value:
    """Whether something moves that no contact holds, by more than rounding; its velocity may have begun with zero."""
    size, fastest = 0.0, 0.0
    for i in range(n_q):
        size = larger(larger(size, scale[i] / horizon), scale[n_q + i])
        fastest = larger(fastest, abs(y[n_q + i]))
    return fastest > tolerance * size


def is_at_rest(u: Value, scale: Value) -> Value:
    """Whether a velocity is zero up to rounding."""
    return abs(u) <= 1e-13 * scale


# -- step acceptance
def box_of_step(c: Value, n: Value, h: Value) -> Value:
    """Return middle and radius of an interval that holds a row over a step."""
    step, rest = h * c[1], 0.0
    for k in range(n, 1, -1):
        rest = rest * h + abs(c[k])
    return c[0] + 0.5 * step, 0.5 * abs(step) + rest * h * h


def size_of_row(scale: Value, first: Value, rate: Value, h: Value) -> Value:
    """Return the scale of a guard or an observable."""
    return larger(larger(scale, abs(first)), abs(rate) * h)


def defect_of_rate(scale: Value, start: Value, truth: Value, t: Value, fine: Value) -> Value:
    """Return the largest defect of a rate times t that is accepted after a time t of a step."""
    size = larger(larger(scale, start * t), abs(truth) * t)
    return fine * size + t * (_SUMS * (start + abs(truth)) + NOTHING)


def defect_of_value(size: Value, truth: Value, fine: Value) -> Value:
    """Return the largest defect of a guard or an observable that is accepted."""
    return (fine + _SUMS) * larger(size, abs(truth)) + NOTHING


# -- thresholds of events and of mode selection
def is_still(begin: Value, total: Value, size: Value) -> Value:
    """Whether a guard is zero throughout, up to rounding."""
    return total + abs(begin) <= 8.0 * EPS * size


def little_acceleration(pull: Value, forces: Value) -> Value:
    """Return the slip acceleration below which it is zero: by tie, or by the rounding of forces that cancel."""
    return larger(TIE * pull, ROUNDING * forces)


def no_acceleration(little: Value, t: Value, jerk: Value) -> Value:
    """Return the same, at least the rounding of time under a fast load."""
    return larger(little, 4.0 * EPS * abs(t) * abs(jerk))


def natural_time(scale: Value, n: Value, horizon: Value) -> Value:
    """Return the natural time: the largest ratio of range to speed of a coordinate, about a radian of its vibration.

    Limited by the run, since the speed of a body carried by a belt changes by rounding alone.
    """
    time = 0.0
    for i in range(n):
        moving = scale[n + i] > 0.0
        time = larger(time, choose(moving, scale[i] / choose(moving, scale[n + i], 1.0), 0.0))
    return choose(time > 0.0, smaller(time, horizon), 1e-3 * horizon)


def instant(t: Value, time: Value) -> Value:
    """Return the rounding error of time, at least that of the natural time."""
    return 4.0 * EPS * larger(abs(t), time)


def doubted_force(least: Value, pull: Value, span: Value, time: Value, doubt: Value) -> Value:
    """Return the possible error of a stick force over its coupling, by rounding and by the error of the run.

    The error of the run is its tolerance times acceleration, range of the slip over the natural time, next to that of
    the bound.
    """
    return larger(least, smaller(MOST_DOUBT * pull, doubt * (pull + span / time)))


def stick_scale(over: Value, under: Value) -> Value:
    """Return the bound of a sticking contact plus the magnitude of its force, from its guards."""
    return 0.5 * abs(over + under) + 0.5 * abs(over - under)
