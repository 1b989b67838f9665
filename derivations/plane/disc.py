"""A disc of uniform pressure that slides and spins, on which friction acts against the velocity of every element."""

import math

import mpmath as mp
import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree
from symfric.theory import plane

PART = Ledger("plane", "")

v, p, q, k, r, theta, t, a, x, w = sp.symbols("v p q k r theta t a x w", positive=True)
RATIOS = (0.3, 0.8, 1.5, 4.0)  # of sliding over the speed of the rim


def disc(eps):
    """Return force and torque, over mu N and mu N R, by an integral about the instantaneous centre at the distance eps.

    In polar coordinates there friction is perpendicular to the radius, of the size 1/pi per area; a chord at the angle
    phi from the line to the middle has the length 2 sqrt(1 - eps^2 sin^2) where the centre is outside.
    """
    with mp.workdps(20):
        eps = mp.mpf(str(eps))
        root = lambda phi: mp.sqrt(1 - (eps * mp.sin(phi)) ** 2)  # noqa: E731
        if eps < 1:  # one crossing at r = eps cos + root, weights r cos and r (r - eps cos)
            reach = lambda phi: eps * mp.cos(phi) + root(phi)  # noqa: E731
            force = mp.quad(lambda f: mp.cos(f) * reach(f) ** 2 / 2, [0, mp.pi / 2, mp.pi])
            torque = mp.quad(lambda f: reach(f) ** 3 / 3 - eps * mp.cos(f) * reach(f) ** 2 / 2, [0, mp.pi / 2, mp.pi])
        else:  # sin(phi) = sin(psi)/eps, so that the root is cos(psi)
            angle = lambda psi: mp.asin(mp.sin(psi) / eps)  # noqa: E731
            rate = lambda psi: mp.cos(psi) / (eps * mp.cos(angle(psi)))  # noqa: E731
            centre = lambda psi: eps * mp.cos(angle(psi))  # noqa: E731
            ring = lambda psi, n: ((centre(psi) + mp.cos(psi)) ** n - (centre(psi) - mp.cos(psi)) ** n) / n  # noqa: E731
            force = mp.quad(lambda s: mp.cos(angle(s)) * ring(s, 2) * rate(s), [0, mp.pi / 2])
            torque = mp.quad(lambda s: (ring(s, 3) - centre(s) * ring(s, 2)) * rate(s), [0, mp.pi / 2])
        return [sp.Float(2 / mp.pi * e, 20) for e in (force, torque)]


def of_the_package():
    """Return the package's expressions of force and torque at every ratio, the speed of the rim 1, as floats."""
    sliding, spin = sp.symbols("v omega", real=True)
    force, _, torque = plane.disc_expressions(sliding, 0, spin, 1)
    friction = sp.lambdify((sliding, spin), (-force, -torque), "math", cse=True)
    return [sp.Float(e, 15) for eps in RATIOS for e in friction(eps, 1.0)]


E_OF_EPS, K_OF_EPS = sp.elliptic_e(x**2), sp.elliptic_k(x**2)


@PART.verified(
    "disc",
    "force and torque of a spinning disc, x = v/(R omega) < 1 the modulus",
    4 / (3 * sp.pi * x) * ((x**2 + 1) * E_OF_EPS + (x**2 - 1) * K_OF_EPS),
    4 / (9 * sp.pi) * ((4 - 2 * x**2) * E_OF_EPS + (x**2 - 1) * K_OF_EPS),
    numbers="15 digits at two ratios",
)
def _(*claim):
    found = [(eps, disc(eps)) for eps in RATIOS if eps < 1]
    return [
        agree(f, c.subs(x, sp.Rational(str(eps))).evalf(25), 15)
        for eps, pair in found
        for f, c in zip(pair, claim, strict=True)
    ]


@PART.verified(
    "disc, regular form",
    "force and torque as the package has them, from differences of the arithmetic-geometric mean",
    *(sp.Float(e, 15) for eps in RATIOS for e in plane.spinning_disc_friction(eps, 1.0)),
    *of_the_package(),
    numbers="13 digits at four ratios, numbers and expressions",
)
def _(*claim):
    found = [e for eps in RATIOS for e in disc(eps)]
    return [agree(f, c, 13) for f, c in zip([*found, *found], claim, strict=True)]


