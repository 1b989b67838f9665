"""Friction and damping from a decay; beyond the source, which searches mu_m and takes zeta from another experiment."""

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree
from derivations.younes_ashour.system import A, g, mu_m, omega, r, v_c, zeta
from symfric.theory import decay_record

PART = Ledger("younes_ashour", "friction and damping from a decay")
B = sp.Symbol("B", positive=True)  # size of the next turning point
F = sp.Function("F")  # mean braking, of `transient.mean_friction`
MU, ZETA = 0.19, 0.009  # figure 8's rod, 5.3 Hz, from 10 mm


@PART.verified(
    "decay record: half cycle",
    "A - B over a half cycle from A to -B as a cosine about its middle, with a = (A + B)/2",
    sp.pi * zeta * (A + B) / 2 + 2 * mu_m * r * g / omega**2 * F((A + B) * omega / (2 * v_c)),
)
def _(claim):
    p = sp.Symbol("p", positive=True)
    middle, size = (A - B) / 2, (A + B) / 2  # from A to -B
    x = middle + size * sp.cos(p)
    speed = omega * size * sp.sin(p)  # |x'|, at the rate p' = omega
    viscous = sp.integrate(2 * zeta * omega * speed**2, (p, 0, sp.pi)) / omega
    # int_0^pi sin p e^{-a sin p} dp = 2 F(a), by which F is defined
    contact = mu_m * r * g * size * 2 * F(size * omega / v_c)
    lost = omega**2 / 2 * (x.subs(p, 0) ** 2 - x.subs(p, sp.pi) ** 2)
    return sp.expand((lost - viscous - contact) / (omega**2 * size) - (A - B - claim))


@PART.verified(
    "decay record: balance",
    "power that the energy x'^2/2 + omega^2 x^2/2 loses, by (2) and (3)",
    2 * zeta * omega * v_c**2 + mu_m * r * g * v_c * sp.exp(-1),
    note="at |x'| = v_c; the integrals of the record have it at every speed",
)
def _(claim):
    x, u = sp.symbols("x u", positive=True)
    acceleration = -2 * zeta * omega * u - omega**2 * x - mu_m * r * g * sp.exp(-u / v_c)
    return sp.simplify(-(u * acceleration + omega**2 * x * u).subs(u, v_c) - claim)


def _motion():
    """Return times, displacements, velocities and turning points of figure 8's rod, by SciPy."""
    import numpy as np
    from scipy.integrate import solve_ivp

    w = 2 * np.pi * 5.3
    t0, x0, sign, rows, turns = 0.0, 0.01, -1.0, [], [0.01]
    while w**2 * abs(x0) > MU * 9.81:

        def field(_t, y, s=sign):
            return y[1], -2 * ZETA * w * y[1] - w**2 * y[0] - s * MU * 9.81 * np.exp(-abs(y[1]))

        def turn(_t, y):
            return y[1]

        turn.terminal, turn.direction = True, -sign
        first = (x0, sign * 1e-14)
        run = solve_ivp(field, (t0, t0 + 1), first, "DOP853", rtol=1e-12, atol=1e-15, events=turn, dense_output=True)
        t = np.linspace(t0, run.t[-1], 1001)
        rows.append((t, *run.sol(t)))
        t0, x0, sign = run.t[-1], run.y[0, -1], -sign
        turns.append(abs(x0))
    parts = [np.array(row)[:, (0 if k == 0 else 1) :] for k, row in enumerate(rows)]
    return np.concatenate(parts, axis=1), turns


@PART.verified(
    "decay record: numbers",
    "mu_m and zeta of .19 and .009, 5.3 Hz, 10 mm: from the turning points, from the motion; decay time",
    0.19,
    0.009,
    0.19,
    0.009,
    sp.Float("0.2830567"),
    numbers="5, 4, 6, 6 and 7 digits",
)
def _(*claim):
    (t, x, u), turns = _motion()
    points = decay_record.from_turning_points(turns, f_n=5.3)
    motion = decay_record.from_motion(t, x, u)
    found = (points.mu_m, points.zeta, motion.mu_m, motion.zeta, t[-1])
    return [agree(sp.Float(f), c, digits=n) for f, c, n in zip(found, claim, (5, 4, 6, 6, 6), strict=True)]
