"""Bodies with contacts that open, integrated from event to event by SciPy: a second method for the tests.

It shares nothing with the package: equations by `sympy.lambdify`, modes by enumeration, impacts by `impact_laws`.
"""

import itertools
from dataclasses import dataclass, field

import numpy as np
import sympy as sp
from scipy.integrate import DOP853
from scipy.optimize import brentq, linprog, minimize_scalar

from tests.impacts.impact_laws import NoSolution, NotUnique, Touching, several, single

T = sp.Symbol("t", real=True)
OPEN, STICKS = 2, 0  # modes; -1 and 1 slip; a closed contact without friction is 0
NEAR = 1e-13  # gap up to which contacts strike together
STILL = 1e-10  # rate, relative to the velocities, that counts as zero
REST = 1e-6  # rate behind an impact from which bounces are left out, which costs its square
ROCKS = 1e-6  # the same, relative to the velocities, of contacts that strike in turns
LOOK = 1e-4  # time after which ties between modes are decided
FINE = np.linspace(0.0, 1.0, 9)


@dataclass(frozen=True)
class Touch:
    """A contact: gap (None under a given load), slip (None without friction), restitution, coefficients."""

    name: str
    gap: sp.Expr | None
    slip: sp.Expr | None = None
    e: sp.Expr = sp.S.Zero
    mu: sp.Expr = sp.S.Zero
    mu_s: sp.Expr | None = None
    load: sp.Expr = sp.S.Zero

    @property
    def sticks(self):
        return self.mu if self.mu_s is None else self.mu_s


@dataclass(frozen=True)
class Bodies:
    """``mass(q) u' = force(q, u, t) + contact forces``, with ``q' = u``."""

    q: list[sp.Symbol]
    u: list[sp.Symbol]
    mass: sp.Matrix
    force: sp.Matrix
    touches: list[Touch]
    parameters: list[sp.Symbol]


class Equations:
    """The equations as functions of ``(t, y, values)``."""

    def __init__(self, bodies: Bodies):
        self.bodies = bodies
        self.n, self.touches = len(bodies.q), bodies.touches
        q, u = sp.Matrix(bodies.q), sp.Matrix(bodies.u)
        gaps = [c.gap if c.gap is not None else sp.S.Zero for c in self.touches]
        rates = [(sp.Matrix([g]).jacobian(q) * u)[0] + g.diff(T) for g in gaps]
        slips = [c.slip if c.slip is not None else sp.S.Zero for c in self.touches]
        self.frictional = [c.slip is not None for c in self.touches]
        self.unilateral = [c.gap is not None for c in self.touches]
        everything = [sp.Matrix(bodies.mass), sp.Matrix(bodies.force)]
        for rows in (rates, slips):
            J = sp.Matrix([[r.diff(v) for v in bodies.u] for r in rows])
            drift = sp.Matrix([(sp.Matrix([r]).jacobian(q) * u)[0] + r.diff(T) for r in rows])
            everything += [J, drift]
        everything += [sp.Matrix([c.load for c in self.touches])]
        self.shapes = [m.shape for m in everything]
        flat = [e for m in everything for e in m]
        arguments = [T, *bodies.q, *bodies.u, *bodies.parameters]
        self._core = sp.lambdify(arguments, flat, "math", cse=True)
        self._watched = sp.lambdify(arguments, [*gaps, *rates, *slips], "math", cse=True)
        coefficients = [*(c.e for c in self.touches), *(c.mu for c in self.touches), *(c.sticks for c in self.touches)]
        self._coefficients = sp.lambdify(bodies.parameters, coefficients, "math")

    def core(self, t, y, values):
        """Return M, h, J_n, c_n, J_t, c_t, loads."""
        flat, parts, at = self._core(t, *y, *values), [], 0
        for shape in self.shapes:
            size = shape[0] * shape[1]
            part = np.array(flat[at : at + size], dtype=float)
            parts.append(part if shape[1] == 1 else part.reshape(shape))
            at += size
        if self.n == 1:
            parts[0], parts[2], parts[4] = parts[0].reshape(1, 1), parts[2].reshape(-1, 1), parts[4].reshape(-1, 1)
        return parts

    def watched(self, t, y, values):
        """Return gaps, their rates, slips."""
        return np.array(self._watched(t, *y, *values), dtype=float).reshape(3, -1)


