"""Vibration and Shock Handbook, section 19.5: models of interface damping, and the mass that slides to rest."""

from fractions import Fraction
from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from symfric.model import laws
from symfric.model.names import SPEED
from symfric.theory import transient

LEDGER = Ledger("handbook", "de Silva (ed.), Vibration and Shock Handbook, Taylor & Francis 2005, section 19.5")

m, k, g, mu, R, omega = sp.symbols("m k g mu R omega_n", positive=True)
f_s, f_d, v_c, b, V = sp.symbols("f_s f_d v_c b V", positive=True)
alpha, x, v, y = sp.symbols("alpha x v y", real=True)
t = sp.Symbol("t", nonnegative=True)
A1, A2, B1, B2 = sp.symbols("A1 A2 B1 B2", real=True)
i = sp.Symbol("i", integer=True, positive=True)
x0 = transient.SYMBOLS.x0  # real; the example releases the mass at x0 > 0
Delta, Delta_s = transient.SYMBOLS.delta, transient.SYMBOLS.delta_s

# --- Models of interface damping ---------------------------------------------------------------------------------
# A dry contact opposes the sliding: the force on the sliding body is -f with f = mu R sgn v. What makes it damping is
# the power it takes, f v, which is never negative.

LEDGER.definition("(19.104)", "Coulomb friction", laws.coulomb(mu).kinetic * R * sp.sign(v))


@LEDGER.verified("(19.104) power", "Coulomb friction takes mu R |v| in both directions", mu * R * sp.Abs(v))
def _(claim):
    force = laws.coulomb(mu).kinetic * R * sp.sign(v)
    return [(force * v - claim).subs(v, side * V) for side in (1, -1)]


# At rest the friction has no value of its own. Under an applied force F with |F| <= f_s the body does not move, so its
# acceleration (F - f)/m must vanish. With f = f_s the body would accelerate against the force that holds it.
F = sp.Symbol("F", real=True)


@LEDGER.corrected(
    "(19.105) at rest",
    "static friction balances the applied force F, as long as |F| <= f_s",
    right=F,
    printed=f_s,
    note="f = f_s at v = 0 is the largest value, not the value: with F = f_s/2 it would push the body backwards",
)
def _(claim):
    acceleration = sp.Symbol("a", real=True)
    (held,) = sp.solve(m * acceleration - (F - claim), acceleration)
    return held


LEDGER.definition(
    "(19.105) sliding",
    "kinetic friction and viscous damping; f_sb(|v|) >= 0 is the magnitude",
    sp.Function("f_sb")(sp.Abs(v)) * sp.sign(v) + b * v,
    note="the laws of symfric carry b v in their kinetic part, and f_s as their static coefficient",
)
LEDGER.definition("(19.106)", "Stribeck effect, Lorentz form", laws.lorentz(f_d, v_c).kinetic)
LEDGER.definition(
    "(19.107)",
    "Stribeck effect, Gauss form",
    laws.gauss(f_d, v_c).kinetic,
    note="the exponent is -(v/v_c)^2; the transcript has lost its minus sign",
)

# (19.108) carries sgn v, and (19.105) multiplies by sgn v once more. Sliding backwards, friction would then point
# along the motion and feed it. The sign must enter once: power f v = (f_d + alpha |v|^(1/2)) |v| + b v^2.


@LEDGER.corrected(
    "(19.108)",
    "square-root law in (19.105), whole force",
    right=(f_d + alpha * sp.sqrt(sp.Abs(v))) * sp.sign(v) + b * v,
    printed=(f_d + alpha * sp.sqrt(sp.Abs(v))) * sp.sign(v) ** 2 + b * v,
    note="(19.108) already has sgn v; put into (19.105) as printed the sign is squared and friction drives v < 0",
)
def _(claim):
    magnitude = laws.square_root(f_d, alpha, b=b).kinetic.subs(SPEED, V)
    return [(claim * v).subs(v, side * V) - magnitude * V for side in (1, -1)]


