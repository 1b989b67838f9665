"""Impacts of contacts that open, as CasADi graphs in which what every contact does in the impact is data.

With the rates of the gaps ``a = J_n u + dg/dt`` and the slips w of the contacts that take part, and their impulses,

    u+ = u- + M^-1 (J_n^T P + J_t^T Q),   W = J M^-1 J^T,

every contact does one of the following, where e is its restitution, mu its coefficient and d = +-1 a direction:

    apart     P = 0, Q = 0
    sticks    a+ = e |a-|,   w+ = 0
    slips     a+ = e |a-|,   Q = -d mu P                             towards d
    turns     a+ = e |a-|,   Q = -d mu R + d mu_0 (P - R)            slips towards d until its slip ends at P = R

Several contacts stick with ``|Q| <= mu P``, with mu_s in place of mu where w- = 0. In the plane w and Q are vectors
with two components, the same holds for their lengths, and the direction d = e is a unit vector,

    sticks    a+ = e |a-|,   w+ = 0
    slips     a+ = e |a-|,   Q = -mu P e,  w+ = |w+| e

so that friction opposes the slip after the impact: the impact law of Moreau and Glocker with the disc of Coulomb
friction. Where the slip keeps its direction during the impact, as that of a sphere (``W_tn = 0``, W_tt a multiple of
the identity), it is what the law of friction gives at every instant of the impact. The loop finds the directions e,
see `symfric.solve.loop.events.directions`; one step of Newton's method for ``e x w+ = 0`` here gives their derivatives.

"Turns" is for one contact along a line alone, whose slip ends after the normal impulse
``R = d w- / (mu W_tt - d W_tn)``; that it turns round follows from ``|W_tn| > mu_s W_tt`` (Routh). Margins, which are
not negative where a choice is right, say so in velocities. For several contacts at once this is the complementarity
problem of Moreau and Glocker, whose answer does not depend on their order.

An impact that ends with ``a+ = e |a-|`` can gain energy where friction turns round, or where contacts differ in e. Then
the rate of the gap follows from the work of the normal force, ``W_f = (1 - e^2) W_c`` with the work W_c of compression
(Stronge), for one contact along a line, and from ``a+ = theta e |a-|`` with the largest theta that gains no energy, for
several and in the plane. Without restitution no impact gains energy: the work is ``-mu P |w+|`` less half of the square
of the impulses.

References
----------
Moreau, Unilateral contact and dry friction in finite freedom dynamics, in: Nonsmooth Mechanics and Applications (1988);
Glocker, Set-Valued Force Laws, Dynamics of Non-Smooth Systems (2001), chapter 12.
"""

import casadi as ca

from symfric.lower.constraint_forces import constraint_basis
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.lower.normal_forces import least_normal_forces
from symfric.lower.unilateral import DEPENDENT, approach, eliminated
from symfric.model.scene import Scene

APART, STICKS, SLIPS, TURNS = range(4)  # what a contact does in an impact
# numbers for every contact: what it does, its direction along a line, the part of its restitution, whether it was
# closed, two components of a direction: of the slip in the plane after the impact, or, if it sticks, along a line or in
# the plane, of its slip before it, zero without slip
FIELDS = 6
_NEVER = 1e300
_MET = 1e-9  # relative velocity up to which a dependent contact does what it should


