"""Bodies with planar contacts, integrated by SciPy alone: a second method for the tests, which shares nothing with the package.

``M(q) u' = force(t, q, u) + sum R^T f``, ``q' = u``. The slip of a contact is ``s = R u - belt(t)`` (two rows); its friction
is ``f = -mu(|s|) N s/|s|`` while it slips, and any f with ``|f| <= mu_s N`` at rest.

What it offers:

`Planar`, `Problem`
    One contact; bodies with contacts, start and horizon, all as NumPy arrays and plain functions.
`regularised(problem, eps)`
    The same with a friction that rises over the speed eps instead of a jump, by Radau. Its error falls with eps: the trend.
`Simulator(problem).run()` -> `Motion`
    From event to event. Fast sliding is integrated in Cartesian velocities by DOP853. Next to rest the contact has polar
    velocities, ``ln v`` and the angle, and the time is scaled, ``dt = v d tau``: every rate is then finite, v falls
    exponentially with tau before a stop, and a fast turn is no event. Once v is below `REST`, forces decide: all sets of
    sticking contacts are tried, largest first; those that stick need forces inside their discs (where these are redundant,
    the least use of the discs, a second-order cone programme), those that start slide along their acceleration. Releases
    start from there by Radau, because the angle is stiff while v is small.
`Motion.final`, `.events`, `.at(t)`
    State ``[q; u]`` at the end, events ``(t, contact, "stick" | "slip")``, dense output.
`incline(...)`
    A block on a moving incline as a problem; `polar_incline` integrates the one at rest in 30 digits.

Limits: rows are constant, a contact that presses with no load is not treated, and two contacts that come to rest at the same
instant are resolved one after the other.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field

import mpmath as mp
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize, root

REST = 1e-15  # speed, over that of the problem, from which on forces decide
SLOW, FAST = 0.02, 0.05  # speeds at which polar velocities begin and end
START = 1e-5  # time, over that of the problem, that a release is carried on by its Taylor polynomial
INSIDE = 1 + 1e-12  # use of a disc that still sticks


@dataclass(frozen=True)
class Planar:
    """A contact: rows (2, n), load N (a number or ``N(t, q, u)``), mu_s, mu (a number or ``mu(v)``), belt(t), its rate."""

    rows: np.ndarray
    load: float | Callable
    mu_s: float
    mu: float | Callable
    belt: Callable = lambda t: np.zeros(2)
    belt_rate: Callable = lambda t: np.zeros(2)

    def kinetic(self, v):
        return self.mu(v) if callable(self.mu) else self.mu

    def normal(self, t, q, u):
        return self.load(t, q, u) if callable(self.load) else self.load


@dataclass(frozen=True)
class Problem:
    """Bodies with planar contacts; `speed` and `time` are their scales."""

    mass: Callable  # q -> (n, n)
    force: Callable  # t, q, u -> (n,)
    contacts: tuple[Planar, ...]
    start: np.ndarray  # [q; u]
    horizon: float
    speed: float = 1.0
    time: float = 1.0


@dataclass
class Motion:
    """What happened."""

    final: np.ndarray = None
    events: list = field(default_factory=list)
    pieces: list = field(default_factory=list)  # (t0, t1, state at a time)

    def at(self, t):
        """Return the state at a time."""
        for t0, t1, state in self.pieces:
            if t0 <= t <= t1:
                return state(t)
        raise ValueError(f"no motion at {t}")

    def kinds(self):
        return [(k, kind) for _, k, kind in self.events]


def regularised(problem, eps, tolerance=1e-10):
    """Return the state at the horizon with friction that rises to its limit over the speed eps, then falls to mu."""
    n = len(problem.start) // 2

    def size(c, v):
        rest = c.kinetic(0.0)
        if c.mu_s == rest:
            return c.kinetic(v) / math.hypot(v, eps)
        if v < eps:
            return c.mu_s / eps
        return (c.kinetic(v - eps) + (c.mu_s - rest) * max(0.0, 2 - v / eps)) / v

    def rates(t, y):
        q, u = y[:n], y[n:]
        f = problem.force(t, q, u)
        for c in problem.contacts:
            s = c.rows @ u - c.belt(t)
            f = f - c.rows.T @ s * size(c, math.hypot(*s)) * c.normal(t, q, u)
        return np.concatenate([u, np.linalg.solve(problem.mass(q), f)])

    run = solve_ivp(rates, (0, problem.horizon), problem.start, "Radau", rtol=tolerance, atol=tolerance * eps)
    assert run.success, run.message
    return run.y[:, -1]


def unit(angle):
    return np.array([math.cos(angle), math.sin(angle)])


def least_use(G, c, bounds):
    """Return forces f with ``G f = c``, pairs of which use as little as possible of their discs, and that use.

    The largest ``|f_k|/bound_k``: determined by the equations where G has full rank, else by a second-order cone programme.
    """
    forces = np.linalg.lstsq(G, c, rcond=1e-10)[0]
    rank = np.linalg.matrix_rank(G, tol=1e-10 * np.abs(G).max(initial=1e-300))

    def use(f):
        return np.hypot(*f.reshape(-1, 2).T) / bounds

    scale = use(forces).max(initial=0.0)
    if rank < len(c) and scale > 0:
        forces = forces / scale
        null = np.linalg.svd(G)[2][rank:].T

        def inside(x):
            return x[-1] ** 2 - use(forces + null @ x[:-1]) ** 2

        x0 = np.append(np.zeros(null.shape[1]), use(forces).max())
        found = minimize(
            lambda x: x[-1], x0, method="SLSQP", constraints={"type": "ineq", "fun": inside}, options={"ftol": 1e-14}
        )
        forces = scale * (forces + null @ found.x[:-1])
    return forces, float(use(forces).max(initial=0.0))


class Simulator:
    """One motion from event to event."""

    def __init__(self, problem, tolerance=1e-12, most_events=400):
        self.p, self.tolerance, self.most = problem, tolerance, most_events
        self.n = len(problem.start) // 2
        self.contacts = problem.contacts
        self.all = range(len(self.contacts))

    # -- forces

    def slips(self, t, u):
        return [c.rows @ u - c.belt(t) for c in self.contacts]

    def accelerations(self, t, q, u, sticking, directions):
        """Return u', and the forces of the contacts that stick; `directions` are unit vectors of the others, with speeds."""
        inverse = np.linalg.inv(self.p.mass(q))
        f = np.asarray(self.p.force(t, q, u), dtype=float)
        for k, (e, v) in directions.items():
            c = self.contacts[k]
            f = f - c.rows.T @ e * c.kinetic(v) * c.normal(t, q, u)
        if not sticking:
            return inverse @ f, np.zeros(0), 0.0
        R = np.vstack([self.contacts[k].rows for k in sticking])
        moved = np.concatenate([self.contacts[k].belt_rate(t) for k in sticking])
        bounds = np.array([self.contacts[k].mu_s * self.contacts[k].normal(t, q, u) for k in sticking])
        forces, use = least_use(R @ inverse @ R.T, moved - R @ inverse @ f, bounds)
        return inverse @ (f + R.T @ forces), forces, use

    def sliding(self, t, u, sticking):
        """Return direction and speed of every contact that does not stick."""
        found = {}
        for k, s in enumerate(self.slips(t, u)):
            if k not in sticking:
                v = math.hypot(*s)
                found[k] = (s / v, v)
        return found

    def release(self, t, q, u, resting, kept_out):
        """Return which resting contacts stick, and the directions in which the others start, from the forces alone."""
        moving = self.sliding(t, u, resting)
        able = [k for k in resting if k not in kept_out]
        for size in range(len(able), -1, -1):
            for sticking in itertools.combinations(able, size):
                starting = [k for k in resting if k not in sticking]
                for angles in self.starts(t, q, u, sticking, moving, starting):
                    directions = moving | {k: (unit(a), 0.0) for k, a in zip(starting, angles, strict=True)}
                    _, _, use = self.accelerations(t, q, u, sticking, directions)
                    if use <= INSIDE:
                        return list(sticking), {k: unit(a) for k, a in zip(starting, angles, strict=True)}
        raise ArithmeticError(f"no consistent forces at t = {t}")

    def starts(self, t, q, u, sticking, moving, starting):
        """Yield the angles in which contacts start along their accelerations."""
        if not starting:
            yield ()
            return

        def slip_rates(angles):
            directions = moving | {k: (unit(a), 0.0) for k, a in zip(starting, angles, strict=True)}
            du = self.accelerations(t, q, u, sticking, directions)[0]
            return [self.contacts[k].rows @ du - self.contacts[k].belt_rate(t) for k in starting]

        def across(angles):
            return [unit(a)[0] * r[1] - unit(a)[1] * r[0] for a, r in zip(angles, slip_rates(angles), strict=True)]

        def along(angles):
            return min(float(unit(a) @ r) for a, r in zip(angles, slip_rates(angles), strict=True))

        grid = np.linspace(-math.pi, math.pi, 25 if len(starting) == 1 else 9)
        if len(starting) == 1:
            values = [across([a])[0] for a in grid]
            for k in range(len(grid) - 1):
                if values[k] * values[k + 1] <= 0 and values[k] != values[k + 1]:
                    a = brentq(lambda a: across([a])[0], grid[k], grid[k + 1], xtol=1e-15, rtol=1e-15)
                    if along([a]) > 0:
                        yield (a,)
            return
        for guess in itertools.product(grid[:-1], repeat=len(starting)):
            found = root(across, guess, tol=1e-13)
            if found.success and along(found.x) > 0:
                yield tuple(found.x)
                return

    # -- pieces of the motion

    def run(self):
        p, n = self.p, self.n
        self.motion = Motion()
        t, y = 0.0, np.array(p.start, dtype=float)
        resting = [k for k, s in enumerate(self.slips(t, y[n:])) if math.hypot(*s) < REST * p.speed]
        sticking, starting = self.release(t, y[:n], y[n:], resting, ())
        self.motion.events += [(t, k, "stick") for k in sticking]
        for _ in range(self.most):
            if starting:
                t, y = self.leave(t, y, sticking, starting)
            t, y, left, stopped = self.advance(t, y, sticking, bool(starting))
            starting = {}
            if t >= p.horizon:
                self.motion.final = y
                return self.motion
            if left is not None:
                sticking, starting = self.released(t, y, sticking, left)
            elif stopped is not None:
                y = self.at_rest(t, y, [*sticking, stopped])
                self.motion.events.append((t, stopped, "stick"))
                before = {*sticking, stopped}
                sticking, starting = self.release(t, y[:n], y[n:], sorted(before), ())
                self.motion.events += [(t, k, "slip") for k in before - {*sticking}]
        raise ArithmeticError("too many events")

    def at_rest(self, t, y, contacts):
        """Return the state with no slip of some contacts, changed as an impulse would."""
        n = self.n
        R = np.vstack([self.contacts[k].rows for k in contacts])
        slip = np.concatenate([self.slips(t, y[n:])[k] for k in contacts])
        inverse = np.linalg.inv(self.p.mass(y[:n]))
        return np.concatenate([y[:n], y[n:] - inverse @ R.T @ np.linalg.lstsq(R @ inverse @ R.T, slip, rcond=1e-10)[0]])

    def released(self, t, y, sticking, left):
        """Return the modes behind the release of a contact, decided a little later, where it has to slide."""
        n, h = self.n, START * self.p.time
        du = self.accelerations(t, y[:n], y[n:], sticking, self.sliding(t, y[n:], sticking))[0]
        later = y[:n] + h * y[n:] + h**2 / 2 * du, y[n:] + h * du
        kept, starting = self.release(t + h, *later, sticking, (left,))
        self.motion.events += [(t, k, "slip") for k in starting]
        return kept, starting

    def leave(self, t, y, sticking, starting):
        """Return the state a little after contacts have started, by the trapezoidal rule."""
        n, h = self.n, START * self.p.time
        resting = [*sticking, *starting]
        directions = self.sliding(t, y[n:], resting) | {k: (e, 0.0) for k, e in starting.items()}
        first = self.accelerations(t, y[:n], y[n:], sticking, directions)[0]
        for _ in range(3):
            u = y[n:] + h * first
            directions = self.sliding(t + h, u, resting) | {k: (e, 0.0) for k, e in starting.items()}
            second = self.accelerations(t + h, y[:n] + h * y[n:] + h**2 / 2 * first, u, sticking, directions)[0]
        end = np.concatenate([y[:n] + h * y[n:] + h**2 / 6 * (2 * first + second), y[n:] + h / 2 * (first + second)])
        self.motion.pieces.append((t, t + h, lambda at, a=y, b=end, t=t, h=h: a + (at - t) / h * (b - a)))
        return t + h, end

    def advance(self, t, y, sticking, started):
        """Integrate until a contact stops or leaves; return time, state, who left and who stopped."""
        p, n = self.p, self.n
        while True:
            sliding = {k: v for k, (_, v) in self.sliding(t, y[n:], sticking).items()}
            slow = min(sliding, key=sliding.get, default=None)
            if slow is not None and sliding[slow] < SLOW * p.speed:
                t, y, end = self.slowly(t, y, sticking, slow, started)
            else:
                t, y, end = self.swiftly(t, y, sticking)
            started = False
            if end == "stopped":
                return t, y, None, slow
            if end is not None and end != "again":
                return t, y, end, None
            if t >= p.horizon:
                return t, y, None, None

    def bound(self, k, sticking):
        """Return the use of the disc of a sticking contact less one, as a function of t, q, u and directions."""
        place = sticking.index(k)

        def excess(t, q, u, directions):
            c = self.contacts[k]
            forces = self.accelerations(t, q, u, sticking, directions)[1][2 * place : 2 * place + 2]
            return math.hypot(*forces) / (c.mu_s * c.normal(t, q, u)) - 1

        return excess

    def swiftly(self, t, y, sticking):
        p, n = self.p, self.n

        def rates(t, y):
            return np.concatenate(
                [y[n:], self.accelerations(t, y[:n], y[n:], sticking, self.sliding(t, y[n:], sticking))[0]]
            )

        def slow(t, y):
            return min((v for _, v in self.sliding(t, y[n:], sticking).values()), default=1e300) - 0.9 * SLOW * p.speed

        def leaving(k):
            excess = self.bound(k, sticking)
            return lambda t, y: excess(t, y[:n], y[n:], self.sliding(t, y[n:], sticking))

        return self.integrated(rates, t, y, [(slow, -1, "again"), *((leaving(k), 1, k) for k in sticking)], "DOP853")

    def slowly(self, t, y, sticking, k, started):
        """Integrate ``[ln v, angle, q, w, t]`` over tau; w are the velocities beside the slip of contact k."""
        p, n = self.p, self.n
        R = self.contacts[k].rows
        others = np.linalg.svd(R)[2][2:]
        back = np.linalg.inv(np.vstack([R, others]))
        c = self.contacts[k]

        def state(z):
            t, e = z[-1], unit(z[1])
            u = back @ np.concatenate([math.exp(z[0]) * e + c.belt(t), z[2 + n : -1]])
            return t, z[2 : 2 + n], u, e

        def directions(z):
            t, _, u, e = state(z)
            return self.sliding(t, u, [*sticking, k]) | {k: (e, math.exp(z[0]))}

        def rates(_, z):
            t, q, u, e = state(z)
            du = self.accelerations(t, q, u, sticking, directions(z))[0]
            a = R @ du - c.belt_rate(t)
            v = math.exp(z[0])
            return np.concatenate([[e @ a, e[0] * a[1] - e[1] * a[0]], v * u, v * (others @ du), [v]])

        def leaving(j):
            excess = self.bound(j, sticking)
            return lambda _, z: excess(*state(z)[:3], directions(z))

        s = R @ y[n:] - c.belt(t)
        z = np.concatenate([[math.log(math.hypot(*s)), math.atan2(s[1], s[0])], y[:n], others @ y[n:], [t]])
        nearest = [self.contacts[j] for j in self.all if j != k and j not in sticking]
        stops = [
            (lambda _, z: z[0] - math.log(REST * p.speed), -1, "stopped"),
            (lambda _, z: z[0] - math.log(FAST * p.speed), 1, "again"),
            *(
                (
                    lambda _, z, o=o: math.hypot(*(o.rows @ state(z)[2] - o.belt(z[-1]))) - 0.1 * math.exp(z[0]),
                    -1,
                    "again",
                )
                for o in nearest
            ),
            *((leaving(j), 1, j) for j in sticking),
            (lambda _, z: z[-1] - p.horizon, 1, "again"),
        ]
        method = "Radau" if started else "DOP853"
        return self.integrated(rates, 0.0, z, stops, method, lambda z: (state(z)[0], np.concatenate(state(z)[1:3])))

    def integrated(self, rates, x, z, stops, method, read=None):
        """Integrate to the first of some events, or the horizon; return time, state and the event's word."""
        end = self.p.horizon if read is None else x + 1e12
        functions = []
        for g, direction, _ in stops:
            f = lambda x, z, g=g: g(x, z)  # noqa: E731
            f.terminal, f.direction = True, direction
            functions.append(f)
        tight = self.tolerance
        run = solve_ivp(rates, (x, end), z, method, events=functions, dense_output=True, rtol=tight, atol=tight * 1e-2)
        assert run.success, run.message
        hit = next((i for i, found in enumerate(run.t_events) if found.size), None)
        word = None if hit is None else stops[hit][2]
        if read is None:
            t0, t1 = x, run.t[-1]
            self.motion.pieces.append((t0, t1, run.sol))
            return t1, run.y[:, -1], word
        times = run.y[-1]

        def state(t):
            at = brentq(lambda s: run.sol(s)[-1] - t, run.t[0], run.t[-1]) if times[0] < t < times[-1] else None
            return read(run.y[:, 0] if t <= times[0] else run.y[:, -1] if at is None else run.sol(at))[1]

        self.motion.pieces.append((times[0], times[-1], state))
        return (*read(run.y[:, -1]), word)


