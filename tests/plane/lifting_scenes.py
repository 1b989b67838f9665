"""Random bodies on a shaken table that they may leave while they slide in the plane, for the package and the reference.

One `Family` is one scene with parameters, compiled once; a seed draws its numbers.
"""

from functools import cache, cached_property

import numpy as np
import sympy as sp

import symfric as sf
from tests.plane.lifting_reference import Sliding, Stepping

HORIZON = 6.0
OUTPUTS = {"events": sf.Events(), "path": sf.Trajectory()}
KINDS = ("alone", "plane opens", "line opens", "plane", "line and stop")  # what is on the second body


class Family:
    """One or two bodies of three coordinates each, the first on a contact in the plane that opens; `kind` of `KINDS`."""

    def __init__(self, kind):
        self.kind, self.n = kind, 3 if kind == "alone" else 6
        n = self.n
        self.q, self.u = (sp.symbols(f"{name}:{n}", real=True) for name in "qu")
        self.entries = {(i, j): sp.Symbol(f"m{i}{j}", real=True) for i in range(n) for j in range(i + 1)}
        self.pull, self.drive, self.spring = (sp.symbols(f"{name}:{n}", real=True) for name in ("p", "a", "k"))
        self.w, self.s, self.joint = sp.symbols("w s c", real=True)
        self.e, self.mu, self.mu_s = (sp.symbols(f"{name}:2", nonnegative=True) for name in ("e", "mu", "ms"))

    @cached_property
    def program(self):
        return sf.prepare(self.scene(self.draw(0)[0], self.draw(0)[1]), tolerance=1e-12)

    @cached_property
    def loose(self):
        return sf.prepare(self.scene(self.draw(0)[0], self.draw(0)[1]), tolerance=1e-9)

    def scene(self, values, start):
        n, q, u, t = self.n, self.q, self.u, sf.TIME
        M = sp.Matrix(n, n, lambda i, j: self.entries[max(i, j), min(i, j)])
        force = [self.pull[i] + self.drive[i] * sp.cos(self.w * t + i) - self.spring[i] * q[i] for i in range(n)]
        if n == 6:
            for i in range(2):
                force[i] -= self.joint * (q[i] - q[i + 3])
                force[i + 3] += self.joint * (q[i] - q[i + 3])
        laws = [sf.laws.coulomb(a, b) for a, b in zip(self.mu_s, self.mu, strict=True)]
        table = sf.Unilateral(q[2] - self.s * sp.cos(self.w * t), self.e[0])
        contacts = [sf.Contact("table", (u[0], u[1]), table, laws[0])]
        if n == 6:
            floor = sf.Unilateral(q[5], self.e[1])
            slip = u[3] if "line" in self.kind else (u[3], u[4])
            contacts.append(sf.Contact("second", slip, floor if "opens" in self.kind else 0.7, laws[1]))
        if "stop" in self.kind:
            contacts.append(sf.Contact("stop", None, floor))
        values = {s: values[s.name] for s in self.parameters}
        states = dict(zip((*q, *u), map(float, start), strict=True))
        return sf.Scene(sf.System(q, u, M, force), contacts, values, states, HORIZON, outputs=OUTPUTS)

    @property
    def parameters(self):
        joint = [self.joint, self.e[1], self.mu[1], self.mu_s[1]]
        used = [] if self.kind == "alone" else [s for s in joint if self.kind != "plane" or s != self.e[1]]
        own = [self.w, self.s, self.e[0], self.mu[0], self.mu_s[0]]
        return [*self.entries.values(), *self.pull, *self.drive, *self.spring, *own, *used]

    def draw(self, seed):
        """Return values by name and the start of a seed."""
        rng, n = np.random.default_rng(seed), self.n
        A = rng.normal(size=(n, n)) * rng.choice([0.0, 0.1, 0.2 if n == 3 else 0.1])
        M = np.diag(rng.uniform(0.7, 1.5, n)) + (A + A.T) / 2
        values = {s.name: M[i, j] for (i, j), s in self.entries.items()}
        up = [i % 3 == 2 for i in range(n)]
        values |= {s.name: -1.0 if z else rng.normal() * 0.2 for s, z in zip(self.pull, up, strict=True)}
        values |= {s.name: rng.normal() * 0.5 for s in self.drive}
        values |= {s.name: 0.0 if z else rng.uniform(0.2, 1.0) for s, z in zip(self.spring, up, strict=True)}
        values |= {"w": rng.uniform(1.0, 2.5), "s": float(rng.choice([0.0, 0.15])), "c": rng.uniform(0.0, 0.8)}
        for k in range(2):
            mu = rng.uniform(0.1, 0.5)
            values |= {f"e{k}": float(rng.choice([0.0, 0.0, rng.uniform(0, 0.7)])), f"mu{k}": mu}
            values[f"ms{k}"] = mu * rng.choice([1.0, 1.3])
        start = np.concatenate([rng.normal(size=n) * 0.3, rng.normal(size=n) * 0.4])
        for i in range(2, n, 3):
            start[i] = abs(start[i]) + 0.2
        return values, start

    def run(self, seed, program=None):
        """Return the run of a seed."""
        values, start = self.draw(seed)
        used = {s.name: values[s.name] for s in self.parameters}
        names = [s.name for s in (*self.q, *self.u)]
        return (program or self.program).run(values=used, initial=dict(zip(names, start, strict=True)))

    def stepped(self, seed, steps, shown):
        """Return the coordinates of a seed by time stepping."""
        v, start = self.draw(seed)
        n, w, s = self.n, v["w"], v["s"]
        M = np.array([[v[self.entries[max(i, j), min(i, j)].name] for j in range(n)] for i in range(n)])
        pull, drive, spring = (np.array([v[e.name] for e in e_s]) for e_s in (self.pull, self.drive, self.spring))

        def force(t, q, u):
            f = pull + drive * np.cos(w * t + np.arange(n)) - spring * q
            if n == 6:
                f[:2] -= v["c"] * (q[:2] - q[3:5])
                f[3:5] += v["c"] * (q[:2] - q[3:5])
            return f

        unit = np.eye(n)
        moved = lambda t: (s * np.cos(w * t), -s * w * np.sin(w * t))  # noqa: E731
        contacts = [Sliding(unit[:2], v["mu0"], v["ms0"], unit[2], e=v["e0"], shift=moved)]
        if n == 6:
            slips = unit[3:4] if "line" in self.kind else unit[3:5]
            normal = {"normal": unit[5], "e": v["e1"]} if "opens" in self.kind else {"load": 0.7}
            contacts.append(Sliding(slips, v["mu1"], v["ms1"], **normal))
        if "stop" in self.kind:
            contacts.append(Sliding(np.zeros((0, n)), 0.0, 0.0, unit[5], e=v["e1"]))
        return Stepping(M, force, contacts).run(start, HORIZON, steps, shown)


@cache
def family(kind):
    return Family(kind)
