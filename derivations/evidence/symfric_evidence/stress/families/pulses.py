"""Narrow features: in time, in position, in speed and in load."""

from collections.abc import Callable

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import Contact
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

Shape = Callable[[sp.Expr], sp.Expr]
WIDTHS = (0.002, 0.2)
SHAPES: dict[str, Shape] = {  # pulse shapes of height and width about 1
    "Gauss": lambda s: sp.exp(-(s**2)),
    "sech": lambda s: 1 / sp.cosh(s),
    "quartic Lorentz": lambda s: 1 / (1 + s**4),
    "difference of tanh": lambda s: (sp.tanh(s + 1) - sp.tanh(s - 1)) / 2,
    "difference of erf": lambda s: (sp.erf(s + 1) - sp.erf(s - 1)) / 2,
    "bounded exponential": lambda s: sp.exp(1 / (1 + s**2)) - 1,
}
ARGUMENTS: dict[str, Callable[[sp.Expr, sp.Expr, sp.Expr], sp.Expr]] = {  # argument of a feature at p of width w
    "difference": lambda x, p, w: (x - p) / w,
    "logarithm": lambda x, p, w: sp.log((x + 1) / (p + 1)) / w,
    "sine": lambda x, p, w: sp.sin(x - p) / w,
    "square": lambda x, p, w: (x**2 - p**2) / w,
}


def _shape(rng: np.random.Generator) -> Shape:
    return list(SHAPES.values())[rng.integers(len(SHAPES))]


def _symbols(
    ranges: Ranges, place: tuple[float, float], *, signed: bool = True
) -> tuple[sp.Symbol, sp.Symbol, sp.Symbol]:
    p = real("p") if signed else parameter("p")
    w, a = parameter("w"), real("a")
    ranges |= {"p": place, "w": WIDTHS, "a": (-1.0, 1.0)}
    return p, w, a


def in_time(rng: np.random.Generator) -> RandomStructure:
    """A blow: a force of one impulse, however narrow; or a belt that jerks."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.3))
    p, w, a = _symbols(ranges, (0.2, 3.8))
    pulse = _shape(rng)((TIME - p) / w)
    contacts = some_contacts(rng, u, ranges, 0, 2)
    if contacts and rng.random() < 0.3:
        first = contacts[0]
        contacts[0] = Contact(first.name, first.slip - a * pulse, first.normal, first.law)
    else:
        forces[0] += a / w * pulse
    return structure_of(q, u, forces, contacts, ranges)


def in_position(rng: np.random.Generator) -> RandomStructure:
    """A narrow barrier of one energy, or a strip of another friction."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.3))
    p, w, a = _symbols(ranges, (-0.7, 0.7))
    pulse = _shape(rng)((q[0] - p) / w)
    contacts = some_contacts(rng, u, ranges, 0, 2)
    if contacts and rng.random() < 0.5:
        first = contacts[0]
        height = parameter("h")
        ranges["h"] = (0.5, 50.0)
        contacts[0] = Contact(first.name, first.slip, first.normal, first.law, 1 + height * pulse)
    else:
        forces[0] += a / (5 * w) * pulse
    return structure_of(q, u, forces, contacts, ranges)


def in_speed(rng: np.random.Generator) -> RandomStructure:
    """A law with a narrow feature, or a force with one in a velocity."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.3))
    p, w, a = _symbols(ranges, (0.15, 0.8), signed=False)
    way = list(ARGUMENTS.values())[rng.integers(len(ARGUMENTS))]
    contacts = some_contacts(rng, u, ranges, 0, 1)
    if rng.random() < 0.75:
        mu, n, b = parameter("mu"), parameter("N"), parameter("b")
        ranges |= {"mu": (0.1, 0.5), "N": (0.3, 1.5), "b": (0.01, 0.1)}
        height = parameter("h")
        ranges["h"] = (0.1, 1.0)
        law = laws.custom(mu - b * SPEED + b * SPEED**2 + height * _shape(rng)(way(SPEED, p, w)), mu + 2 * height)
        slip = pair_of_slips(rng, u, 1, ranges)[0]
        contacts.append(Contact("featured", slip, n, law))
    else:
        forces[0] += 4 * a * _shape(rng)((u[0] - p) / w)
    return structure_of(q, u, forces, contacts, ranges)


def in_load(rng: np.random.Generator) -> RandomStructure:
    """A normal load with a pulse in time or in position."""
    q, u, forces, ranges = oscillators(1 + int(rng.random() < 0.3))
    time = rng.random() < 0.6
    p, w, _ = _symbols(ranges, (0.2, 3.8) if time else (-0.7, 0.7))
    height = parameter("h")
    ranges["h"] = (0.3, 3.0)
    pulse = _shape(rng)(((TIME if time else q[0]) - p) / w)
    slips = pair_of_slips(rng, u, 1 + int(rng.random() < 0.4), ranges)
    contacts = [
        plain_contact(rng, f"c{i + 1}", slip, ranges, load=1 + height / sp.sqrt(w) * pulse if i == 0 else 1)
        for i, slip in enumerate(slips)
    ]
    return structure_of(q, u, forces, contacts, ranges)
