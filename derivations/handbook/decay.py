"""A mass on a spring slides to rest: Example 19.5, half cycle by half cycle."""

from functools import cache

import sympy as sp

from derivations.handbook.models import A1, A2, B1, B2, Delta, Delta_s, g, i, k, m, mu, omega, t, x, x0
from derivations.ledger import Ledger
from symfric.model import laws

PART = Ledger("handbook", "Example 19.5")

# Vertical balance gives R = m g. Moving left (x' < 0) friction (19.104) acts to the right.


def _newton(side):
    """Right-hand side of m x'' for motion to the side: spring from its potential, friction against the motion."""
    return -sp.diff(k * x**2 / 2, x) - laws.coulomb(mu).kinetic * (m * g) * side


LEFT, RIGHT = -1, 1


@PART.verified("(i)", "m x'' moving to the left", -k * x + mu * m * g)
def _(claim):
    return _newton(LEFT) - claim


@PART.verified("(ii)", "x'' + omega_n^2 x moving to the left", mu * g)
def _(claim):
    return _newton(LEFT).subs(k, m * omega**2) / m + omega**2 * x - claim


# All solutions of (ii) come from one: with x(0) and x'(0) given the solution is unique.


@cache
def _solution(force, position, velocity):
    """Solve x'' + omega_n^2 x = force from position and velocity at t = 0."""
    q = sp.Function("q")
    equation = q(t).diff(t, 2) + omega**2 * q(t) - force
    return sp.dsolve(equation, q(t), ics={q(0): position, q(t).diff(t).subs(t, 0): velocity}).rhs


@PART.verified("(iii)", "homogeneous solution", A1 * sp.sin(omega * t) + A2 * sp.cos(omega * t))
def _(claim):
    return _solution(sp.Integer(0), A2, omega * A1) - claim


@PART.verified("(iv)", "particular solution: the constant one", mu * g / omega**2)
def _(claim):
    return sp.solve(omega**2 * x - mu * g, x)[0] - claim


@PART.verified("(v)", "general solution", A1 * sp.sin(omega * t) + A2 * sp.cos(omega * t) + mu * g / omega**2)
def _(claim):
    return _solution(mu * g, A2 + mu * g / omega**2, omega * A1) - claim


@PART.verified("after (v)", "A1 and A2 of a release from rest at x0", 0, x0 - mu * g / omega**2)
def _(first, second):
    general = A1 * sp.sin(omega * t) + A2 * sp.cos(omega * t) + mu * g / omega**2
    rest = (general.subs(t, 0) - x0, general.diff(t).subs(t, 0))
    found = sp.solve(rest, (A1, A2))
    return found[A1] - first, found[A2] - second


@PART.verified("(vi)", "first half cycle", (x0 - mu * g / omega**2) * sp.cos(omega * t) + mu * g / omega**2)
def _(claim):
    return _solution(mu * g, x0, sp.Integer(0)) - claim


@cache
def _next_rest(force, position):
    """Time and place at which the velocity of `_solution` from rest vanishes for the first time after t = 0."""
    path = _solution(force, position, sp.Integer(0))
    phase = sp.Symbol("phase", positive=True)
    stops = sp.solveset(sp.sin(phase), phase, sp.Interval.Lopen(0, 4))  # x' is proportional to sin(omega_n t)
    assert sp.simplify(path.diff(t) / sp.sin(omega * t)).diff(t) == 0
    time = min(stops) / omega
    return time, sp.simplify(path.subs(t, time))


@PART.verified("before (vii)", "end of the first half cycle", sp.pi / omega)
def _(claim):
    return _next_rest(mu * g, x0)[0] - claim


@PART.verified("(vii)", "position at the end of the first half cycle", -(x0 - 2 * mu * g / omega**2))
def _(claim):
    return _next_rest(mu * g, x0)[1] - claim


@PART.verified("(viii)", "m x'' moving to the right", -k * x - mu * m * g)
def _(claim):
    return _newton(RIGHT) - claim


@PART.verified("(ix)", "x'' + omega_n^2 x moving to the right", -mu * g)
def _(claim):
    return _newton(RIGHT).subs(k, m * omega**2) / m + omega**2 * x - claim


@PART.verified("(x)", "general solution", B1 * sp.sin(omega * t) + B2 * sp.cos(omega * t) - mu * g / omega**2)
def _(claim):
    return _solution(-mu * g, B2 - mu * g / omega**2, omega * B1) - claim


# The second half cycle starts from rest at (vii), at t = pi/omega_n: the same problem with the time counted from there.


