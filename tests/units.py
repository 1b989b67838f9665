"""Scenes written in other units of mass, length and time."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

import symfric as sf
from symfric.model.laws import Law
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import Contact, System

Dimension = tuple[int, int, int]  # powers of mass, length and time


@dataclass(frozen=True)
class Units:
    """Units of mass, length and time that are 10 to these powers times smaller, so that numbers become larger.

    They are powers of ten so that expressions stay exact: a slip ``u - v_b`` remains one.
    """

    mass: int
    length: int
    time: int

    @classmethod
    def drawn(cls, rng: np.random.Generator, reach: int = 6) -> "Units":
        """Return units with powers between minus and plus `reach`."""
        return cls(*(int(e) for e in rng.integers(-reach, reach + 1, 3)))

    def exactly(self, dimension: Dimension) -> sp.Rational:
        """Return by how much a number of a dimension is larger."""
        return sp.Integer(10) ** int(np.dot((self.mass, self.length, self.time), dimension))

    def of(self, dimension: Dimension) -> float:
        """Return the same as a float."""
        return float(self.exactly(dimension))

    def states(self, scene: Scene, dimensions: Mapping[str, Dimension] | None = None) -> np.ndarray:
        """Return the same for every state of a scene, shape (n_x,); further states are numbers unless said."""
        return np.array([self.of(d) for d in _of_states(scene, dimensions or {}).values()])

    def written(self, scene: Scene, dimensions: Mapping[str, Dimension] | None = None) -> Scene:
        """Return a scene in these units.

        Parameters
        ----------
        scene : Scene
            Of one unit of length for all coordinates; its outputs are left out.
        dimensions : mapping of str to Dimension, optional
            Of parameters and of first-order states; numbers unless given.
        """
        dimensions = dict(dimensions or {})
        states = _of_states(scene, dimensions)
        scale = {s: self.exactly(d) for s, d in states.items()}
        scale |= {p: self.exactly(dimensions.get(p.name, (0, 0, 0))) for p in scene.values}
        scale[TIME] = self.exactly((0, 0, 1))
        old = {s: s / factor for s, factor in scale.items() if factor != 1}
        force, speed = self.exactly((1, 1, -2)), self.exactly((0, 1, -1))

        def new(e, factor) -> sp.Expr:
            return sp.expand(factor * sp.sympify(e).xreplace(old))

        system = scene.system
        rates = [scale[s] / scale[TIME] for s in system.z]
        moved = System(
            q=system.q,
            u=system.u,
            mass=(system.mass.xreplace(old)) * self.exactly((1, 0, 0)),
            force=[new(e, force) for e in system.force],
            z=system.z,
            z_rate=[new(e, rate) for e, rate in zip(system.z_rate, rates, strict=True)],
        )
        contacts = [
            Contact(c.name, new(c.slip, speed), new(c.normal, force), _law(c.law, old, speed), c.profile.xreplace(old))
            for c in scene.contacts
        ]
        return Scene(
            system=moved,
            contacts=contacts,
            values={p: v if v is None else v * float(scale[p]) for p, v in scene.values.items()},
            initial={s: new(e, scale[s]) for s, e in scene.initial.items()},
            horizon=scene.horizon * self.of((0, 0, 1)),
            outputs={"end": sf.End()},
        )


def _of_states(scene: Scene, dimensions: Mapping[str, Dimension]) -> dict[sp.Symbol, Dimension]:
    system = scene.system
    found = dict.fromkeys(system.q, (0, 1, 0)) | dict.fromkeys(system.u, (0, 1, -1))
    return found | {s: dimensions.get(s.name, (0, 0, 0)) for s in system.z}


def _law(law: Law, old: dict, speed: sp.Rational) -> Law:
    inside = {**old, SPEED: SPEED / speed}
    breaks = {
        name: tuple(speed * sp.sympify(b).xreplace(old) for b in getattr(law, name)) for name in ("breaks", "steep")
    }
    kinetic, stick = sp.sympify(law.kinetic).xreplace(inside), sp.sympify(law.stick).xreplace(old)
    if isinstance(kinetic, sp.Piecewise):  # its conditions hold speeds against breaks
        kinetic = sp.Piecewise(
            *((e, c if c in (True, sp.true) else c.func(speed * c.lhs, speed * c.rhs)) for e, c in kinetic.args)
        )
    return replace(law, kinetic=kinetic, stick=stick, **breaks)