def impact_of(model: ContactDynamics) -> ca.Function | None:
    """Return the function of an impact, None without contacts that open.

    Its arguments are state, time, parameters, and data: for every contact that opens, what it does, its direction, the
    part of its restitution, 1 if it bounces and 0 if the impact is plastic, 1 if it was closed, so that gap and rate
    are zero and are made so, and the two components of its direction in the plane; then 1 for the rule of energy, and 1
    if one contact takes part alone; last, for every contact along a line, 1 if its slip is zero and is made so.

    Its results, by the names of the outputs: states after the impact; gap, and its scale of rounding; rate of the gap
    before it, and its scale; normal force of forces that do not cancel; W of the gap; rate of the gap after it; two
    margins; of those that slip in the plane ``d x w+`` over P with the direction as it is given; the coefficients of
    friction with which every contact that opens slips and sticks, zero without friction; energy gained, and its scale;
    with J the slips of all contacts along a line, then the gaps, ``J M^-1 J^T`` and ``M^-1 J^T``, column by column.
    """
    if not model.openings:
        return None
    model = model.copy()
    n, q, u, t = len(model.openings), model.q, model.u, model.t
    gaps = ca.vertcat(*(e.gap for e in model.openings))
    of_rows = {plane.row: plane for plane in model.planes}
    lines: list[int] = []
    owner: list[int] = []
    planar: dict[int, int] = {}
    for k, e in enumerate(model.openings):
        if e.line in of_rows:
            planar[k] = len(lines)
        rows_of = [e.line, e.line + 1] if e.line in of_rows else [e.line] if e.line >= 0 else []
        lines, owner = lines + rows_of, owner + [k] * len(rows_of)
    along = {f: k for f, k in enumerate(owner) if k not in planar}  # friction along a line
    n_c = model.slip.numel()
    data = ca.SX.sym("data", FIELDS * n + 2 + n_c)
    kind, side, bounces, closed, first_way, second_way = (data[k * n : (k + 1) * n] for k in range(FIELDS))
    energetic, alone, held = data[FIELDS * n], data[FIELDS * n + 1], data[FIELDS * n + 2 :]

    J, rate, _ = approach(gaps, q, u, t)
    still = ca.substitute(model.slip, u, ca.SX.zeros(u.numel())) if n_c else ca.SX(0, 1)
    fixed = ca.vertcat(J, model.slopes) if n_c else J
    basis = constraint_basis(fixed, model.solve(fixed.T), ca.vertcat(closed, held), tested=True)
    u_0 = u + basis.forces(u, ca.vertcat(ca.jacobian(gaps, t), still))[1]
    a = ca.if_else(closed > 0.5, 0, J @ u_0 + ca.jacobian(gaps, t))
    w = (model.slopes[lines, :] @ u_0 + still[lines]) if lines else ca.SX(0, 1)

    rows = ca.vertcat(model.slopes[lines, :], J) if lines else J  # friction first, then the normal directions
    back = model.solve(rows.T)
    W = rows @ back
    n_f = len(lines)
    profile = model.vector([model.contacts[i].profile for i in lines])
    speed_before = [ca.if_else(w[f] < 0, -w[f], w[f]) for f in range(n_f)]  # fabs has a sign as its derivative
    for k, f in planar.items():
        factors = of_rows[model.openings[k].line].factors
        square = ca.sumsqr(w[f : f + 2] if factors is None else w[f : f + 2] / factors)
        moves = square > 0
        speed_before[f] = speed_before[f + 1] = moves * ca.sqrt(ca.if_else(moves, square, 1))
    mu = profile * _column([model.kinetic(i, speed_before[f]) for f, i in enumerate(lines)])
    mu_0, mu_s = (profile * (e[lines] if lines else ca.SX(0, 1)) for e in (model.at_rest, model.static))

    # for one contact alone: where its slip ends, and the rates of the gap by impulse before and behind that
    ends, first, behind = {}, {}, {}
    for f, k in along.items():
        d, tn, tt, nn = side[k], W[f, n_f + k], W[f, f], W[n_f + k, n_f + k]
        slows = mu[f] * tt - d * tn
        ends[f] = ca.if_else(slows > 0, d * w[f] / ca.if_else(slows > 0, slows, 1), _NEVER)
        first[f] = nn - d * mu[f] * tn
        behind[f] = ca.if_else(kind[k] == TURNS, nn + d * mu_0[f] * tn, nn - tn * tn / tt)

    restitution = ca.vertcat(*(e.restitution for e in model.openings)) * bounces
    target = ca.if_else(a < 0, -restitution * a, 0)
    for f, k in along.items():
        by_work = ca.logic_and(ca.logic_and(alone, energetic), kind[k] != SLIPS)
        target[k] = ca.if_else(by_work, _by_work(a[k], restitution[k], ends[f], first[f], behind[f]), target[k])
    size = n_f + n
    A, plastic, bounce = ca.SX(size, size), ca.SX(size, 1), ca.SX(size, 1)
    for f, k in along.items():
        sticks, turns = kind[k] == STICKS, kind[k] == TURNS
        A[f, :] = sticks * W[f, :]
        A[f, f] += 1 - sticks
        A[f, n_f + k] += (kind[k] == SLIPS) * side[k] * mu[f] - turns * side[k] * mu_0[f]
        plastic[f] = -sticks * w[f] - turns * side[k] * (mu[f] + mu_0[f]) * ca.if_else(turns, ends[f], 0)
    for k in range(n):
        strikes = kind[k] != APART
        A[n_f + k, :] = strikes * W[n_f + k, :]
        A[n_f + k, n_f + k] += 1 - strikes
        plastic[n_f + k], bounce[n_f + k] = -strikes * a[k], strikes * target[k]
    before = ca.vertcat(w, a)
    ways = ca.SX.sym("ways", 2 * len(planar))
    for j, (k, f) in enumerate(planar.items()):
        sticks = kind[k] == STICKS
        for c in range(2):
            A[f + c, :] = sticks * W[f + c, :]
            A[f + c, f + c] += 1 - sticks
            A[f + c, n_f + k] += (kind[k] == SLIPS) * mu[f] * ways[2 * j + c]
            plastic[f + c] = -sticks * w[f + c]
    parts = eliminated(A, ca.horzcat(plastic, bounce), DEPENDENT)
    share = _largest_share(parts[:, 0], parts[:, 1], before, W)
    share = ca.if_else(ca.logic_and(energetic, ca.logic_not(alone)), share, 1)
    impulse = parts[:, 0] + share * parts[:, 1]
    after = before + W @ impulse
    swerve = [ca.SX(0)] * n
    if planar:
        given = ca.vertcat(*(ca.vertcat(first_way[k], second_way[k]) for k in planar))
        slips = ca.vertcat(*(kind[k] == SLIPS for k in planar))
        turned, missed = _turned(ways, after, list(planar.values()), slips)
        raw = ca.substitute([missed, impulse], [ways], [given])
        for j, k in enumerate(planar):
            pressed = raw[1][n_f + k]
            swerve[k] = ca.if_else(slips[j], raw[0][j] / ca.if_else(pressed == 0, 1, pressed), 0)
        ways_found = ca.substitute(turned, ways, given)
        impulse, after, share = ca.substitute([impulse, after, share], [ways], [ways_found])
    new = ca.vertcat(q, u_0 + back @ impulse, model.y[2 * q.numel() :])

    one, two, speeds = [], [], ca.sum1(ca.fabs(before))
    slid = first_way**2 + second_way**2 > 0.5
    lines_of = {k: f for f, k in along.items()}
    numbers = {k: j for j, k in enumerate(planar)}
    for k in range(n):
        nn, pressed, left = W[n_f + k, n_f + k], impulse[n_f + k], after[n_f + k]
        missed = left - share * target[k]
        one.append(ca.if_else(kind[k] == APART, missed, _if_met(missed, speeds, pressed * nn)))
        if k in planar:
            f, way = planar[k], ways_found[2 * numbers[k] : 2 * numbers[k] + 2]
            tt, moved = 0.5 * (W[f, f] + W[f + 1, f + 1]), after[f : f + 2]
            bound = ca.if_else(slid[k], mu[f], mu_s[f])
            stuck = _if_met(ca.norm_2(moved), speeds, (bound * pressed - ca.norm_2(impulse[f : f + 2])) * tt)
            across = way[0] * moved[1] - way[1] * moved[0]
            second = ca.if_else(kind[k] == STICKS, stuck, _if_met(across, speeds, ca.dot(way, moved)))
            two.append(ca.if_else(kind[k] == APART, 1, second))
            continue
        if k not in lines_of:
            two.append(ca.SX(1))
            continue
        f = lines_of[k]
        tt, tn, beyond = W[f, f], W[f, n_f + k], (pressed - ends[f]) * nn
        holds = (mu_s[f] * tt - ca.fabs(tn)) * pressed
        bound = ca.if_else(ca.logic_and(slid[k], ca.logic_not(alone)), mu[f], mu_s[f])
        stuck = (bound * pressed - ca.fabs(impulse[f])) * tt
        stuck = ca.if_else(ca.logic_and(alone, side[k] * w[f] > 0), ca.fmin(beyond, holds), stuck)
        stuck = _if_met(after[f], speeds, stuck)
        second = ca.if_else(kind[k] == STICKS, stuck, side[k] * after[f])
        second = ca.if_else(kind[k] == TURNS, ca.fmin(beyond, -holds), second)
        two.append(ca.if_else(kind[k] == APART, 1, second))
    gain = 0.5 * impulse.T @ (before + after)
    scale = 0.5 * ca.fabs(impulse).T @ (ca.fabs(before) + ca.fabs(after))
    speed = ca.fabs(J) @ ca.fabs(u) + ca.fabs(ca.jacobian(gaps, t))
    least = least_normal_forces(model)
    out = [new, gaps, ca.vertcat(*(e.size for e in model.openings)), rate, speed, least, ca.diag(W)[n_f:], after[n_f:]]
    out += [ca.vertcat(*one), ca.vertcat(*two), ca.vertcat(*swerve)]
    rubs = {**lines_of, **planar}
    out += [ca.vertcat(*(c[rubs[k]] if k in rubs else ca.SX(0) for k in range(n))) for c in (mu, mu_s)]
    out += [ca.vertcat(gain, scale)]
    together = ca.vertcat(model.slopes, J)
    answers = model.solve(together.T)
    out += [ca.vec(together @ answers), ca.vec(answers)]
    moving = [e for s in model.springs for e in ca.vertsplit(s.variables)]
    out = ca.substitute([ca.densify(e) for e in out], moving, [ca.SX(0)] * len(moving))
    out = model.unswitched([ca.densify(e) for e in out])
    names = [
        "y_after",
        "gap",
        "size",
        "rate",
        "speed",
        "least",
        "response",
        "after",
        "first",
        "second",
        "swerve",
        "friction",
        "static",
        "gain",
        "coupling",
        "spread",
    ]
    arguments = [model.y, model.t, model.p, data]
    there = ca.Function("there", arguments, out, ["y", "t", "p", "data"], names)
    basis = constraint_basis(J, model.solve(J.T), closed, tested=True)
    shift = basis.forces(ca.SX.zeros(q.numel()), gaps)[1]
    for k in range(n):
        places = ca.sparsify(J[k, :]).sparsity().get_col()
        if len(places) == 1 and J[k, places[0]].is_constant():  # exact, so that a run may start again where one ended
            shift[places[0]] = ca.if_else(closed[k] > 0.5, -gaps[k] / J[k, places[0]], shift[places[0]])
    shift = model.unswitched(ca.substitute([ca.densify(shift)], moving, [ca.SX(0)] * len(moving)))[0]
    moved = ca.vertcat(q + shift, model.y[q.numel() :])
    return ca.Function("impact", arguments, list(there(moved, *arguments[1:])), ["y", "t", "p", "data"], names)


