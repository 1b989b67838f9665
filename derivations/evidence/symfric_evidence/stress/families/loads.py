"""Loads far below the other forces, loads that vanish with the slip, and loads that come and go."""

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.symbols import TIME
from symfric.model.system import Contact
from symfric_evidence.stress.families.family import (
    RandomStructure,
    oscillators,
    pair_of_slips,
    parameter,
    plain_contact,
    structure_of,
)


def weak(rng: np.random.Generator) -> RandomStructure:
    """Contacts whose loads are 1e-10 to 1e-20 of the other forces, some beside one that is not."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.4))
    slips = pair_of_slips(rng, u, 1 + int(rng.integers(2)), ranges)
    contacts = []
    for i, slip in enumerate(slips):
        weak, name = parameter(f"weak{i + 1}"), f"c{i + 1}"
        ordinary = i > 0 and rng.random() < 0.4
        contacts.append(plain_contact(rng, name, slip, ranges, load=1 if ordinary else weak))
        ranges[weak.name] = (1e-20, 1e-10)
    if rng.random() < 0.3:
        f, omega = parameter("F"), parameter("Omega")
        ranges |= {"F": (0.1, 1.0), "Omega": (0.5, 5.0)}
        forces[0] += f * sp.sin(omega * TIME)
    for s in u:  # at rest and on the contact, where the load cannot hold
        if rng.random() < 0.5:
            ranges[s.name] = (0.0, 0.0)
    return structure_of(q, u, forces, contacts, ranges)


def vanishing(rng: np.random.Generator) -> RandomStructure:
    """A load that is zero where the contact could stick."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.3))
    (slip,) = pair_of_slips(rng, u, 1, ranges)
    n, mu, r, w = (parameter(p) for p in ("N", "mu", "r", "w"))
    ranges |= {"N": (0.2, 3.0), "mu": (0.1, 0.6), "r": (0.01, 0.5), "w": (0.1, 1.0)}
    load = [
        slip**2,
        sp.Abs(slip),
        slip**4,
        slip**2 * (1 + q[0] ** 2),
        1 - sp.cos(slip),
        sp.sqrt(1 + slip**2) - 1,
        slip**2 / (1 + slip**2),
        sp.Abs(slip) ** 3,
        u[0] ** 2,
        sp.Abs(u[0]),
        q[0] ** 2,
        slip**2 + q[0] ** 2,
    ][rng.integers(12)]
    law = [laws.coulomb(mu), laws.coulomb(mu * (1 + r), mu), laws.stribeck(mu * (1 + r), mu, w)][rng.integers(3)]
    contacts = [Contact("vanishing", slip, n * load, law)]
    if rng.random() < 0.3:
        contacts.append(plain_contact(rng, "c2", u[int(rng.integers(len(u)))], ranges))
    ranges[u[0].name] = (0.0, 0.0) if rng.random() < 0.4 else ranges[u[0].name]
    return structure_of(q, u, forces, contacts, ranges)


def opening(rng: np.random.Generator) -> RandomStructure:
    """A load `Max(0, ...)` of a position or of time."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.4))
    (slip,) = pair_of_slips(rng, u, 1, ranges)
    g, omega, e = parameter("g"), parameter("Omega"), parameter("e")
    ranges |= {"g": (0.2, 3.0), "Omega": (0.5, 5.0), "e": (0.05, 0.8)}
    load = [e + q[-1], sp.sin(omega * TIME), -q[-1], e - q[0] ** 2][rng.integers(4)]
    contacts = [plain_contact(rng, "c1", slip, ranges, load=g * sp.Max(load, 0))]
    return structure_of(q, u, forces, contacts, ranges)


def switched(rng: np.random.Generator) -> RandomStructure:
    """Forces and loads that begin, bend and end at given times, which are parameters."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.4))
    f, on, off = parameter("F"), parameter("t_on"), parameter("t_off")
    ranges |= {"F": (0.2, 2.0), "t_on": (0.1, 2.0), "t_off": (2.1, 3.9)}
    shape = [
        sp.Min(TIME / on, 1),
        sp.Piecewise((0, TIME < on), (sp.sin(3 * (TIME - on)), True)),
        sp.Piecewise((0, TIME < on), ((TIME - on) / (off - on), TIME < off), (1, True)),
        sp.Max((TIME - on) * (off - TIME), 0),
    ][rng.integers(4)]
    slips, loaded = pair_of_slips(rng, u, 1 + int(rng.random() < 0.4), ranges), rng.random() < 0.3
    if not loaded:
        forces[int(rng.integers(len(q)))] += f * shape
    load = 1 + f * shape**2 if loaded else 1
    contacts = [plain_contact(rng, f"c{i + 1}", s, ranges, load=load if i == 0 else 1) for i, s in enumerate(slips)]
    return structure_of(q, u, forces, contacts, ranges)