@PART.verified(
    "disc, little sliding and little spin",
    "force over v/(R omega) and torque for little sliding; torque times v/(R omega) for little spin",
    sp.Integer(1),
    sp.Rational(2, 3),
    sp.Rational(1, 4),
)
def _(force, torque, spin):
    # little sliding: the friction on an element at (r, phi) turns by x cos(phi)/r; over the disc, per pi
    S = sp.sqrt((x + r * sp.cos(theta)) ** 2 + (r * sp.sin(theta)) ** 2)
    slope = ((x + r * sp.cos(theta)) / S).diff(x).subs(x, 0)
    first = sp.integrate(sp.integrate(sp.simplify(slope) * r, (r, 0, 1)), (theta, 0, 2 * sp.pi)) / sp.pi
    still = sp.integrate(sp.integrate(r * r, (r, 0, 1)), (theta, 0, 2 * sp.pi)) / sp.pi
    # little spin b: the velocity (1 - b y, b x) has the direction (1, b x), and the arm x
    last = sp.integrate(sp.integrate((r * sp.cos(theta)) ** 2 * r, (r, 0, 1)), (theta, 0, 2 * sp.pi)) / sp.pi
    return first - force, still - torque, last - spin


@PART.verified(
    "disc, polar form",
    "rates of ln(rho) and of the angle for v = rho sin(a), R omega = rho cos(a), dt = rho ds; forces F, T/R over m, "
    "inertia k = J/(m R^2)",
    -p * sp.sin(a) - q / k * sp.cos(a),
    -p * sp.cos(a) + q / k * sp.sin(a),
)
def _(fall, turn):
    rho, angle = sp.Function("rho")(t), sp.Function("a")(t)
    rates = sp.solve(
        [(rho * sp.sin(angle)).diff(t) + p, (rho * sp.cos(angle)).diff(t) + q / k], [rho.diff(t), angle.diff(t)]
    )
    found = rates[rho.diff(t)], rates[angle.diff(t)] * rho  # dln(rho)/ds = rho', da/ds = a' rho
    return [sp.simplify(f.subs(angle, a) - c) for f, c in zip(found, (fall, turn), strict=True)]


def disc_stops(speed, spin):
    """Return time and distance of a disc, inertia 1/2, in units of R and mu g, over the ratio and ln(R omega)."""
    from scipy.integrate import solve_ivp
    from scipy.special import ellipe, ellipk

    def rates(_s, y):  # dt = R omega ds
        e2 = y[0] ** 2
        K, E = ellipk(e2), ellipe(e2)
        force = 4 / (3 * math.pi * y[0]) * ((e2 + 1) * E + (e2 - 1) * K)
        torque = 4 / (9 * math.pi) * ((4 - 2 * e2) * E + (e2 - 1) * K)
        rim = math.exp(y[1])
        return [-force + 2 * y[0] * torque, -2 * torque, rim, y[0] * rim**2]

    run = solve_ivp(rates, (0, 60), [speed / spin, math.log(spin), 0, 0], "DOP853", rtol=1e-13, atol=1e-15)
    return [sp.Float(e, 20) for e in run.y[2:, -1]]


def disc_by_integrals(eps):
    """Return force and torque by the elliptic integrals of the ledger's row, eps < 1."""
    K, E = mp.ellipk(eps**2), mp.ellipe(eps**2)
    e2 = eps**2
    return 4 / (3 * mp.pi * eps) * ((e2 + 1) * E + (e2 - 1) * K), 4 / (9 * mp.pi) * ((4 - 2 * e2) * E + (e2 - 1) * K)


_STOP = plane.disc_stop(0.5, 1.0, R=1.0, m=1.0, mu=1.0, g=1.0)


@PART.verified(
    "disc, stop",
    "time and distance from v = 1/2, omega = 1, in units of R and mu g; ratio of v to R omega at the stop",
    *(sp.Float(e, 15) for e in (_STOP.time, _STOP.distance, plane.disc_stop_ratio(0.5))),
    numbers="11 digits, over the ratio with another scaled time",
)
def _(*claim):
    def turning(ratio):
        force, torque = disc_by_integrals(ratio)
        return force / 2 - ratio * torque

    with mp.workdps(25):
        ratio = mp.findroot(turning, (0.5, 0.8), solver="anderson")
    found = [*disc_stops(0.5, 1.0), sp.Float(ratio, 20)]
    return [agree(f, c, 11) for f, c in zip(found, claim, strict=True)]