def _turned(ways: ca.SX, after: ca.SX, rows: list[int], slips: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return directions of slips in the plane after one step of Newton's method, and ``d x w+`` before it.

    Parameters
    ----------
    ways : SX
        The directions, two components of each contact in the plane, of which `after` is a function.
    after : SX
        Slips and rates after the impact.
    rows : list of int
        Of every contact in the plane the first component of its slip.
    slips : SX
        Whether each of them slips; the others do not turn.
    """
    n = len(rows)
    missed, turns = ca.SX(n, 1), ca.SX(2 * n, n)
    for j, f in enumerate(rows):
        e, g = ways[2 * j], ways[2 * j + 1]
        missed[j] = slips[j] * (e * after[f + 1] - g * after[f])
        turns[2 * j, j], turns[2 * j + 1, j] = -g, e
    slopes = ca.jacobian(missed, ways) @ turns
    angle = eliminated(slopes + ca.diag(1 - slips), -missed)
    turned = ways + turns @ angle
    for j in range(n):
        pair = turned[2 * j : 2 * j + 2]
        turned[2 * j : 2 * j + 2] = pair / ca.sqrt(ca.if_else(slips[j], ca.sumsqr(pair), 1))
    return turned, missed


def _if_met(missed: ca.SX, speeds: ca.SX, margin: ca.SX) -> ca.SX:
    """Return the margin, or, if a velocity misses what it should be, by how much."""
    return ca.if_else(ca.fabs(missed) <= _MET * speeds, margin, -ca.fabs(missed))


def impact_function(scene: Scene) -> tuple[ca.Function, list[int], list[int]]:
    """Return the function of the impacts of a scene with contacts that open, and the rows of their slips.

    These are the index of each among the contacts along a line, -1 without friction, and those of second components of
    slips in the plane.
    """
    model = ContactDynamics.of(scene)
    impact = impact_of(model)
    assert impact is not None
    return impact, [e.line for e in model.openings], [plane.row + 1 for plane in model.planes]


def _by_work(a: ca.SX, e: ca.SX, end: ca.SX, first: ca.SX, behind: ca.SX) -> ca.SX:
    """Return the rate of a gap after an impact in whose course the slip ends, from the work of the normal force.

    The rate changes by `first` with the impulse until that is `end`, by `behind` from there on.
    """
    then = a + first * end  # rate of the gap when the slip ends
    early = then < 0  # during compression
    work = -0.5 * (ca.if_else(early, (a * a - then * then) / first + then * then / behind, a * a / first))
    late = then * then + behind * (e * e * a * a - then * then) / first
    squared = ca.if_else(early, -2 * behind * e * e * work, late)
    return ca.sqrt(ca.fmax(squared, 0))


def _largest_share(plastic: ca.SX, bounce: ca.SX, before: ca.SX, W: ca.SX) -> ca.SX:
    """Return the share of restitution, at most 1, with which impulses ``plastic + share * bounce`` gain no energy."""
    square = 0.5 * bounce.T @ W @ bounce
    linear = bounce.T @ (before + W @ plastic)
    constant = plastic.T @ (before + 0.5 * W @ plastic)
    gains = square + linear + constant > 0
    root = ca.sqrt(ca.fmax(linear * linear - 4 * square * constant, 0))
    share = -2 * constant / ca.if_else(gains, linear + root, 1)
    return ca.if_else(gains, ca.fmax(share, 0), 1)


def _column(entries: list[ca.SX]) -> ca.SX:
    return ca.vertcat(*entries) if entries else ca.SX(0, 1)