# -- a block on an incline


def incline(slope, mu_s, mu, velocity, *, horizon, g=9.81, shake=(0.0, 0.0), frequency=1.0):
    """Return a block on an incline that moves with ``shake cos(frequency t)`` in its plane; velocities down and across."""
    pull, weight = g * math.sin(slope), g * math.cos(slope)
    a = np.array(shake, dtype=float)
    contact = Planar(
        np.eye(2),
        weight,
        mu_s,
        mu,
        lambda t: a * math.cos(frequency * t),
        lambda t: -a * frequency * math.sin(frequency * t),
    )
    start = np.concatenate([[0.0, 0.0], velocity])
    scale = max(np.hypot(*velocity), np.hypot(*a), 1e-3)
    return Problem(lambda q: np.eye(2), lambda t, q, u: np.array([pull, 0.0]), (contact,), start, horizon, scale)


def polar_incline(slope, mu, speed, direction, g="9.81", digits=30):
    """Return time, way down and way across until a block on an incline at rest stops, by a Taylor method in many digits.

    ``dt = v d tau``: ``(ln v)' = p cos(theta) - d``, ``theta' = -p sin(theta)`` with p, d the pull and the friction, until
    v has fallen by two thirds of the digits, of which the results have that many.
    """
    with mp.workdps(digits):
        slope, mu, g = (mp.mpf(x) for x in (slope, mu, g))
        p, d = g * mp.sin(slope), mu * g * mp.cos(slope)

        def rates(_, z):
            v = mp.exp(z[0])
            return [p * mp.cos(z[1]) - d, -p * mp.sin(z[1]), v, v**2 * mp.cos(z[1]), v**2 * mp.sin(z[1])]

        run = mp.odefun(rates, 0, [mp.log(mp.mpf(speed)), mp.mpf(direction), 0, 0, 0])
        end = run((mp.log(mp.mpf(10)) * digits * 2 / 3) / (d - p))
        return end[2:]
