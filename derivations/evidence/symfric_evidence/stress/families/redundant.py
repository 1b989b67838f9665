"""More contacts than independent slips: side by side, in loops of masses and ground, and without load."""

from dataclasses import replace

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.symbols import TIME
from symfric.model.system import Contact
from symfric_evidence.stress.families.family import RandomStructure, oscillators, parameter, structure_of

_MOST = 5  # contacts, since the reference tries all combinations of modes


def redundant(rng: np.random.Generator) -> RandomStructure:
    """Two to five contacts whose slips depend on each other, exactly or to 1e-6 to 1e-12; some carry no load."""
    n = int(rng.choice([1, 2, 3], p=[0.25, 0.6, 0.15]))
    q, u, forces, ranges = oscillators(n)
    ranges |= {"F": (0.2, 2.0), "Omega": (0.5, 5.0)}
    if rng.random() < 0.6:
        forces[0] += parameter("F") * sp.sin(parameter("Omega") * TIME)
    slips = [u[0], u[0]] if n == 1 else [u[0], u[1], u[0] - u[1]]
    if n > 1 and rng.random() < 0.4:
        slips.append(u[0] + u[1] / 2)
    if n > 2:
        slips.append(u[1] - u[2])
    for i in range(int(rng.integers(0, 4))):
        e, other = parameter(f"e{i}"), slips[rng.integers(len(slips))]
        ranges[e.name] = (1e-12, 1e-6)
        slips.append([other, 2 * other, other * (1 + e), other + e * u[-1], other + e * u[0], -other][rng.integers(6)])
    contacts: list[Contact] = []
    choices: dict[str, tuple[float, ...]] = {}
    for i, slip in enumerate(slips[:_MOST]):
        mu, r, load = parameter(f"mu{i}"), parameter(f"r{i}"), parameter(f"N{i}")
        ranges |= {mu.name: (0.1, 0.6), r.name: (0.01, 0.5), load.name: (0.1, 1.0)}
        if rng.random() < 0.5:
            choices[load.name] = (0.0, 0.0, 0.25, 0.5, 1.0)
        law = laws.coulomb(mu) if rng.random() < 0.6 else laws.coulomb(mu * (1 + r), mu)
        contacts.append(Contact(f"c{i + 1}", slip, load, law))
    if rng.random() < 0.4:
        ranges |= {s.name: (0.0, 0.0) for s in u}
    return replace(structure_of(q, u, forces, contacts, ranges), choices=choices)
