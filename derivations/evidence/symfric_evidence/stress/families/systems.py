"""First-order states with kinks, masses that depend on the position, sampled inputs, and scenes without contacts."""

from collections.abc import Sequence

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.symbols import TIME
from symfric.model.system import Contact, Signal
from symfric_evidence.stress.families.family import (
    RandomStructure,
    Ranges,
    oscillators,
    pair_of_slips,
    parameter,
    plain_contact,
    real,
    some_contacts,
    structure_of,
)


def _with_state(
    rng: np.random.Generator, q: Sequence[sp.Symbol], u: Sequence[sp.Symbol], forces: list[sp.Expr], ranges: Ranges
) -> tuple[sp.Symbol, sp.Expr]:
    """Return a first-order state and its rate, and add its force."""
    z, a, b, c = real("z"), parameter("alpha"), parameter("beta"), parameter("gamma")
    ranges |= {"z": (-0.3, 0.3), "alpha": (0.5, 3.0), "beta": (0.2, 2.0), "gamma": (0.05, 0.8)}
    way = int(rng.integers(8))
    rate = [
        a * u[0] - b * sp.Abs(u[0]) * z * sp.Abs(z) - c * u[0] * z**2,  # Bouc-Wen
        u[0] - a * sp.Abs(u[0]) * z / c,  # Dahl
        u[0] - a * sp.Abs(u[0]) / (c + sp.exp(-((u[0] / b) ** 2))) * z,  # LuGre
        sp.Max(sp.Min(a * (q[0] - z), c), -c),  # an actuator of limited rate
        a * (sp.Abs(q[0]) - z),
        a * (sp.Max(q[0], 0) - b * z),
        sp.Piecewise((a * (q[0] - c), q[0] > c), (a * (q[0] + c), q[0] < -c), (0, True)) - b * z,  # a dead zone
        a * (q[0] - z),
    ][way]
    forces[-1] -= [b * z, sp.Max(sp.Min(a * z, c), -c), b * sp.Abs(z), b * z][rng.integers(4)]
    return z, rate


def states(rng: np.random.Generator) -> RandomStructure:
    """First-order states: dynamic friction, saturated controllers."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.4))
    z, rate = _with_state(rng, q, u, forces, ranges)
    contacts = some_contacts(rng, u, ranges, 0, 2)
    return structure_of(q, u, forces, contacts, ranges, z=[z], z_rate=[rate])


def memory(rng: np.random.Generator) -> RandomStructure:
    """Contacts whose friction remembers: bristles and sliders, some beside a dry contact."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.4))
    if rng.random() < 0.5:
        ranges |= {"F": (0.2, 2.0), "Omega": (0.5, 5.0)}
        forces[0] += parameter("F") * sp.sin(parameter("Omega") * TIME)
    contacts = []
    for i, slip in enumerate(pair_of_slips(rng, u, 1 + int(rng.random() < 0.3), ranges)):
        names = ("N", "mu", "r", "w", "stiff", "damp")
        n, mu, r, w, stiff, damp = (parameter(f"{name}c{i + 1}") for name in names)
        ranges |= {n.name: (0.1, 1.5), mu.name: (0.1, 0.6), r.name: (0.01, 0.5), w.name: (0.1, 1.0)}
        ranges |= {stiff.name: (2.0, 30.0), damp.name: (0.01, 0.3)}
        law = [
            laws.dahl(mu, stiff),
            laws.dahl(mu, stiff, 2),
            laws.lugre(mu * (1 + r), mu, w, stiff, damp),
            laws.lugre(mu * (1 + r), mu, w, stiff),
            laws.elasto_plastic(mu * (1 + r), mu, w, stiff, damp, z_ba=mu / stiff / 2),
            laws.maxwell_slip([stiff, stiff / 2], [mu / 2, mu]),
        ][rng.integers(6)]
        contacts.append(Contact(f"c{i + 1}", slip, n, law))
    if rng.random() < 0.3:
        contacts.append(plain_contact(rng, "dry", u[-1], ranges))
    return structure_of(q, u, forces, contacts, ranges)


