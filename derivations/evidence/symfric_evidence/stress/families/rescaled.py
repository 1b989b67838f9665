"""Scenes in other units of mass, length and time."""

from dataclasses import replace

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.symbols import TIME
from symfric.model.system import Contact
from symfric_evidence.stress.families.family import RandomStructure, dimensioned, pair_of_slips, structure_of


def rescaled(rng: np.random.Generator) -> RandomStructure:
    """One to three masses whose numbers are given in units of 1e-6 to 1e6 each."""
    n = int(rng.choice([1, 2, 3], p=[0.4, 0.4, 0.2]))
    q, u = (sp.symbols(f"{name}1:{n + 1}", real=True) for name in "xu")
    ranges, dimensions, number = dimensioned()
    masses: list[sp.Symbol] = []
    forces: list[sp.Expr] = []
    for i in range(n):
        ranges |= {q[i].name: (-1.5, 1.5), u[i].name: (-0.7, 0.7)}
        dimensions |= {q[i].name: (0, 1, 0), u[i].name: (0, 1, -1)}
        masses.append(number(f"m{i}", 0.5, 2.0, 1, 0, 0))
        forces.append(-number(f"k{i}", 0.5, 3.0, 1, 0, -2) * q[i] - number(f"d{i}", 0.02, 0.2, 1, 0, -1) * u[i])
        if rng.random() < 0.3:
            forces[i] -= number(f"h{i}", 0.1, 1.0, 1, -2, -2) * q[i] ** 3
    for i in range(n - 1):
        k = number(f"kc{i}", 0.2, 2.0, 1, 0, -2)
        forces[i] -= k * (q[i] - q[i + 1])
        forces[i + 1] += k * (q[i] - q[i + 1])
    if rng.random() < 0.4:
        forces[0] += number("F", 0.1, 1.0, 1, 1, -2) * sp.sin(number("Omega", 0.5, 5.0, 0, 0, -1) * TIME)
    slips = pair_of_slips(rng, u, int(rng.integers(1, 4)), ranges)
    dimensions |= {f"v{i + 1}": (0, 1, -1) for i in range(3)}
    contacts = []
    for i, slip in enumerate(slips):
        load = number(f"N{i}", 0.1, 1.5, 1, 1, -2)
        mu, r = number(f"mu{i}", 0.1, 0.6, 0, 0, 0), number(f"r{i}", 0.01, 0.5, 0, 0, 0)
        w = number(f"w{i}", 0.1, 1.0, 0, 1, -1)
        law = [
            laws.coulomb(mu),
            laws.coulomb(mu * (1 + r), mu),
            laws.stribeck(mu * (1 + r), mu, w),
            laws.cubic(mu * (1 + r), mu, w),
        ][rng.integers(4)]
        contacts.append(Contact(f"c{i}", slip, load, law))
    for s in (*q, *u):
        if rng.random() < 0.2:
            ranges[s.name] = (0.0, 0.0)
    unit = float(10.0 ** rng.uniform(-6, 6)) if rng.random() < 0.9 else 1.0
    structure = structure_of(q, u, forces, contacts, ranges, mass=sp.diag(*masses))
    return replace(structure, dimensions=dimensions, time_unit=unit)