# What the text says about the constants. f_d is the friction that is left when the motion has just begun, v -> 0; it
# is not the friction at large speed, where (19.106) and (19.107) vanish and only b v remains.
FALLING = (("(19.106)", laws.lorentz(f_d, v_c, b=b)), ("(19.107)", laws.gauss(f_d, v_c, b=b)))
for _number, _law in FALLING:

    @LEDGER.verified(f"{_number} at v -> 0", "f_d is the force needed just after breaking away", f_d)
    def _(claim, law=_law):
        return sp.limit(law.kinetic, SPEED, 0, "+") - claim

    @LEDGER.verified(f"{_number} region 3", "viscous damping alone at high speed: f/v tends to b", b)
    def _(claim, law=_law):
        return sp.limit(law.kinetic / SPEED, SPEED, sp.oo) - claim

    # Region 1 of figure 19.15: (19.106) and (19.107) leave f_d with a horizontal tangent, so that b v decides.

    @LEDGER.corrected(
        f"{_number} region 1",
        "slope of friction at v -> 0",
        right=b,
        printed="negative slope in regions 1 and 2",
        note="f_sb starts with slope 0, so the total slope at v -> 0 is b >= 0; only region 2 is unstable. The "
        "statement holds for (19.108) with alpha < 0, where the slope starts from -infinity",
        audit="not among its corrections",
    )
    def _(claim, law=_law):
        return sp.limit(law.kinetic.diff(SPEED), SPEED, 0, "+") - claim


# Region 2 exists only if the fall of f_sb beats the viscous rise somewhere. The steepest fall is where the second
# derivative vanishes; b must stay below it.
STEEPEST = (
    ("(19.106)", laws.lorentz(f_d, v_c), 3 * sp.sqrt(3) * f_d / (8 * v_c)),
    ("(19.107)", laws.gauss(f_d, v_c), sp.sqrt(2 / sp.E) * f_d / v_c),
)
for _number, _law, _bound in STEEPEST:

    @LEDGER.verified(f"{_number} region 2", "viscous coefficient from which no slope is negative", _bound)
    def _(claim, law=_law):
        slope = law.kinetic.diff(SPEED)
        return [-slope.subs(SPEED, turn) - claim for turn in sp.solve(slope.diff(SPEED), SPEED)]


@LEDGER.verified("(19.108) region 2", "speed at which friction is least, for alpha = -|alpha|", V**2 / (4 * b**2))
def _(claim):
    slope = laws.square_root(f_d, -V, b=b).kinetic.diff(SPEED)  # V stands for |alpha|
    return sp.solve(slope, SPEED)[0] - claim


# --- Example 19.5: a mass on a spring slides to rest -------------------------------------------------------------
# Vertical balance gives R = m g. Moving left (x' < 0) friction (19.104) acts to the right.


def _newton(side):
    """Right-hand side of m x'' for motion to the side: spring from its potential, friction against the motion."""
    return -sp.diff(k * x**2 / 2, x) - laws.coulomb(mu).kinetic * (m * g) * side


LEFT, RIGHT = -1, 1


@LEDGER.verified("(i)", "m x'' moving to the left", -k * x + mu * m * g)
def _(claim):
    return _newton(LEFT) - claim


@LEDGER.verified("(ii)", "x'' + omega_n^2 x moving to the left", mu * g)
def _(claim):
    return _newton(LEFT).subs(k, m * omega**2) / m + omega**2 * x - claim


# All solutions of (ii) come from one: with x(0) and x'(0) given the solution is unique.


@cache
def _solution(force, position, velocity):
    """Solve x'' + omega_n^2 x = force from position and velocity at t = 0."""
    q = sp.Function("q")
    equation = q(t).diff(t, 2) + omega**2 * q(t) - force
    return sp.dsolve(equation, q(t), ics={q(0): position, q(t).diff(t).subs(t, 0): velocity}).rhs


@LEDGER.verified("(iii)", "homogeneous solution", A1 * sp.sin(omega * t) + A2 * sp.cos(omega * t))
def _(claim):
    return _solution(sp.Integer(0), A2, omega * A1) - claim


@LEDGER.verified("(iv)", "particular solution: the constant one", mu * g / omega**2)
def _(claim):
    return sp.solve(omega**2 * x - mu * g, x)[0] - claim