def masses(rng: np.random.Generator) -> RandomStructure:
    """Mass matrices that depend on the position, with the forces of inertia that belong to them."""
    n = 1 + int(rng.random() < 0.7)
    q, u, forces, ranges = oscillators(n)
    e, m = parameter("eps"), parameter("m")
    ranges |= {"eps": (0.1, 0.6), "m": (0.5, 2.0)}
    if n == 1:
        way = [1 + e * sp.cos(q[0]) / 2, 1 + e * q[0] ** 2, m / (1 + e * q[0] ** 2), m * sp.exp(e * q[0] / 2)]
        mass = sp.Matrix([[way[rng.integers(4)]]])
    else:
        coupling = [e * sp.cos(q[1]) / 2, e * sp.sin(q[0] - q[1]) / 2, e * q[0] / (1 + q[0] ** 2)][rng.integers(3)]
        mass = sp.Matrix([[1 + m, coupling], [coupling, 1]])
    for i in range(n):  # of Lagrange: -d(M u)/dq u + d(u'M u/2)/dq
        inertia = sum(
            (mass[j, k].diff(q[i]) / 2 - mass[i, j].diff(q[k])) * u[j] * u[k] for j in range(n) for k in range(n)
        )
        forces[i] += inertia
    contacts = some_contacts(rng, u, ranges, 1, 2)
    return structure_of(q, u, forces, contacts, ranges, mass=mass)


def sampled(rng: np.random.Generator) -> RandomStructure:
    """Sampled inputs: ground accelerations, and blows of one sample, some of which start late or end early."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.3))
    s, f = sp.Symbol("a_g", real=True), parameter("F")
    ranges |= {"F": (0.2, 2.0)}
    dt = float(rng.choice([0.05, 0.1, 0.125, 0.3]))
    count = int(rng.integers(4, int(5 / dt)))
    noise, wave, blows = rng.normal(0, 1, count), np.sin(np.arange(count) * dt * 4), (rng.random(count) < 0.1) * 2.0
    samples = (noise, wave, blows)[rng.integers(3)]
    signal = Signal(np.round(samples, 3), dt, float(rng.choice([0.0, 0.0, 0.4, -0.3])))
    forces[0] -= f * s * (1 + q[0] / 4 if rng.random() < 0.3 else 1)
    contacts = some_contacts(rng, u, ranges, 1, 2)
    if rng.random() < 0.4:
        ranges |= dict.fromkeys((q[0].name, u[0].name), (0.0, 0.0))
    return structure_of(q, u, forces, contacts, ranges, inputs={s: signal})


def smooth(rng: np.random.Generator) -> RandomStructure:
    """No contact: nonlinear springs, stops, play, saturation, with first-order states or without."""
    q, u, forces, ranges = oscillators(1 + int(rng.integers(3)))
    h, g = parameter("h"), parameter("g")
    ranges |= {"h": (0.3, 4.0), "g": (0.05, 0.5)}
    for i in range(len(q)):
        x, w = q[i], u[i]
        forces[i] += [
            h * (1 - x**2) * w,
            -h * x**3,
            -10 * h * sp.Max(x - g, 0),
            -h * w * sp.Abs(w),
            -h * sp.Piecewise((x - g, x > g), (x + g, x < -g), (0, True)),
            h * sp.Max(-g, sp.Min(g, 3 * w)),
            -h * sp.sin(3 * x),
            h * sp.cos(5 * TIME) * sp.Abs(x),
            -h * x * sp.sqrt(x**2 + g**2),
            sp.Integer(0),
        ][rng.integers(10)]
    z, rate = _with_state(rng, q, u, forces, ranges) if rng.random() < 0.4 else (None, None)
    if z is None:
        return structure_of(q, u, forces, [], ranges)
    return structure_of(q, u, forces, [], ranges, z=[z], z_rate=[rate])
