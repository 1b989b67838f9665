"""Friction with memory: what follows from the rates and the forces that the laws of the package have.

Letters: w the slip velocity, v its magnitude, z the state of the contact; the coefficient of friction is against the
slip if it is positive. A motion without inertia takes its path x as time: dz/dx = z'/w.
"""

from functools import cache

import mpmath as mp
import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree, less
from symfric.model import laws
from symfric.model.laws.memory import SIDE, SLIP
from symfric.model.symbols import SPEED
from symfric.theory import presliding

LEDGER = Ledger(
    "presliding",
    "Laws with memory (Dahl 1968, Iwan 1966, Segalman 2005, Canudas de Wit et al. 1995, Dieterich 1979, Ruina 1983); "
    "formulas as `symfric.laws` and `symfric.theory.presliding` have them.",
)

mu, s, s1, s2, v, v_s, k, limit, X, d, x = sp.symbols("mu_c sigma sigma1 sigma2 v v_s k limit X d x", positive=True)
more, y, w = sp.symbols("more y w", positive=True)  # mu_s - mu_c; sigma z/g; a slip forward
R, c, phi, phi_max = sp.symbols("R c phi phi_max", positive=True)  # c = chi + 1
f1, f2 = sp.symbols("f_1 f_2", positive=True)
alpha, beta, gamma = sp.symbols("alpha beta gamma", positive=True)
mu0, a, b, D, V0, N, m = sp.symbols("mu_0 a b D_c V_0 N m", positive=True)


def moving(e: sp.Expr, way: int, speed: sp.Expr = v) -> sp.Expr:
    """Return an expression of a law for slip forward or backward."""
    return e.xreplace({SLIP: way * speed, SPEED: speed, SIDE: sp.Integer(way)})


def along_path(law, way: int) -> sp.Expr:
    """Return dz/dx, with x along the axis of the slip."""
    return sp.expand(moving(law.memory.rates[0], way) / (way * v))


def state(law) -> sp.Symbol:
    """Return the state of a law that has one."""
    return law.memory.symbols[0]


# --- Dahl ----------------------------------------------------------------------------------------------------------
DAHL = laws.dahl(mu, s)


@LEDGER.verified(
    "Dahl reversal",
    "coefficient a distance x after a reversal of steady sliding",
    mu * (1 - 2 * sp.exp(-s * x / mu)),
    numbers="identity; the solver's number with 9 digits",
)
def _(claim):
    slope = s * along_path(DAHL, 1).subs(state(DAHL), claim / s)
    at = {mu: sp.Rational(3, 10), s: 20, x: sp.Rational(1, 50)}
    return [sp.simplify(claim.diff(x) - slope), claim.subs(x, 0) + mu, agree(_solved_reversal(), claim.subs(at), 9)]


@cache
def _solved_reversal() -> sp.Float:
    """Return the coefficient of the compiled motion: slip backward for long, then forward by 1/50."""
    from symfric.model.outputs import End
    from symfric.model.scene import Scene
    from symfric.model.system import Contact, System
    from symfric.solve.routes import simulate

    q, u = sp.symbols("q u", real=True)
    contact = Contact("floor", u, 1, laws.dahl(0.3, 20.0))
    start = {q: 0.0, u: -0.2, "floor.z": -0.3 / 20}
    heavy = System([q], [u], [[sp.Float("1e14")]], [sp.Float("1e14") * sp.Rational(3, 10)])
    # x' = -0.2 + 0.3 t: it turns at t = 2/3, and is 1/50 beyond its turn at t = 2/3 + sqrt(0.04/0.3)
    end = 2 / mp.mpf(3) + mp.sqrt(mp.mpf("0.04") / mp.mpf("0.3"))
    run = simulate(Scene(heavy, [contact], {}, start, float(end), {"end": End()}), 1e-13)
    return sp.Float(20 * run.final[2])


def dahl_branch(way: int, start: sp.Expr) -> sp.Expr:
    """Return the coefficient along x from -way X with a given value there, in slip of one direction."""
    return way * mu + (start - way * mu) * sp.exp(-s * (X + way * x) / mu)


