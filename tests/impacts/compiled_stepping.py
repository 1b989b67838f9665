"""The time stepping of `time_stepping`, compiled: cheap enough for thousands of scenes and small steps.

It is a copy in numba of `time_stepping.TimeStepping` and of what that takes from `impact_laws`; the tests prove that both
give the same motion.
"""

import functools
import math

import numba
import numpy as np
import sympy as sp
from numba import types

from tests.impacts.impact_laws import CLEAR, TIE, NoSolution, NotUnique
from tests.impacts.impact_reference import NEAR, T
from tests.impacts.time_stepping import STILL

VECTOR = types.Array(types.float64, 1, "C")
EVALUATED = types.void(types.float64, VECTOR, VECTOR, VECTOR)
FUNCTION = types.FunctionType(EVALUATED)
OK, NONE, SEVERAL = range(3)  # whether the impulses are unique
MOST = 4  # contacts


def _function(bodies, expressions):
    """Return expressions as compiled ``f(t, y, values, out)``."""
    states, t = [*bodies.q, *bodies.u], sp.Symbol("t_")
    names = {s: sp.Symbol(f"y_{i}") for i, s in enumerate(states)}
    names |= {s: sp.Symbol(f"p_{i}") for i, s in enumerate(bodies.parameters)} | {T: t}
    parts, left = sp.cse([sp.sympify(e).xreplace(names) for e in expressions], symbols=sp.numbered_symbols("c_"))
    lines = ["def f(t_, y, p, out):"]
    lines += [f"    y_{i} = y[{i}]" for i in range(len(states))]
    lines += [f"    p_{i} = p[{i}]" for i in range(len(bodies.parameters))]
    lines += [f"    {s} = {sp.pycode(e)}" for s, e in parts]
    lines += [f"    out[{i}] = {sp.pycode(e)}" for i, e in enumerate(left)]
    space = {"math": math}
    exec("\n".join(lines), space)
    return numba.njit([EVALUATED], cache=False)(space["f"])


@numba.njit(cache=False)
def _one(W, lines, mu, mu_s, z, target, scale, choice, r, after):
    """Set impulses and rates of one combination; return its margin, NaN if it has no impulses."""
    n, f = choice.size, lines.size
    A, b = np.eye(f + n), np.zeros(f + n)
    for k in range(n):
        if choice[k] == 0:
            continue
        A[f + k], b[f + k] = W[f + k], target[k] - z[f + k]
        for i in range(f):
            if lines[i] != k:
                continue
            if choice[k] == 1:
                A[i], b[i] = W[i], -z[i]
            else:
                A[i, f + k] = mu[k] if choice[k] == 2 else -mu[k]
    found, _, _, singular = np.linalg.lstsq(A, b, 1e-11)
    if np.max(np.abs(A @ found - b)) > TIE * scale:
        return np.nan
    loose = singular[-1] < 1e-11 * singular[0]
    r[:] = found
    after[:] = z + W @ found
    margin = np.inf
    for k in range(n):
        p, row = r[f + k] * W[f + k, f + k], -1
        for i in range(f):
            if lines[i] == k:
                row = i
        margin = min(margin, after[f + k] - target[k] if choice[k] == 0 else p)
        if choice[k] == 1 and row >= 0:
            margin = min(margin, (mu_s[k] * r[f + k] - abs(r[row])) * W[row, row])
        if choice[k] >= 2:
            margin = min(margin, after[row] if choice[k] == 2 else -after[row])
    if loose and margin < -TIE * scale:
        return np.nan
    return margin


