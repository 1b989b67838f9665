"""Friction that differs from place to place, belts that change their speed, and contacts that are nearly parallel."""

from collections.abc import Sequence

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.symbols import TIME
from symfric.model.system import Contact
from symfric_evidence.stress.families.family import (
    RandomStructure,
    Ranges,
    oscillators,
    pair_of_slips,
    parameter,
    plain_contact,
    real,
    structure_of,
)


def _cells(rng: np.random.Generator, q: sp.Symbol, edges: Sequence[sp.Rational], ranges: Ranges) -> sp.Piecewise:
    values = [parameter(f"p{i}") for i in range(len(edges) + 1)]
    ranges |= {p.name: (0.3, 2.0) for p in values}
    return sp.Piecewise(*((p, q < e) for p, e in zip(values[:-1], edges, strict=True)), (values[-1], True))


def cell_edges(rng: np.random.Generator) -> RandomStructure:
    """A mass at rest on the edge of two friction cells, pushed by what changes with time."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.3))
    edges = np.sort(rng.choice(np.arange(-6, 7), int(rng.integers(1, 6)), replace=False)) / 8
    start = float(rng.choice(edges))
    ranges |= {q[0].name: (start, start), u[0].name: (0.0, 0.0)}
    n, mu, r, f, omega = (parameter(p) for p in ("N", "mu", "r", "F", "Omega"))
    ranges |= {"N": (0.2, 1.5), "mu": (0.1, 0.6), "r": (0.01, 0.5), "c": (-1.0, 1.0)}
    ranges |= {"F": (0.2, 2.0), "Omega": (0.5, 5.0)}
    push = [f * sp.sin(omega * TIME), -f * sp.sin(omega * TIME), f * (1 - sp.exp(-TIME)), real("c") * TIME, real("c")]
    forces[0] += push[rng.integers(len(push))]
    if rng.random() < 0.5:  # nothing else pushes at the start
        forces[0] = forces[0].subs(q[0], q[0] - sp.Rational(start))
    law = [laws.coulomb(mu), laws.coulomb(mu * (1 + r), mu), laws.stribeck(mu * (1 + r), mu, r)][rng.integers(3)]
    profile = _cells(rng, q[0], [sp.Rational(e) for e in edges], ranges)
    contacts = [Contact("patched", u[0], n, law, profile)]
    if len(q) > 1 and rng.random() < 0.5:
        contacts.append(plain_contact(rng, "c2", u[1], ranges))
    return structure_of(q, u, forces, contacts, ranges, exact=(q[0].name, u[0].name))


def profiles(rng: np.random.Generator) -> RandomStructure:
    """Friction that changes with position, with kinks or smoothly; starts at rest on the kink among them."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.3))
    (slip,) = pair_of_slips(rng, u, 1, ranges)
    h, e = parameter("h"), real("e")
    ranges |= {"h": (0.2, 2.0), "e": (-0.5, 0.5)}
    profile = [
        1 + h * sp.Abs(q[0] - e),
        sp.Max(h, 1 - sp.Abs(q[0])),
        1 + h * q[0] ** 2,
        h * q[0] ** 2,
        h * sp.Abs(q[0]),
        sp.Piecewise((1 + h * (q[0] - e), q[0] > e), (1, True)),
        1 + sp.sin(8 * q[0]) / 2,
    ][rng.integers(7)]
    contacts = [plain_contact(rng, "c1", slip, ranges, profile=profile)]
    if rng.random() < 0.4:
        ranges |= {u[0].name: (0.0, 0.0)} | ({q[0].name: (0.0, 0.0)} if rng.random() < 0.5 else {})
        f, omega = parameter("F"), parameter("Omega")
        ranges |= {"F": (0.2, 2.0), "Omega": (0.5, 5.0)}
        forces[0] += f * sp.sin(omega * TIME)
    return structure_of(q, u, forces, contacts, ranges)


def belts(rng: np.random.Generator) -> RandomStructure:
    """Belts whose speed changes with time, or with the position of a body."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.4))
    contacts = []
    for i in range(1 + int(rng.random() < 0.4)):
        v, a, omega = real(f"v{i}"), real(f"a{i}"), parameter(f"Omega{i}")
        ranges |= {v.name: (-0.4, 0.4), a.name: (-0.6, 0.6), omega.name: (0.5, 8.0)}
        speed = [
            v + a * sp.sin(omega * TIME),
            v * (1 - sp.exp(-omega * TIME)),
            v + a * sp.tanh(omega * (TIME - 2)),
            a * TIME,
            a * TIME * sp.exp(-TIME),
            v + a * sp.Max(sp.sin(omega * TIME), 0),
            v + a * q[0],
            a * sp.sin(omega * TIME) ** 3,
            v + a * sp.Abs(sp.cos(omega * TIME)),
        ][rng.integers(9)]
        contacts.append(plain_contact(rng, f"c{i + 1}", u[int(rng.integers(len(u)))] - speed, ranges))
    return structure_of(q, u, forces, contacts, ranges)


def parallel(rng: np.random.Generator) -> RandomStructure:
    """Two to four contacts whose slip rows differ by 1e-4 to 1e-10, or not at all."""
    n = int(rng.choice([1, 2, 3], p=[0.2, 0.6, 0.2]))
    q, u, forces, ranges = oscillators(n)
    f, omega = parameter("F"), parameter("Omega")
    ranges |= {"F": (0.2, 2.0), "Omega": (0.5, 5.0)}
    if rng.random() < 0.6:
        forces[0] += f * sp.sin(omega * TIME)
    base = u[0] if n == 1 or rng.random() < 0.5 else u[0] - u[1]
    contacts = []
    for i in range(int(rng.integers(2, 5))):
        e = parameter(f"e{i}")
        ranges[e.name] = (1e-10, 1e-4)
        slip = base if i == 0 else [base * (1 + e), base + e * u[n - 1], base + e * u[0], base][rng.integers(4)]
        mu, r, load = parameter(f"mu{i}"), parameter(f"r{i}"), parameter(f"N{i}")
        ranges |= {mu.name: (0.1, 0.6), r.name: (0.01, 0.5), load.name: (0.1, 1.0)}
        law = laws.coulomb(mu) if rng.random() < 0.6 else laws.coulomb(mu * (1 + r), mu)
        contacts.append(Contact(f"c{i + 1}", slip, load, law))
    if n > 1 and rng.random() < 0.4:
        contacts.append(plain_contact(rng, "c9", u[1], ranges))
    if rng.random() < 0.4:
        ranges |= {s.name: (0.0, 0.0) for s in u}
    return structure_of(q, u, forces, contacts, ranges)