@LEDGER.verified("Dahl turning points", "coefficient at the ends -X and X of a closed loop", mu * sp.tanh(s * X / mu))
def _(claim):
    turn = claim.rewrite(sp.exp)
    up, down = dahl_branch(1, -turn), dahl_branch(-1, turn)
    ode = [
        sp.simplify(e.diff(x) - s * along_path(DAHL, way).subs(state(DAHL), e / s)) for e, way in ((up, 1), (down, -1))
    ]
    return [*ode, sp.simplify(up.subs(x, X) - turn), sp.simplify(down.subs(x, -X) + turn)]


@LEDGER.verified(
    "Dahl loop", "energy dissipated in a cycle between -X and X, per load", 4 * mu * (X - mu / s * sp.tanh(s * X / mu))
)
def _(claim):
    turn = (mu * sp.tanh(s * X / mu)).rewrite(sp.exp)
    area = sp.integrate(sp.expand(dahl_branch(1, -turn)), (x, -X, X)) - sp.integrate(
        sp.expand(dahl_branch(-1, turn)), (x, -X, X)
    )
    return sp.simplify(area - claim.rewrite(sp.exp))


# --- LuGre ---------------------------------------------------------------------------------------------------------
LUGRE = laws.lugre(mu + more, mu, v_s, s, s1, s2)
G = mu + more * sp.exp(-((v / v_s) ** 2))


@LEDGER.verified("LuGre steady sliding", "deflection, and coefficient at the speed v", G / s, G + s2 * v)
def _(deflection, coefficient):
    z = sp.solve(moving(LUGRE.memory.rates[0], 1), state(LUGRE))[0]
    return less([z, moving(LUGRE.memory.force, 1).subs(state(LUGRE), z)], [deflection, coefficient])


@LEDGER.verified(
    "LuGre linearisation",
    "at rest: stiffness and damping of the bristles per load; in steady sliding: decay rate of z, slope of the "
    "friction over the speed once z has followed",
    s,
    s1 + s2,
    s * v / G,
    sp.diff(G, v) + s2,
)
def _(stiffness, damping, rate, slope):
    z, force, change = state(LUGRE), LUGRE.memory.force, LUGRE.memory.rates[0]
    rest = {z: 0, w: 0}
    force_0, rate_0 = (moving(e, 1, w) for e in (force, change))
    at_rest = [(force_0 - s1 * rate_0).diff(z).subs(rest), force_0.diff(w).subs(rest)]
    follows = rate_0.diff(w).subs(rest) - 1  # z' = w: the bristles follow the body
    steady = {z: G / s}
    force_v, rate_v = (moving(e, 1) for e in (force, change))
    decay = -rate_v.diff(z).subs(steady)
    total = force_v.diff(v) - force_v.diff(z) * rate_v.diff(v) / rate_v.diff(z)
    found = [*at_rest, decay, total.subs(steady)]
    return [follows, *map(sp.simplify, less(found, [stiffness, damping, rate, slope]))]


@LEDGER.verified(
    "LuGre passivity",
    "power that becomes heat with y = sigma z/g; its factor of w^2 at the largest y = mu_s/mu_c, the condition",
    v**2 * (s1 * (1 - y) + s2) + G * v * y**2,
    s2 - s1 * more / mu,
)
def _(power, condition):
    z, memory = state(LUGRE), LUGRE.memory
    found = moving(memory.dissipation, 1).subs(z, y * G / s)
    bound = moving(memory.rates[0], 1).subs(z, (mu + more) / s)  # not positive: |z| stays below mu_s/sigma
    inward = sp.simplify(bound * G / v + more * (1 - sp.exp(-((v / v_s) ** 2))))
    worst = sp.expand(power).coeff(s1) * s1 + s2 * v**2
    at_worst = sp.simplify(worst.subs(y, (mu + more) / mu) / v**2 - condition)
    return [sp.simplify(found - power), inward, at_worst, sp.simplify(memory.passive - condition)]


@LEDGER.verified(
    "LuGre drift",
    "creep in a cycle of a slow load between f_1 and f_2 below the limit mu_c = mu_s",
    mu / s * sp.log((mu**2 - f1**2) / (mu**2 - f2**2)),
)
def _(claim):
    law = laws.lugre(mu, mu, v_s, s)
    z, f = state(law), sp.Symbol("f", positive=True)
    up, down = (1 / (s * along_path(law, way).subs(z, f / s)) for way in (1, -1))  # dx/df
    each = up - down  # what the way from f to f + df and back leaves
    return [
        sp.simplify(claim.diff(f2) - each.subs(f, f2)),
        sp.simplify(claim.diff(f1) + each.subs(f, f1)),
        claim.subs(f1, f2),
    ]