@numba.njit(cache=False)
def _chosen(W, lines, mu, mu_s, e, z, share, choice, guessed, r):
    """Set what every contact does, and the impulses; the choice given is the guess, if it is `guessed`."""
    n, f = e.size, lines.size
    target = share * e * np.maximum(-z[f:], 0.0)
    scale = np.max(np.abs(z)) + 1e-300
    trial, after = np.zeros(f + n), np.zeros(f + n)
    if guessed and _one(W, lines, mu, mu_s, z, target, scale, choice, r, after) > CLEAR * scale:
        return OK
    kinds, total = np.full(n, 2), 1
    for k in lines:
        kinds[k] = 4
    for k in range(n):
        total *= kinds[k]
    margins, rates = np.full(total, np.nan), np.zeros((total, f + n))
    best, most, now = -1, 0, np.zeros(n, dtype=np.int64)
    for c in range(total):
        rest = c
        for k in range(n - 1, -1, -1):
            now[k] = rest % kinds[k]
            rest //= kinds[k]
        margin = _one(W, lines, mu, mu_s, z, target, scale, now, trial, after)
        if not margin >= -TIE * scale:
            continue
        held = np.sum((now == 1) & (mu_s > mu)) if margin > 1e-6 * scale else 0
        if held < most:
            continue
        if held > most:  # what static friction can hold stays
            best, most = -1, held
            margins[:] = np.nan
        margins[c], rates[c] = margin, after
        if best < 0 or margin > margins[best]:
            best = c
            choice[:], r[:] = now, trial
    if best < 0:
        return NONE
    for c in range(total):
        if margins[c] > 1e-6 * scale and np.max(np.abs(rates[c] - rates[best])) > 1e-6 * scale:
            return SEVERAL
    return OK


@numba.njit(cache=False)
def _gained(W, z, r):
    return r @ (z + 0.5 * (W @ r))


@numba.njit(cache=False)
def _several(W, lines, mu, mu_s, e, z, r):
    choice = np.zeros(e.size, dtype=np.int64)
    status = _chosen(W, lines, mu, mu_s, e, z, 1.0, choice, False, r)
    if status != OK:
        return status
    size = np.abs(r) @ (np.abs(z) + np.abs(z + W @ r)) + 1e-300
    if _gained(W, z, r) <= 1e-11 * size:
        return OK
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        status = _chosen(W, lines, mu, mu_s, e, z, middle, choice, False, r)
        if status != OK:
            return status
        if _gained(W, z, r) <= 0:
            low = middle
        else:
            high = middle
    return _chosen(W, lines, mu, mu_s, e, z, low, choice, False, r)


@numba.njit(cache=False)
def _single(W, z, mu, mu_s, e, r):
    """Follow the impact of one contact phase by phase; first to Newton's end, then, if that gains energy, Stronge's."""
    tt, tn, nn = W[0, 0], W[0, 1], W[1, 1]
    q, length, n = np.zeros(2), np.full(2, np.inf), 0
    w, held = z[0], False
    if abs(w) > 1e-12 * (abs(w) + abs(z[1])):
        d = np.sign(w)
        change = tn - d * mu * tt
        q[0], n = -d * mu, 1
        held = d * change >= 0
        if not held:
            length[0] = -w / change
    if not held:
        q[n] = -tn / tt if abs(tn) <= mu_s * tt else -np.sign(tn) * mu
        n += 1
    for rule in range(2):
        r[:] = 0.0
        used_in, used_out, ended = 0.0, 0.0, False
        for k in range(n):
            a, slope = (z + W @ r)[1], nn + tn * q[k]
            if rule == 0:
                end = (-e * z[1] - a) / slope if slope != 0.0 else np.inf
                if not end >= 0:
                    end = np.inf
            else:
                used, end = 0.0, 0.0
                if a < 0:
                    part = min(-a / slope if slope > 0 else np.inf, length[k])
                    used_in += -(a + 0.5 * slope * part) * part
                    if part == length[k]:
                        end = np.inf
                    a, used = 0.0, part
                if end == 0.0:
                    left = e * e * used_in - used_out
                    rest = (-a + np.sqrt(a * a + 2 * slope * left)) / slope
                    end = used + rest
                    if end > length[k]:
                        x = length[k] - used
                        used_out += a * x + 0.5 * slope * x * x
                        end = np.inf
            short = min(end, length[k])
            r[0] += short * q[k]
            r[1] += short
            if end <= length[k]:
                ended = True
                break
        if not ended:
            return NONE
        if _gained(W, z, r) <= 1e-12 * (np.abs(r) @ np.abs(z)):
            return OK
    return OK