@LEDGER.verified("(v)", "general solution", A1 * sp.sin(omega * t) + A2 * sp.cos(omega * t) + mu * g / omega**2)
def _(claim):
    return _solution(mu * g, A2 + mu * g / omega**2, omega * A1) - claim


@LEDGER.verified("after (v)", "A1 and A2 of a release from rest at x0", 0, x0 - mu * g / omega**2)
def _(first, second):
    general = A1 * sp.sin(omega * t) + A2 * sp.cos(omega * t) + mu * g / omega**2
    rest = (general.subs(t, 0) - x0, general.diff(t).subs(t, 0))
    found = sp.solve(rest, (A1, A2))
    return found[A1] - first, found[A2] - second


@LEDGER.verified("(vi)", "first half cycle", (x0 - mu * g / omega**2) * sp.cos(omega * t) + mu * g / omega**2)
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


@LEDGER.verified("before (vii)", "end of the first half cycle", sp.pi / omega)
def _(claim):
    return _next_rest(mu * g, x0)[0] - claim


@LEDGER.verified("(vii)", "position at the end of the first half cycle", -(x0 - 2 * mu * g / omega**2))
def _(claim):
    return _next_rest(mu * g, x0)[1] - claim


@LEDGER.verified("(viii)", "m x'' moving to the right", -k * x - mu * m * g)
def _(claim):
    return _newton(RIGHT) - claim


@LEDGER.verified("(ix)", "x'' + omega_n^2 x moving to the right", -mu * g)
def _(claim):
    return _newton(RIGHT).subs(k, m * omega**2) / m + omega**2 * x - claim


@LEDGER.verified("(x)", "general solution", B1 * sp.sin(omega * t) + B2 * sp.cos(omega * t) - mu * g / omega**2)
def _(claim):
    return _solution(-mu * g, B2 - mu * g / omega**2, omega * B1) - claim


# The second half cycle starts from rest at (vii), at t = pi/omega_n: the same problem with the time counted from there.


@cache
def _second():
    """Second half cycle in the time of the first."""
    time, place = _next_rest(mu * g, x0)
    return sp.expand(sp.expand_trig(_solution(-mu * g, place, sp.Integer(0)).subs(t, t - time)))


@LEDGER.verified("after (x)", "B1 and B2", 0, x0 - 3 * mu * g / omega**2)
def _(first, second):
    path = _second() + mu * g / omega**2
    return path.subs(t, sp.pi / (2 * omega)) - first, path.subs(t, 0) - second


@LEDGER.verified("(xi)", "second half cycle", (x0 - 3 * mu * g / omega**2) * sp.cos(omega * t) - mu * g / omega**2)
def _(claim):
    return _second() - claim


@LEDGER.verified("after (xi)", "end of the second half cycle", 2 * sp.pi / omega)
def _(claim):
    first, place = _next_rest(mu * g, x0)
    return first + _next_rest(-mu * g, place)[0] - claim


@LEDGER.verified("(xii)", "position at the end of the first cycle", x0 - 4 * mu * g / omega**2)
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


@LEDGER.verified("(xiii)", "left motion in cycle i", (x0 - (4 * i - 3) * Delta) * sp.cos(omega * t) + Delta)
def _(claim):
    return _half(LEFT) - claim


@LEDGER.verified("(xiv)", "right motion in cycle i", (x0 - (4 * i - 1) * Delta) * sp.cos(omega * t) - Delta)
def _(claim):
    return _half(RIGHT) - claim


@LEDGER.verified("(xv)", "Delta: displacement at which the spring balances kinetic friction", mu * g / omega**2)
def _(claim):
    return sp.solve(k * x - mu * m * g, x)[0].subs(k, m * omega**2) - claim


@LEDGER.verified("after (xv) equilibria", "centres of the left and of the right motion", Delta, -Delta)
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


@LEDGER.verified(
    "after (xv) bounds", "least x0 for the left and right motion of cycle i", (4 * i - 3) * Delta, (4 * i - 1) * Delta
)
def _(left, right):
    # x0 enters the amplitude of the cosine, (path - centre) at the start
    return [sp.solve(start - Delta, x0)[0] - claim for start, claim in zip(_starts(), (left, right), strict=True)]


