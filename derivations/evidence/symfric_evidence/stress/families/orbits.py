"""Scenes with limit cycles: masses on belts and forced ones, with static friction above kinetic."""

from dataclasses import replace

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.symbols import TIME
from symfric.model.system import Contact
from symfric_evidence.stress.families.family import RandomStructure, dimensioned, real, structure_of


def _one_mass(rng: np.random.Generator, forced: bool, moving: bool, time_unit: float | None = None) -> RandomStructure:
    x, u = real("x"), real("u")
    ranges, dimensions, number = dimensioned()
    ranges |= {"x": (0.5, 1.5), "u": (0.0, 0.0)}
    dimensions |= {"x": (0, 1, 0), "u": (0, 1, -1)}
    force = -number("k", 0.8, 1.25, 1, 0, -2) * x - number("d", 0.02, 0.15, 1, 0, -1) * u
    if rng.random() < 0.4:
        force -= number("h", 0.05, 0.3, 1, -2, -2) * x**3
    if forced:
        force += number("F", 0.6, 1.6, 1, 1, -2) * sp.cos(number("Omega", 0.7, 2.2, 0, 0, -1) * TIME)
    slip = u - number("v_b", 0.1, 0.5, 0, 1, -1) if moving else u
    mu, r, w = number("mu", 0.2, 0.4, 0, 0, 0), number("r", 0.05, 0.6, 0, 0, 0), number("w", 0.3, 1.0, 0, 1, -1)
    law = [
        laws.coulomb(mu * (1 + r), mu),
        laws.stribeck(mu * (1 + r), mu, w),
        laws.lorentz(mu, w, mu * (1 + r)),
        laws.cubic(mu * (1 + r), mu, w),
        laws.coulomb(mu),
    ][rng.integers(4 if moving and not forced else 5)]
    contact = Contact("c", slip, number("N", 0.5, 1.0, 1, 1, -2), law)
    mass = sp.Matrix([[number("m", 0.8, 1.25, 1, 0, 0)]])
    structure = structure_of([x], [u], [force], [contact], ranges, 200.0, mass=mass)
    return structure if time_unit is None else replace(structure, dimensions=dimensions, time_unit=time_unit)


def cycles(rng: np.random.Generator) -> RandomStructure:
    """Limit cycles of one mass, self-excited or forced, in units of 1e-6 to 1e6 each."""
    forced = rng.random() < 0.5
    moving = not forced or rng.random() < 0.5
    return _one_mass(rng, forced, moving, time_unit=float(10.0 ** rng.uniform(-6, 6)))


def branches(rng: np.random.Generator) -> RandomStructure:
    """Branches of forced vibrations over the amplitude of the force, down to where they stick."""
    return _one_mass(rng, True, rng.random() < 0.4)