@dataclass
class Motion:
    """What happened: states at the asked times, events (time, contact, mode before, mode behind), dense output."""

    final: np.ndarray = None
    events: list = field(default_factory=list)
    impacts: list = field(default_factory=list)
    reason: str = ""


class Simulator:
    """One motion; `values` in the order of the parameters."""

    def __init__(self, equations: Equations, values, tolerance=1e-11, most_events=1500, near=NEAR):
        self.e, self.values, self.tolerance, self.most = equations, tuple(map(float, values)), tolerance, most_events
        self.near = near
        self.n = equations.n
        self.n_c = len(equations.touches)
        self.restitution, self.mu, self.mu_s = np.array(equations._coefficients(*self.values), dtype=float).reshape(
            3, -1
        )

    # -- forces

    def solved(self, t, y, mode):
        """Return accelerations, N, Q, and null vectors of the forces, of modes of every contact."""
        e = self.e
        M, h, Jn, cn, Jt, ct, load = e.core(t, y, self.values)
        n = self.n
        pressed = [k for k in range(self.n_c) if e.unilateral[k] and mode[k] != OPEN]
        stuck = [k for k in range(self.n_c) if e.frictional[k] and mode[k] == STICKS]
        g = h.copy()
        columns, rows, right = [], [], []
        for k in pressed:
            slides = -mode[k] * self.mu[k] if e.frictional[k] else 0.0
            columns.append(Jn[k] + slides * Jt[k])
            rows.append(Jn[k])
            right.append(-cn[k])
        for k in range(self.n_c):
            if not e.unilateral[k] and mode[k] in (-1, 1):
                g -= mode[k] * self.mu[k] * load[k] * Jt[k]
        for k in stuck:
            columns.append(Jt[k])
            rows.append(Jt[k])
            right.append(-ct[k])
        m = len(rows)
        A = np.zeros((n + m, n + m))
        A[:n, :n] = M
        if m:
            A[:n, n:] = -np.array(columns).T
            A[n:, :n] = np.array(rows)
        null = np.zeros((m, 0))
        if m:
            forces = np.linalg.solve(M, np.array(columns).T)
            W = np.array(rows) @ forces
            left, s, right_vectors = np.linalg.svd(W)
            keep = s > 1e-10 * max(s[0], 1e-300)
            q = np.array(right) - np.array(rows) @ np.linalg.solve(M, g)
            inverse = right_vectors[keep].T @ np.diag(1 / s[keep]) @ left[:, keep].T
            found = inverse @ q
            if np.max(np.abs(W @ found - q)) > 1e-8 * (np.max(np.abs(q)) + 1e-300) + 1e-12:
                found = np.full(m, np.nan)
            null = right_vectors[~keep].T
            null = null[:, [bool(np.max(np.abs(forces @ v)) < 1e-8 * np.max(np.abs(forces))) for v in null.T]]
            a = np.linalg.solve(M, g) + forces @ found
        else:
            found, a = np.zeros(0), np.linalg.solve(M, g)
        N, Q = load.copy() * [not u for u in e.unilateral], np.zeros(self.n_c)
        for i, k in enumerate(pressed):
            N[k] = found[i]
        for i, k in enumerate(stuck):
            Q[k] = found[len(pressed) + i]
        gaps = Jn @ a + cn
        slips = Jt @ a + ct
        return a, N, Q, gaps, slips, (null, pressed, stuck)

    def rate(self, t, y, mode):
        return np.concatenate([y[self.n :], self.solved(t, y, mode)[0]])

    def held(self, t, y, mode):
        """Return what is left of every bound of the forces of closed contacts; of all at once where they may be shared."""
        _, N, Q, _, _, (null, pressed, stuck) = self.solved(t, y, mode)
        if null.shape[1]:
            return [self._shared(N, Q, null, pressed, stuck)]
        return [*(N[k] for k in pressed), *(self.mu_s[k] * N[k] - abs(Q[k]) for k in stuck)]

    def _shared(self, N, Q, null, pressed, stuck):
        """Return the largest possible least slack over all distributions of the forces."""
        m = null.shape[1]
        row = {("N", k): i for i, k in enumerate(pressed)} | {("Q", k): len(pressed) + i for i, k in enumerate(stuck)}
        zero = np.zeros(m)
        A, b = [], []
        for k in pressed:
            A.append([*-null[row["N", k]], 1.0])
            b.append(N[k])
        for k in stuck:
            dN = null[row["N", k]] if ("N", k) in row else zero
            for sign in (1, -1):
                A.append([*(sign * null[row["Q", k]] - self.mu_s[k] * dN), 1.0])
                b.append(self.mu_s[k] * N[k] - sign * Q[k])
        if not np.all(np.isfinite(b)):
            return -np.inf
        solution = linprog([*zero, -1.0], A_ub=A, b_ub=b, bounds=[(None, None)] * m + [(None, 1e6)])
        return -solution.fun if solution.status == 0 else -np.inf

    # -- modes

    def select(self, t, y, near, slow):
        """Return the modes of contacts, those in `near` being in touch without rate, those in `slow` without slip."""
        e = self.e
        slips = e.watched(t, y, self.values)[2]
        options = []
        for k in range(self.n_c):
            closed = [0]
            if e.frictional[k]:
                closed = [0, 1, -1] if k in slow else [int(np.sign(slips[k]))]
            options.append(([*closed, OPEN] if k in near else [OPEN]) if e.unilateral[k] else closed)
        best, margins = None, []
        for mode in itertools.product(*options):
            margin, ties = self._admissible(t, y, mode, near, slow)
            if margin is None:
                continue
            held = sum(m == STICKS for m in mode)
            margins.append((not ties, held if ties else 0, margin, mode))
        if not margins:
            raise NoSolution(f"no mode at t = {t:.15g}")
        clear = [m for m in margins if m[0]]
        if len(clear) == 1 and not np.any(self.mu_s > self.mu):
            return clear[0][3]
        motions = {}
        for _, held, _, mode in margins:
            after = self._ahead(t, y, mode, near, slow)
            motions[mode] = (after, held)
        allowed = [m for m, (after, _) in motions.items() if after is not None]
        if not allowed:
            raise NoSolution(f"no mode lasts at t = {t:.15g}: {[m[3] for m in margins]}")
        best = max(allowed, key=lambda m: sum(i == STICKS for i in m))
        if np.any(self.mu_s > self.mu):
            return best  # what static friction can hold stays
        a = self.solved(t, y, best)[0]
        for other in allowed:
            b = self.solved(t, y, other)[0]
            if np.max(np.abs(a - b)) > 1e-6 * (np.max(np.abs(a)) + np.max(np.abs(b)) + 1e-3):
                raise NotUnique(f"modes {best} and {other} at t = {t:.15g}")
        return best

    def _admissible(self, t, y, mode, near, slow):
        """Return the least margin, None if it is negative, and whether it is a tie."""
        a, N, _, gaps, slips, _ = self.solved(t, y, mode)
        if not np.all(np.isfinite(a)):
            return None, False
        free = self.solved(t, y, [OPEN if u else 1 for u in self.e.unilateral])[0]
        M, h, *_ = self.e.core(t, y, self.values)
        scale = np.max(np.abs(a)) + np.max(np.abs(free)) + np.max(np.abs(np.linalg.solve(M, h))) + 1e-12
        margin = np.inf
        for k in range(self.n_c):
            if mode[k] == OPEN:
                margin = min(margin, gaps[k] / scale if k in near else np.inf)
            elif mode[k] and k in slow:
                margin = min(margin, mode[k] * slips[k] / scale)
        largest = np.max(np.abs(self.e.core(t, y, self.values)[1])) + np.max(np.abs(N), initial=0.0) + 1e-12
        margin = min([margin, *(s / largest for s in self.held(t, y, mode))])
        return (None, False) if margin < -1e-9 else (margin, margin < 1e-9)

    def _ahead(self, t, y, mode, near, slow):
        """Return the state a moment later, None if the mode does not last till then."""
        h, z = LOOK / 4, y.copy()
        for i in range(4):
            s = t + i * h
            k1 = self.rate(s, z, mode)
            k2 = self.rate(s + h / 2, z + h / 2 * k1, mode)
            k3 = self.rate(s + h / 2, z + h / 2 * k2, mode)
            z = z + h / 6 * (k1 + 2 * k2 + 2 * k3 + self.rate(s + h, z + h * k3, mode))
        gaps, _, slips = self.e.watched(t + LOOK, z, self.values)
        big = np.max(np.abs(self.e.core(t, y, self.values)[1])) + 1.0
        if any(s < -1e-9 * big for s in self.held(t + LOOK, z, mode)):
            return None
        for k in range(self.n_c):
            if mode[k] == OPEN and k in near and gaps[k] < -1e-15:
                return None
            if mode[k] in (-1, 1) and k in slow and self.e.frictional[k] and mode[k] * slips[k] < -1e-13:
                return None
        return z

    # -- impacts

    def strike(self, t, y, hit, closed):
        """Return the state behind the impact and the contacts that touch there without rate."""
        e, n = self.e, self.n
        gaps = e.watched(t, y, self.values)[0]
        touch = [k for k in range(self.n_c) if e.unilateral[k] and (k in closed or k in hit or gaps[k] < self.near)]
        if touch:
            y = self.projected(t, y, [0 if k in touch else OPEN for k in range(self.n_c)], moved=True)
        _, rates, slips = e.watched(t, y, self.values)
        M, _, Jn, _, Jt, _, _ = e.core(t, y, self.values)
        speed = np.max(np.abs(y[n:])) + 1e-4
        small = lambda k: abs(rates[k]) <= STILL * speed  # noqa: E731
        if not any(rates[k] < -STILL * speed and k not in closed for k in touch):
            return y, {k for k in touch if k in closed or small(k)}, False
        lines = [k for k in touch if e.frictional[k]]
        rows = np.array([*(Jt[k] for k in lines), *(Jn[k] for k in touch)])
        back = np.linalg.solve(M, rows.T)
        sliding = len(touch) > 1 and np.abs(slips) > 1e-11 * speed
        bounds = np.where(sliding, self.mu, self.mu_s)
        c = Touching(
            rows @ back, [touch.index(k) for k in lines], self.mu[touch], bounds[touch], self.restitution[touch]
        )
        a = np.array([0.0 if k in closed or small(k) else rates[k] for k in touch])
        z = np.concatenate([slips[lines], a])

        def impulses(c):
            if len(touch) == 1 and lines:
                return single(c.W, z, c.mu[0], c.mu_s[0], c.e[0])
            return several(c, z)

        r = impulses(c)
        after = z + c.W @ r
        f = len(lines)
        new = y.copy()
        new[n:] += back @ r
        little = [i for i, k in enumerate(touch) if a[i] < 0 and 0 < after[f + i] < REST]
        if little:  # bounces that fall back
            down = self._falls(t, new, [touch[i] for i in little], closed)
            little = [i for i in little if touch[i] in down]
        if little:
            e_0 = c.e.copy()
            e_0[little] = 0.0
            r = impulses(Touching(c.W, c.lines, c.mu, c.mu_s, e_0))
            after = z + c.W @ r
            new[n:] = y[n:] + back @ r
        self.impacts.append((t, tuple(touch), 0.5 * r @ (z + after)))
        self.struck = {k for i, k in enumerate(touch) if r[f + i] > 0}
        fastest = np.max(np.abs(after)) + speed
        rocks = [k for i, k in enumerate(touch) if after[f + i] > 1e-9 * fastest]
        if (
            len(touch) > 1
            and rocks
            and np.max(after[f:]) < ROCKS * speed
            and set(rocks) <= set(self._falls(t, new, rocks, set(touch) - set(rocks)))
        ):
            return new, set(touch), True
        return new, {k for i, k in enumerate(touch) if after[f + i] <= 1e-9 * fastest}, True

    def _falls(self, t, y, contacts, closed):
        """Return those of the contacts whose gaps accelerate towards closing."""
        gaps = self.e.watched(t, y, self.values)
        mode = [
            (OPEN if u and (k not in closed or k in contacts) else int(np.sign(s)) if f else 0)
            for k, (u, f, s) in enumerate(zip(self.e.unilateral, self.e.frictional, gaps[2], strict=True))
        ]
        a = self.solved(t, y, mode)[3]
        return [k for k in contacts if a[k] < 0]

    def projected(self, t, y, mode, moved=False):
        """Return the state on the constraints of the mode; only its places if `moved`."""
        e, y = self.e, y.copy()
        pressed = [k for k in range(self.n_c) if e.unilateral[k] and mode[k] != OPEN]
        stuck = [k for k in range(self.n_c) if e.frictional[k] and mode[k] == STICKS]
        for _ in range(2):
            if pressed:
                M, _, Jn, *_ = e.core(t, y, self.values)
                back = np.linalg.solve(M, Jn[pressed].T)
                gaps = e.watched(t, y, self.values)[0][pressed]
                y[: self.n] -= back @ np.linalg.lstsq(Jn[pressed] @ back, gaps, rcond=1e-10)[0]
        if (pressed or stuck) and not moved:
            M, _, Jn, _, Jt, _, _ = e.core(t, y, self.values)
            rows = np.array([*(Jn[k] for k in pressed), *(Jt[k] for k in stuck)])
            _, rates, slips = e.watched(t, y, self.values)
            back = np.linalg.solve(M, rows.T)
            wrong = np.concatenate([rates[pressed], slips[stuck]])
            y[self.n :] -= back @ np.linalg.lstsq(rows @ back, wrong, rcond=1e-10)[0]
        return y

    # -- the loop

    def run(self, start, horizon) -> Motion:
        """Return the motion from `start`; `reason` says why it ended early."""
        motion = Motion()
        self.impacts = motion.impacts
        y, t = np.array(start, dtype=float), 0.0
        self.final = y
        try:
            self._run(y, t, horizon, motion)
        except (NoSolution, NotUnique, RuntimeError) as error:
            motion.reason = f"{type(error).__name__}: {error}"
        return motion

    def _run(self, y, t, horizon, motion):
        mode, hit, slow = None, set(), set()
        for _ in range(self.most):
            closed = set() if mode is None else {k for k in range(self.n_c) if self.e.unilateral[k] and mode[k] != OPEN}
            y, near, jumped = self.strike(t, y, hit, closed)
            slips = self.e.watched(t, y, self.values)[2]
            size = STILL * (np.max(np.abs(y[self.n :])) + 1e-3)
            slow = {k for k in range(self.n_c) if self.e.frictional[k] and (k in slow or abs(slips[k]) <= size)}
            if jumped:
                slow = {k for k in slow if abs(slips[k]) <= size}
            new = self.select(t, y, near, slow)
            if mode is not None:
                for k in range(self.n_c):
                    if new[k] != mode[k] or (new[k] == OPEN and jumped and k in self.struck):
                        motion.events.append((t, self.e.touches[k].name, mode[k], new[k]))
            mode = new
            y = self.projected(t, y, mode)
            t, y, hit, slow = self.segment(t, y, mode, horizon)
            if t >= horizon:
                motion.final = y
                return
        raise RuntimeError("too many events")

    def guards(self, t, y, mode):
        """Return the guards of a mode and what each is."""
        gaps, _, slips = self.e.watched(t, y, self.values)
        values, what = [], []
        for k in range(self.n_c):
            if mode[k] == OPEN:
                values.append(gaps[k])
                what.append(("gap", k))
            elif mode[k]:
                values.append(mode[k] * slips[k])
                what.append(("slip", k))
        held = self.held(t, y, mode)
        return np.array([*values, *held]), [*what, *[("held", -1)] * len(held)]

    def segment(self, t, y, mode, end):
        """Integrate one mode up to its end: time, state, gaps that are zero, slips that are zero."""
        begin = t
        stuck = {k for k in range(self.n_c) if self.e.frictional[k] and mode[k] == STICKS}
        noise = {"gap": 1e-14, "slip": 1e-13, "held": 1e-10}
        solver, raised = None, None
        steps = 0
        while True:
            steps += 1
            if steps > 20000:
                raise RuntimeError("too many steps")
            if solver is None:
                solver = DOP853(
                    lambda t, y: self.rate(t, y, mode), t, y, end, max_step=max((end - begin) / 8, 1e-9) if end - begin < 0.4 else 0.05,
                    rtol=max(self.tolerance, 3e-14), atol=self.tolerance,
                )  # fmt: skip
            message = solver.step()
            if message:
                raise RuntimeError(message)
            dense = solver.dense_output()
            grid = t + (solver.t - t) * FINE
            if t == begin:
                early = [f * length for f in self._flights(t, y, mode).values() for length in (0.5, 0.9, 1.1)]
                soon = [*early, *((solver.t - t) * np.geomspace(1e-7, 0.06, 8))]
                grid = np.unique([*grid, *(t + s for s in soon if t + s < solver.t)])
            grid[-1] = solver.t
            table = np.array([self.guards(s, dense(s), mode)[0] for s in grid])
            what = self.guards(t, y, mode)[1]
            if raised is None:
                raised = np.zeros(len(what), dtype=bool)
                flights = self._flights(t, y, mode)
                for i, (kind, k) in enumerate(what):
                    if kind == "gap" and k in flights:
                        raised[i], table[grid < t + 0.4 * flights[k], i] = True, 1e-18
            first = None
            for i, (kind, _) in enumerate(what):
                found = self._first(
                    grid,
                    table[:, i],
                    raised,
                    i,
                    lambda s, i=i, dense=dense: self.guards(s, dense(s), mode)[0][i],
                    noise[kind],
                )
                if found is not None and (first is None or found < first[0]):
                    first = (found, i)
            if first is not None:
                at, i = first
                z = self._again(t, y, at, mode)
                kind, k = what[i]
                hit = {k} if kind == "gap" else set()
                slow = stuck | ({k} if kind == "slip" else set())
                return at, z, hit, slow
            t, y = solver.t, solver.y.copy()
            if solver.status == "finished":
                return t, y, set(), stuck

    def _flights(self, t, y, mode):
        """Return how long the flights of contacts that leave each other now would last without jerk."""
        gaps, rates, _ = self.e.watched(t, y, self.values)
        a = self.solved(t, y, mode)[3]
        fall = [k for k in range(self.n_c) if mode[k] == OPEN and gaps[k] < 1e-9 and rates[k] > 0 and a[k] < 0]
        return {k: -2 * rates[k] / a[k] for k in fall}

    def _again(self, t, y, at, mode):
        """Return the state at a time inside the last step, by steps of its own."""
        if at <= t:
            return y
        solver = DOP853(
            lambda t, y: self.rate(t, y, mode), t, y, at, rtol=max(self.tolerance, 3e-14), atol=self.tolerance
        )
        while solver.status == "running":
            solver.step()
        return solver.y.copy()

    @staticmethod
    def _first(grid, g, raised, i, function, noise):
        """Return where a guard falls below zero; one that starts there has to rise above the noise first."""
        for j, value in enumerate(g):
            if not raised[i]:
                if value > noise:
                    raised[i] = True
                elif value < -1e3 * noise and j:
                    return grid[j]  # at once: the mode does not last
                continue
            if value < 0:
                if j == 0:
                    return grid[0]
                a, b = grid[j - 1], grid[j]
                if function(a) <= 0:
                    return a
                return brentq(function, a, b, xtol=1e-15, rtol=8.9e-16)
            turns = j >= 2 and 0 < g[j - 1] <= min(g[j - 2], value)
            if turns and g[j - 1] <= 2 * (max(g[j - 2], value) - g[j - 1]):  # may lie below zero between
                low = minimize_scalar(
                    function, bounds=(grid[j - 2], grid[j]), method="bounded", options={"xatol": 1e-9}
                )
                if low.fun < 0 and function(grid[j - 2]) > 0:
                    return brentq(function, grid[j - 2], low.x, xtol=1e-15, rtol=8.9e-16)
        return None
