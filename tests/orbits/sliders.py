"""Masses on a belt or on the ground, coupled by springs and excited, with an event-driven simulation of SciPy's."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import symfric as sf

B, A, W, COUPLING = (sp.Symbol(name, real=True) for name in ("v_b", "A", "w", "k_c"))
LAW = sp.symbols("mu_s mu_k v_s", positive=True)
OF = {name: sp.symbols(f"{name}1 {name}2", real=True) for name in "mkcNxu"}


@cache
def equations(n, belt, forced):
    """Return the system and the contacts of n masses; the numbers are symbols, so that one program serves a family."""
    m, k, c, N, q, u = (OF[name][:n] for name in "mkcNxu")
    force = [-k[i] * q[i] - c[i] * u[i] for i in range(n)]
    if n == 2:
        force = [force[i] - COUPLING * (q[i] - q[1 - i]) for i in (0, 1)]
    if forced:
        force[0] += A * sp.cos(W * sf.TIME)
    law, speed = sf.laws.stribeck(*LAW), B if belt else sp.Integer(0)
    contacts = [sf.Contact("ab"[i], slip=u[i] - speed, normal=N[i], law=law) for i in range(n)]
    return sf.System(list(q), list(u), sp.diag(*m), force), contacts


@dataclass(frozen=True)
class Sliders:
    """``m_i x_i'' = -k_i x_i - k_c (x_i - x_j) - c_i x_i' + [A cos w t] + friction``, Stribeck's law without a peak."""

    m: tuple
    k: tuple
    c: tuple
    N: tuple
    law: tuple
    v_b: float = 0.0
    k_c: float = 0.0
    A: float = 0.0
    w: float = 0.0

    def at(self, name, value):
        return replace(self, **{name: float(value)})

    def scene(self, horizon=200.0, start=None):
        n = len(self.m)
        system, contacts = equations(n, self.v_b > 0, self.A > 0)
        values = {OF[name][i]: getattr(self, name)[i] for name in "mkcN" for i in range(n)}
        values |= dict(zip(LAW, self.law, strict=True))
        values |= {B: self.v_b} if self.v_b > 0 else {}
        values |= {COUPLING: self.k_c} if n == 2 else {}
        values |= {A: self.A, W: self.w} if self.A > 0 else {}
        begin = [0.1 * (-0.5) ** i for i in range(n)] + [0.0] * n if start is None else start
        initial = dict(zip([*OF["x"][:n], *OF["u"][:n]], map(float, begin), strict=True))
        return sf.Scene(system, contacts, values, initial, horizon)

    def run(self, start, period, rtol=1e-10):
        """Return the state after a time, by a simulation that knows each contact's mode; and the number of sticks."""
        n, (mu_s, mu_k, v_s) = len(self.m), self.law
        m, k, c, N = (np.array(e) for e in (self.m, self.k, self.c, self.N))
        K = np.diag(k) + (self.k_c * np.array([[1, -1], [-1, 1]]) if n == 2 else 0.0)
        first = np.eye(n)[0] * self.A

        def pull(t, y):
            return -K @ y[:n] - c * y[n:] + first * np.cos(self.w * t)

        def rates(t, y):
            now = np.maximum(mode * (y[n:] - self.v_b), 0.0)
            slips = -mode * N * (mu_k + (mu_s - mu_k) * np.exp(-now / v_s))
            force = pull(t, y)
            push = np.where(mode == 0, -force, slips)
            return np.concatenate([np.where(mode == 0, self.v_b, y[n:]), (force + push) / m])

        def left(t, y, i):
            return N[i] * mu_s - abs(pull(t, y)[i]) if mode[i] == 0 else mode[i] * (y[n + i] - self.v_b)

        def falls(t, y, i):  # where a slip turns: between two of its zeros within one step
            return 1.0 if mode[i] == 0 else mode[i] * rates(t, y)[n + i]

        events = [lambda t, y, i=i: left(t, y, i) for i in range(n)]
        turns = [lambda t, y, i=i: falls(t, y, i) for i in range(n)]
        for event, turn in zip(events, turns, strict=True):
            event.terminal, event.direction, turn.direction = True, -1, 1
        y, t, count = np.array(start, dtype=float), 0.0, [0] * n
        slip, force = y[n:] - self.v_b, pull(0.0, y)
        mode = np.where(np.abs(slip) > 1e-9, np.sign(slip), np.where(np.abs(force) <= N * mu_s, 0.0, np.sign(force)))
        for _ in range(1000):
            options = {"rtol": rtol, "atol": 1e-12, "max_step": 0.02, "dense_output": True}
            found = solve_ivp(rates, (t, period), y, "DOP853", events=[*events, *turns], **options)
            begin, y, t = t, found.y[:, -1].copy(), found.t[-1]
            passed = [
                (brentq(lambda s, j=j, sol=found.sol: left(s, sol(s), j), max(turn - 0.02, begin), turn, xtol=1e-15), j)
                for j in range(n)
                for turn in found.t_events[n + j]
                if left(turn, found.sol(turn), j) < -1e-12 and left(begin, found.y[:, 0], j) > 0
            ]
            if passed:
                t, i = min(passed)
                y = found.sol(t)
            elif found.status == 0:
                return y, count
            else:
                i = next(j for j in range(n) if found.t_events[j].size)
            force, y[n + i] = pull(t, y)[i], self.v_b
            holds = mode[i] != 0 and abs(force) <= N[i] * mu_s
            mode[i] = 0.0 if holds else np.sign(force)
            y[n + i] += 1e-12 * mode[i]  # off the edge, where rounding decides
            count[i] += bool(holds)
        raise AssertionError("too many events")