@LEDGER.verified(
    "after (xv) bounds with static friction",
    "the same for Delta_s >= Delta; beyond the source",
    (4 * i - 4) * Delta + Delta_s,
    (4 * i - 2) * Delta + Delta_s,
    note="the printed bounds are those of Delta_s = Delta; a positive amplitude alone is necessary, not sufficient",
)
def _(left, right):
    return [sp.solve(start - Delta_s, x0)[0] - claim for start, claim in zip(_starts(), (left, right), strict=True)]


# --- The stop ----------------------------------------------------------------------------------------------------
# Each half cycle turns the distance a into 2 Delta - a on the other side: a_n = |x0| - 2 n Delta, position
# (-1)^n sgn(x0) a_n. The mass stays where |a_n| <= Delta_s for the first time. It moved from
# a_(n-1) > Delta_s >= Delta, so a_n > Delta_s - 2 Delta >= -Delta_s: the absolute value never matters, and N is the
# least n >= 0 with |x0| - 2 n Delta <= Delta_s, that is N = max(0, ceil((|x0| - Delta_s)/(2 Delta))). Equality is a
# stop: static friction carries up to f_s, included. With Delta_s > 2 Delta the mass can even stay on the side from
# which it came.
#
# The claim is compared with the motion itself, half cycle by half cycle in exact numbers: ties, points 1e-30 to both
# sides of ties, starts on both sides, Delta_s = Delta and above.
_TINY = Fraction(1, 10**30)
_DATA = tuple(
    (delta, ratio * delta, sign * (ratio * delta + (2 * n + shift) * delta))
    for delta in (Fraction(1, 10), Fraction(3, 7))
    for ratio in (1, Fraction(3, 2), 2, 4)
    for n in (0, 1, 2, 5)
    for shift in (0, _TINY, -_TINY, Fraction(1, 3))
    for sign in (1, -1)
)


def _walk(delta, delta_s, start):
    """Count half cycles and return where the mass stays."""
    n, position = 0, start
    while abs(position) > delta_s:
        side = LEFT if position > 0 else RIGHT
        n, position = n + 1, -2 * side * delta - position
    return n, position


@LEDGER.verified(
    "Example 19.5 one half cycle",
    "turning point after a start at X, to the left and to the right",
    2 * Delta - V,
    -2 * Delta + V,
)
def _(left, right):
    # the map used by _walk, from the solved equation; V > 0 is the distance from which it starts
    force = Delta * omega**2
    return _next_rest(force, V)[1] - left, _next_rest(-force, -V)[1] - right


def _misfit(claim, expected):
    """Sum of |claim - expected(half cycles, rest)| over the data."""
    total = 0
    for data in _DATA:
        numbers = dict(zip(transient.SYMBOLS, map(_exact, data), strict=False))  # omega_n stays a symbol
        total += abs(claim.xreplace(numbers) - expected(*_walk(*data)))
    return total


def _exact(number):
    return sp.Rational(*number.as_integer_ratio())


@LEDGER.verified(
    "Example 19.5 half cycles",
    "N until it stays at rest, Delta_s >= Delta",
    transient.half_cycles(symbolic=True),
    numbers=f"against the motion in exact numbers, {len(_DATA)} starts",
)
def _(claim):
    return _misfit(claim, lambda n, rest: n)


@LEDGER.verified(
    "Example 19.5 rest",
    "where it stays, within Delta_s",
    transient.stop_position(symbolic=True),
    note="2 N Delta takes the sign of x0",
    audit="has (-1)^N (x0 - 2 N Delta), which holds for x0 > 0 only",
    numbers=f"against the motion in exact numbers, {len(_DATA)} starts",
)
def _(claim):
    return _misfit(claim, lambda n, rest: _exact(rest))