# --- Springs with sliders ------------------------------------------------------------------------------------------
@LEDGER.verified(
    "Masing",
    "force of an element a distance d after a reversal of steady sliding: its first loading at twice the size",
    limit - 2 * sp.Min(k * d / 2, limit),
    numbers="exact at 6 distances",
)
def _(claim):
    law = laws.maxwell_slip([k], [limit])
    (z,), (rate,), (most,) = law.memory.symbols, law.memory.rates, law.memory.limits
    left = []
    for part in map(sp.Rational, ("1/7", "1/2", "13/9", "2", "17/8", "5")):
        distance = part * limit / k
        bent = sp.Max(-1, (most - distance * moving(rate, -1) / -v) / most) * most  # down to -limit
        found = law.memory.force.subs({z: bent, SLIP: 0})
        left.append(sp.simplify(found - claim.subs(d, distance)))
    return left


@LEDGER.verified(
    "loop of an element", "energy dissipated between -X and X beyond its limit", 4 * limit * (X - limit / k)
)
def _(claim):
    turn = -X + 2 * limit / k  # where the slider moves again
    up = sp.integrate(-limit + k * (x + X), (x, -X, turn)) + limit * (X - turn)
    return sp.expand(2 * up - claim)


@LEDGER.verified(
    "Iwan backbone",
    "coefficient of sliders of density R phi^chi, chi = c - 1, on first loading up to X < phi_max",
    R * (X ** (c + 1) / (c + 1) + X * (phi_max**c - X**c) / c),
)
def _(claim):
    density = R * phi ** (c - 1)
    sliding, held = sp.powsimp(density * phi), density
    total = sp.integrate(sliding, (phi, 0, X)) + X * sp.integrate(held, (phi, X, phi_max))
    return sp.simplify(sp.expand(total - claim))


@LEDGER.verified(
    "Iwan dissipation",
    "energy of a cycle of amplitude X, per load, chi = c - 1",
    4 * R * X ** (c + 2) / ((c + 2) * (c + 1)),
)
def _(claim):
    loop = sp.expand(4 * phi * (X - phi) * R * phi ** (c - 1))  # 4 limit (X - limit/k) of unit stiffness
    return sp.simplify(sum(sp.integrate(sp.powsimp(e), (phi, 0, X)) for e in sp.Add.make_args(loop)) - claim)


@LEDGER.verified(
    "Iwan elements",
    "stiffness and limit of all elements of the assembly",
    R * phi_max**c / c,
    R * phi_max ** (c + 1) / (c + 1),
)
def _(stiffness, most):
    law = laws.iwan(R, c - 1, phi_max, elements=3)
    return sp.simplify(law.stiffness - stiffness), sp.simplify(law.steady - most)


@LEDGER.verified(
    "Bouc-Wen",
    "for n = 1 and 2: coefficient in steady sliding; heat with z along and against the slip",
    *(alpha / (beta + gamma), sp.sqrt(alpha / (beta + gamma))),
    *(
        e
        for n in (1, 2)
        for e in (v * y ** (n + 1) * (beta + gamma) / alpha, v * y ** (n + 1) * (beta - gamma) / alpha)
    ),
)
def _(*claim):
    steady, heat = [], []
    for n in (1, 2):
        law = laws.bouc_wen(alpha, beta, gamma, n)
        z = state(law)
        rate = moving(law.memory.rates[0], 1).subs(z, y)
        steady += [e for e in sp.solve(rate, y) if e != 0]
        heat += [sp.simplify(moving(law.memory.dissipation, way).subs(z, y)) for way in (1, -1)]
    return map(sp.simplify, less([*steady, *heat], claim))


# --- Rate and state ------------------------------------------------------------------------------------------------
@LEDGER.verified("rate and state, steady", "coefficient at the speed v", mu0 + (a - b) * sp.log(v / V0))
def _(claim):
    left = []
    for name in ("aging", "slip"):
        law = _fault(name)
        z = sp.log(V0 / v)
        left += [
            moving(law.memory.rates[0], 1).subs(state(law), z),
            moving(law.memory.force, 1).subs(state(law), z) - claim,
        ]
    return [sp.simplify(sp.expand_log(sp.expand(e), force=True)) for e in left]