@cache
def _second():
    """Second half cycle in the time of the first."""
    time, place = _next_rest(mu * g, x0)
    return sp.expand(sp.expand_trig(_solution(-mu * g, place, sp.Integer(0)).subs(t, t - time)))


@PART.verified("after (x)", "B1 and B2", 0, x0 - 3 * mu * g / omega**2)
def _(first, second):
    path = _second() + mu * g / omega**2
    return path.subs(t, sp.pi / (2 * omega)) - first, path.subs(t, 0) - second


@PART.verified("(xi)", "second half cycle", (x0 - 3 * mu * g / omega**2) * sp.cos(omega * t) - mu * g / omega**2)
def _(claim):
    return _second() - claim


@PART.verified("after (xi)", "end of the second half cycle", 2 * sp.pi / omega)
def _(claim):
    first, place = _next_rest(mu * g, x0)
    return first + _next_rest(-mu * g, place)[0] - claim


@PART.verified("(xii)", "position at the end of the first cycle", x0 - 4 * mu * g / omega**2)
def _(claim):
    return _next_rest(-mu * g, _next_rest(mu * g, x0)[1])[1] - claim


# A cycle takes x_i to x_i - 4 Delta, whatever x_i is: a linear recursion, solved by x_i = x0 - 4 (i - 1) Delta at the
# start of cycle i. From there the two half cycles are (vi) and (xi) with x_i in the place of x0, and because a cycle
# lasts 2 pi/omega_n the cosine is the same in all of them.


@cache
def _start_of_cycle():
    """Return x_i from the map of one cycle."""
    position = sp.Symbol("X", real=True)
    loss = sp.simplify(position - _next_rest(-mu * g, _next_rest(mu * g, position)[1])[1])
    sequence, n = sp.Function("s"), sp.Symbol("n", integer=True)
    found = sp.rsolve(sequence(n + 1) - sequence(n) + loss, sequence(n), {sequence(1): x0})
    return found.subs(n, i).subs(g, Delta * omega**2 / mu)


def _half(side):
    """Path of the left or right half of cycle i, in the time that runs through all cycles."""
    force = -side * Delta * omega**2
    start, begin = _start_of_cycle(), 2 * sp.pi * (i - 1) / omega
    if side == RIGHT:
        time, start = _next_rest(Delta * omega**2, start)
        begin += time
    return sp.expand(sp.expand_trig(_solution(force, start, sp.Integer(0)).subs(t, sp.expand(t - begin))))


@PART.verified("(xiii)", "left motion in cycle i", (x0 - (4 * i - 3) * Delta) * sp.cos(omega * t) + Delta)
def _(claim):
    return _half(LEFT) - claim


@PART.verified("(xiv)", "right motion in cycle i", (x0 - (4 * i - 1) * Delta) * sp.cos(omega * t) - Delta)
def _(claim):
    return _half(RIGHT) - claim


@PART.verified("(xv)", "Delta: displacement at which the spring balances kinetic friction", mu * g / omega**2)
def _(claim):
    return sp.solve(k * x - mu * m * g, x)[0].subs(k, m * omega**2) - claim


@PART.verified("after (xv) equilibria", "centres of the left and of the right motion", Delta, -Delta)
def _(left, right):
    centre = {side: sp.solve(_newton(side), x)[0].subs(k, mu * m * g / Delta) for side in (LEFT, RIGHT)}
    return centre[LEFT] - left, centre[RIGHT] - right


# Another half cycle needs a spring force above static friction at its start. With Delta_s = f_s/k that is
# |position| > Delta_s. The handbook has one coefficient, Delta_s = Delta, and asks for a positive amplitude of the
# cosine, which is the same: the amplitude is |position| - Delta.


@cache
def _starts():
    """Distances from the origin at which the left and right motions of cycle i start."""
    start = _start_of_cycle()
    return start, -_next_rest(Delta * omega**2, start)[1]


@PART.verified(
    "after (xv) bounds", "least x0 for the left and right motion of cycle i", (4 * i - 3) * Delta, (4 * i - 1) * Delta
)
def _(left, right):
    # x0 enters the amplitude of the cosine, (path - centre) at the start
    return [sp.solve(start - Delta, x0)[0] - claim for start, claim in zip(_starts(), (left, right), strict=True)]


@PART.verified(
    "after (xv) bounds with static friction",
    "the same for Delta_s >= Delta; beyond the source",
    (4 * i - 4) * Delta + Delta_s,
    (4 * i - 2) * Delta + Delta_s,
    note="the printed bounds are those of Delta_s = Delta; a positive amplitude alone is necessary, not sufficient",
)
def _(left, right):
    return [sp.solve(start - Delta_s, x0)[0] - claim for start, claim in zip(_starts(), (left, right), strict=True)]