@LEDGER.verified(
    "Example 19.5 time",
    "when it stays, all half cycles being equal",
    transient.stop_time(symbolic=True),
    numbers=f"against the motion in exact numbers, {len(_DATA)} starts",
)
def _(claim):
    each = _next_rest(Delta * omega**2, V)[0]
    return _misfit(claim, lambda n, rest: n * each)


NUMBERS = (
    (sp.Rational(3, 100), 17, sp.Rational(1, 50)),
    (sp.Rational(1, 10), 5, 0),
    (sp.Rational(1, 3), 1, -sp.Rational(1, 3)),
)
for _delta, _n, _rest in NUMBERS:

    @LEDGER.verified(f"Example 19.5 Delta = {_delta}", "N and rest from x0 = 1, Delta_s = Delta", _n, _rest)
    def _(halves, rest, delta=_delta):
        n, position = _walk(*(Fraction(e.p, e.q) for e in (delta, delta, sp.Integer(1))))
        found = transient.half_cycles(delta), transient.stop_position(delta)
        return n - halves, _exact(position) - rest, found[0] - halves, _exact(found[1]) - rest


# --- Section 19.5.2: instability ---------------------------------------------------------------------------------
# (19.109) is the motion of a mass that slides steadily at speed V over its counterpart, disturbed by y: the friction
# f(V + y') expanded about V. So b there is the slope of friction at V, not a property of the origin.
FRICTION = laws.lorentz(f_d, v_c, b=b).kinetic
SLOPE = FRICTION.diff(SPEED).subs(SPEED, V)
y1, y2 = sp.symbols("y1 y2", real=True)  # y', y''


@LEDGER.verified("(19.109)", "b is the slope of friction at the nominal sliding speed V", m * y2 + SLOPE * y1 + k * y)
def _(claim):
    small = sp.Symbol("epsilon", positive=True)
    steady = -FRICTION.subs(SPEED, V) / k  # position of steady sliding
    newton = m * small * y2 + k * (steady + small * y) + FRICTION.subs(SPEED, V + small * y1)
    return newton.diff(small).subs(small, 0) - claim


@LEDGER.verified("after (19.109) growth", "growth rate of an oscillation for b^2 < 4 m k", -alpha / (2 * m))
def _(claim):
    rate = sp.Symbol("lambda")
    roots = sp.roots(m * rate**2 + alpha * rate + k, rate)  # alpha stands for b of either sign; the roots are conjugate
    return sum(roots) / 2 - claim


# The text starts from x' = 0 and takes b < 0 there. Without nominal sliding friction reverses with x', and an
# expansion about the origin does not exist: the energy changes at the rate -f x' = -f_sb(|x'|) |x'| - b x'^2 <= 0.


@LEDGER.corrected(
    "after (19.109) from rest",
    "rate of change of the energy without nominal sliding, speed V",
    right=-FRICTION.subs(SPEED, V) * V,
    printed=-FRICTION.diff(SPEED).subs(SPEED, V) * V**2,
    note="negative at every speed, while the printed reading, -f'(V) V^2, is positive where friction falls: nothing "
    "is destabilised unless the surfaces slide past each other on average",
)
def _(claim):
    rates = []
    for side in (1, -1):
        velocity = side * V
        acceleration = (-k * x - FRICTION.subs(SPEED, V) * side) / m
        rates.append(m * velocity * acceleration + k * x * velocity - claim)
    return rates


# "The growing and decaying cycle" settles on a limit cycle. To first order in the friction its frequency is that of the
# spring and the mass: with y = A cos p, y' = -A omega_n sin p the shift is proportional to the mean of f cos p, which
# vanishes for every f that depends on the velocity alone. Carried out for a friction of degree five about V.


@LEDGER.verified("after (19.109) frequency", "shift of frequency by friction, first order", 0)
def _(claim):
    p = sp.Symbol("p", real=True)
    amplitude, coefficients = sp.Symbol("A", positive=True), sp.symbols("f0:6", real=True)
    force = sum(c * (-amplitude * omega * sp.sin(p)) ** n for n, c in enumerate(coefficients))
    return sp.integrate(sp.expand(force * sp.cos(p)), (p, 0, 2 * sp.pi)) / (2 * sp.pi * m * omega * amplitude) - claim