@LEDGER.verified(
    "rate and state, critical stiffness",
    "of the spring of a body of mass m under the load N, below which steady sliding is unstable",
    N * (b - a) / D * (1 + m * v**2 / (N * a * D)),
)
def _(claim):
    left = []
    for name in ("aging", "slip"):
        law = _fault(name)
        z, at = state(law), {state(law): sp.log(V0 / v)}
        force, rate = (moving(e, 1) for e in (law.memory.force, law.memory.rates[0]))
        f_w, f_z, z_w, z_z = (
            sp.simplify(e.diff(by).subs(at)) for e, by in ((force, v), (force, z), (rate, v), (rate, z))
        )
        # (p - z_z)(m p^2 + N f_w p + k) + N f_z z_w p: two roots are imaginary where Hurwitz's determinant vanishes
        p = sp.Symbol("p")
        a3, a2, a1, a0 = sp.Poly((p - z_z) * (m * p**2 + N * f_w * p + k) + N * f_z * z_w * p, p).all_coeffs()
        (found,) = sp.solve(a2 * a1 - a3 * a0, k)
        left.append(sp.simplify(found - claim))
    return left


def _fault(name: str):
    """Return the law with the logarithm, without the rounding of speeds near zero."""
    law = laws.rate_and_state(mu0, a, b, D, V0, name, smooth=False)
    return law if name == "aging" else _without_rounding(law)


def _without_rounding(law):
    from dataclasses import replace

    tiny = [e for e in law.memory.rates[0].atoms(sp.Float) if 0 < e < 1e-30]
    rate = sp.nsimplify(law.memory.rates[0].xreplace(dict.fromkeys(tiny, sp.S.Zero)))
    return replace(law, memory=replace(law.memory, rates=(rate,)))


# --- Numbers that the closed forms return -----------------------------------------------------------------------------
def _dahl_from_rate(x_end):
    law = laws.dahl(sp.Rational(3, 10), 20)
    rate = sp.lambdify(state(law), 20 * along_path(law, 1).subs(state(law), state(law) / 20), "mpmath")
    with mp.workdps(25):
        return mp.odefun(lambda _, e: rate(e), 0, mp.mpf("-0.3"))(x_end)


NUMBERS = [
    (presliding.dahl_reversal, (0.3, 20.0, 0.02), lambda: _dahl_from_rate(mp.mpf("0.02"))),
    (presliding.dahl_loop, (0.3, 20.0, 0.05), lambda: _loop_of_dahl()),
    (
        presliding.lugre_drift,
        (100.0, 0.2, 0.8),
        lambda: mp.quad(lambda f: (1 / (1 - f) - 1 / (1 + f)) / 100, [0.2, 0.8]),
    ),
    (presliding.iwan_backbone, (1.0, -0.5, 1.0, 0.7), lambda: _iwan(lambda e: min(e, mp.mpf("0.7")))),
    (presliding.iwan_dissipation, (1.0, -0.5, 0.7), lambda: _iwan(lambda e: 4 * e * max(mp.mpf("0.7") - e, 0))),
]


def _loop_of_dahl():
    top = mp.mpf("0.3") * mp.tanh(20 * mp.mpf("0.05") / mp.mpf("0.3"))
    branch = lambda e: mp.mpf("0.3") - (mp.mpf("0.3") + top) * mp.exp(-20 * (e + mp.mpf("0.05")) / mp.mpf("0.3"))  # noqa: E731
    return 2 * mp.quad(branch, [-mp.mpf("0.05"), mp.mpf("0.05")])


def _iwan(of):
    """Return the integral over all sliders, with e = r^2 for the density e^-1/2."""
    edge = mp.sqrt(mp.mpf("0.7"))
    return mp.quad(lambda r: 2 * of(r * r), [0, edge, 1])


def _enter(closed_form, arguments: tuple, exact) -> None:
    name, claim = closed_form.__name__, sp.Float(closed_form(*arguments), 17)
    LEDGER.verified(name, f"number at {arguments}", claim, numbers="12 digits")(
        lambda e: agree(sp.Float(exact(), 25), e)
    )


for _row in NUMBERS:
    _enter(*_row)