@numba.njit(cache=False)
def _still(slips):
    return np.abs(slips) <= STILL * (1 + np.max(np.abs(slips)))


@numba.njit(cache=False)
def _forces(W, lines, near, e, mu, mu_s, still, z, done, known, r):
    """Set the impulses of what the forces add in a step."""
    key, m = 0, near.size
    bound = np.zeros(m)
    for i in range(m):
        key += 1 << near[i]
        bound[i] = mu_s[near[i]] if still[near[i]] else mu[near[i]]
    choice = done[key, :m].copy()
    status = _chosen(W, lines, bound, bound, e[near], z, 0.0, choice, known[key], r)
    known[key] = True
    done[key, :m] = choice
    return status


_FLAGS, _TABLE = types.Array(types.boolean, 1, "C"), types.Array(types.float64, 2, "C")
_SIGNATURE = types.UniTuple(types.int64, 2)(
    FUNCTION, FUNCTION, types.int64, _FLAGS, _FLAGS, _TABLE, VECTOR, VECTOR, types.float64, types.int64, types.int64, _TABLE
)  # fmt: skip


def _run(core, watched, n, frictional, unilateral, numbers, values, start, horizon, steps, shown, path):
    n_c = frictional.size
    restitution, mu, mu_s = numbers[0], numbers[1], numbers[2]
    h, y = horizon / steps, start.copy()
    flat, seen, state = np.zeros(n * n + n + 2 * (n_c * n + n_c) + n_c), np.zeros(3 * n_c), np.zeros(2 * n)
    watched(0.0, y, values, seen)
    pressed, still = seen[:n_c] <= NEAR, _still(seen[2 * n_c :])
    done, known = np.zeros((1 << MOST, MOST), dtype=np.int64), np.zeros(1 << MOST, dtype=np.bool_)
    for step in range(steps):
        t = step * h
        state[:n], state[n:] = y[:n] + h / 2 * y[n:], y[n:]
        u = y[n:].copy()
        core(t + h / 2, state, values, flat)
        watched(t + h / 2, state, values, seen)
        M, at = flat[: n * n].copy().reshape(n, n), n * n
        force, at = flat[at : at + n].copy(), at + n
        Jn, at = flat[at : at + n_c * n].copy().reshape(n_c, n), at + n_c * n + n_c
        Jt, at = flat[at : at + n_c * n].copy().reshape(n_c, n), at + n_c * n + n_c
        load = flat[at : at + n_c]
        gaps, rates, slips = seen[:n_c].copy(), seen[n_c : 2 * n_c].copy(), seen[2 * n_c :].copy()
        free = h * np.linalg.solve(M, force)
        moved = h * (h + np.max(np.abs(free)))
        near = np.array(
            [k for k in range(n_c) if unilateral[k] and gaps[k] <= NEAR + pressed[k] * moved], dtype=np.int64
        )
        rubs = np.array([k for k in range(n_c) if not unilateral[k]], dtype=np.int64)
        lines = np.array([i for i in range(near.size) if frictional[near[i]]], dtype=np.int64)
        a, m = lines.size, lines.size + near.size
        rows, z = np.zeros((m + rubs.size, n)), np.zeros(m + rubs.size)
        for i in range(a):
            rows[i], z[i] = Jt[near[lines[i]]], slips[near[lines[i]]]
        for i in range(near.size):
            rows[a + i], z[a + i] = Jn[near[i]], rates[near[i]]
        for i in range(rubs.size):
            rows[m + i] = Jt[rubs[i]]
        back = np.linalg.solve(M, np.ascontiguousarray(rows.T))
        W = rows @ back
        inner, pull = np.ascontiguousarray(W[:m, :m]), np.ascontiguousarray(back[:, :m])
        if near.size and np.any(rates[near] < -STILL * (np.max(np.abs(u)) + np.max(np.abs(rates[near])))):
            r = np.zeros(m)
            if near.size == 1 and a == 1:
                status = _single(inner, z[:m], mu[near[0]], mu_s[near[0]], restitution[near[0]], r)
            else:
                status = _several(inner, lines, mu[near], mu_s[near], restitution[near], z[:m], r)
            if status != OK:
                return status, step
            u = u + pull @ r
            slips = slips + Jt @ (pull @ r)
            z[:m] += inner @ r
        for i in range(rubs.size):
            z[m + i] = slips[rubs[i]]
        z += rows @ free
        r = np.zeros(m + rubs.size)
        for _ in range(200):
            old = r.copy()
            if near.size:
                part = np.zeros(m)
                other = z[:m] + np.ascontiguousarray(W[:m, m:]) @ r[m:]
                status = _forces(inner, lines, near, restitution, mu, mu_s, still, other, done, known, part)
                if status != OK:
                    return status, step
                r[:m] = part
            for i in range(rubs.size):
                bound, own = h * load[rubs[i]] * mu[rubs[i]], W[m + i, m + i]
                rest = z[m + i] + W[m + i] @ r - own * r[m + i]
                r[m + i] = min(max(-rest / own, -bound), bound)
            most = 1e-300
            for i in range(r.size):
                most = max(most, abs(r[i]))
            if rubs.size == 0 or np.max(np.abs(r - old)) <= 1e-14 * most:
                break
        u = u + free + back @ r
        pressed[:] = False
        for i in range(near.size):
            pressed[near[i]] = r[a + i] > 0
        state[n:] = u
        watched(t + h / 2, state, values, seen)
        still = _still(seen[2 * n_c :])
        y[:n] += h / 2 * (y[n:] + u)
        y[n:] = u
        if (step + 1) % (steps // shown) == 0:
            path[(step + 1) // (steps // shown) - 1] = y[:n]
    return OK, steps


@functools.cache
def _compiled():
    """Return `_run` as machine code; when it is first called for, since compiling it takes longer than to collect all tests."""
    return numba.njit([_SIGNATURE], cache=False)(_run)


class CompiledStepping:
    """The motions of `TimeStepping`, for one structure and any values of its parameters."""

    def __init__(self, equations):
        bodies = equations.bodies
        self.e = equations
        q, u = sp.Matrix(bodies.q), sp.Matrix(bodies.u)
        gaps = [c.gap if c.gap is not None else sp.S.Zero for c in bodies.touches]
        rates = [(sp.Matrix([g]).jacobian(q) * u)[0] + g.diff(T) for g in gaps]
        slips = [c.slip if c.slip is not None else sp.S.Zero for c in bodies.touches]
        flat = [*bodies.mass, *bodies.force]
        for r in (rates, slips):
            flat += [e.diff(v) for e in r for v in bodies.u]
            flat += [(sp.Matrix([e]).jacobian(q) * u)[0] + e.diff(T) for e in r]
        flat += [c.load for c in bodies.touches]
        self.core, self.watched = _function(bodies, flat), _function(bodies, [*gaps, *rates, *slips])
        self.frictional, self.unilateral = np.array(equations.frictional), np.array(equations.unilateral)

    def run(self, values, start, horizon, steps, shown):
        """Return the coordinates at `shown` equal times up to the horizon, shape (shown, n); it must divide `steps`."""
        path = np.zeros((shown, self.e.n))
        numbers = np.array(self.e._coefficients(*values), dtype=float).reshape(3, -1)
        status, at = _compiled()(
            self.core, self.watched, self.e.n, self.frictional, self.unilateral, numbers,
            np.array(values, dtype=float), np.array(start, dtype=float), float(horizon), steps, shown, path,
        )  # fmt: skip
        if status != OK:
            raise (NoSolution if status == NONE else NotUnique)(f"in step {at}")
        return path
