"""A family of scenes: a generator of structures, and of numbers for each."""

import math
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.outputs import Trajectory
from symfric.model.scene import Scene
from symfric.model.system import Contact, System
from symfric_evidence.stress.random_scenes import Draw

Ranges = dict[str, tuple[float, float]]
Units = tuple[float, float, float]  # of mass, length and time
Adjust = Callable[[np.random.Generator, dict[str, float], dict[str, float]], None]


@dataclass(frozen=True)
class RandomStructure:
    """Equations with parameters, and the distributions of these.

    Attributes
    ----------
    scene : Scene
    ranges : dict of name to (low, high)
        Of parameters and starts; what is below zero or begins there is drawn uniformly, the rest by its logarithm.
    choices : dict of name to tuple of float
        Parameters and starts that take one of a few values.
    adjust : callable, optional
        ``adjust(rng, values, initial)`` changes the numbers drawn.
    dimensions : dict of name to (mass, length, time), optional
        Exponents of every parameter and state; given where the package runs the scene in other units.
    time_unit : float
        Of those units; those of mass and length are drawn for each run.
    exact : tuple of str
        States and parameters whose numbers are meant as they are, such as a start on an edge: they are not perturbed
        to see whether a motion is sensitive.
    drawn : callable, optional
        ``drawn(seed, number) -> Draw``, in place of the ranges.
    """

    scene: Scene
    ranges: Ranges = field(default_factory=dict)
    choices: dict[str, tuple[float, ...]] = field(default_factory=dict)
    adjust: Adjust | None = None
    dimensions: dict[str, tuple[int, int, int]] | None = None
    time_unit: float = 1.0
    exact: tuple[str, ...] = ()
    drawn: Callable[[int, int], Draw] | None = None

    def draw(self, rng: np.random.Generator) -> Draw:
        """Return numbers for every parameter and the start."""
        numbers = {}
        for name in sorted({*self.ranges, *self.choices}):
            if name in self.choices:
                numbers[name] = float(rng.choice(self.choices[name]))
                continue
            low, high = self.ranges[name]
            logarithmic = low > 0 and high > 20 * low
            numbers[name] = float(np.exp(rng.uniform(*np.log((low, high)))) if logarithmic else rng.uniform(low, high))
        states = {s.name for s in self.scene.system.states}
        values = {k: v for k, v in numbers.items() if k not in states}
        initial = {k: v for k, v in numbers.items() if k in states}
        if self.adjust is not None:
            self.adjust(rng, values, initial)
        return Draw("", values, initial)

    def units(self, seed: int, number: int) -> Units:
        """Return the units of mass, length and time that the package's run is stated in."""
        if self.dimensions is None:
            return 1.0, 1.0, 1.0
        mass, length = 10.0 ** np.random.default_rng([seed, number, 2]).uniform(-6, 6, 2)
        return float(mass), float(length), self.time_unit

    def in_units(self, draw: Draw, units: Units) -> tuple[dict[str, float], dict[str, float]]:
        """Return values and start in the units of the package's run."""
        if self.dimensions is None:
            return draw.values, draw.initial
        values, initial = (
            {k: v * self._unit(k, units) for k, v in part.items()} for part in (draw.values, draw.initial)
        )
        return values, initial

    def state_units(self, units: Units) -> np.ndarray:
        """Return the unit of every state."""
        states = self.scene.system.states
        return (
            np.ones(len(states)) if self.dimensions is None else np.array([self._unit(s.name, units) for s in states])
        )

    def _unit(self, name: str, units: Units) -> float:
        assert self.dimensions is not None
        return math.prod(unit**power for unit, power in zip(units, self.dimensions[name], strict=True))


@dataclass(frozen=True)
class Family:
    """A family of scenes.

    Attributes
    ----------
    name : str
    build : callable
        ``build(seed) -> Structure``.
    runs : int
        Draws of numbers for each structure, whose compilation takes as long as some dozens of runs.
    weight : float
        Share of a stress run, relative to that of the others.
    sought : str
        What is compared: "" for motions, "lanes" for many cases at once with single runs, "derivatives" of the final
        state, "cycle" for limit cycles, "branch" for branches of these.
    """

    name: str
    build: Callable[[int], RandomStructure]
    runs: int = 50
    weight: float = 1.0
    sought: str = ""

    def draw(self, structure: RandomStructure, seed: int, number: int) -> Draw:
        """Return the numbers of one run; the same for the same seed of the structure and number of the run."""
        if structure.drawn is not None:
            return structure.drawn(seed, number)
        return structure.draw(np.random.default_rng([zlib.crc32(self.name.encode()), seed, number, 1]))


def random_family(name: str, make: Callable[[np.random.Generator], RandomStructure], *args, **options) -> Family:
    """Return the family whose structures follow from a generator of random numbers."""
    return Family(name, lambda seed: make(np.random.default_rng([zlib.crc32(name.encode()), seed])), *args, **options)


def parameter(name: str) -> sp.Symbol:
    """Return a positive parameter."""
    return sp.Symbol(name, positive=True)


def real(name: str) -> sp.Symbol:
    """Return a real parameter or state."""
    return sp.Symbol(name, real=True)


def oscillators(n: int):
    """Return coordinates, velocities, and forces of springs and dampers, each mass coupled to the next.

    Returns
    -------
    q, u : tuples of Symbol
    forces : list of Expr
    ranges : dict
    """
    q, u = (tuple(real(f"{name}{i + 1}") for i in range(n)) for name in "xu")
    forces: list[sp.Expr] = []
    ranges: Ranges = {}
    for i in range(n):
        k, d = parameter(f"k{i + 1}"), parameter(f"d{i + 1}")
        forces.append(-k * q[i] - d * u[i])
        ranges |= {k.name: (0.5, 4.0), d.name: (0.02, 0.2), q[i].name: (-1.0, 1.0), u[i].name: (-1.0, 1.0)}
    for i in range(n - 1):
        k = parameter(f"kc{i + 1}")
        ranges[k.name] = (0.2, 2.0)
        forces[i] -= k * (q[i] - q[i + 1])
        forces[i + 1] += k * (q[i] - q[i + 1])
    return q, u, forces, ranges


def scene_of(q, u, forces, contacts, ranges: Ranges, horizon=4.0, *, mass=None, z=(), z_rate=(), inputs=None) -> Scene:
    """Return a scene with moderate numbers for all parameters that its expressions use."""
    system = System(q=q, u=u, mass=sp.eye(len(q)) if mass is None else mass, force=forces, z=z, z_rate=z_rate)
    used = set().union(*(e.free_symbols for e in system.expressions), *(c.free_symbols for c in contacts))
    names = {s.name for s in used} - {s.name for s in system.states} - {s.name for s in inputs or {}} - {"t"}
    middle = {name: _middle(*ranges[name]) for name in {*names, *(s.name for s in system.states)} & set(ranges)}
    values = {name: middle[name] for name in sorted(names & set(middle))}
    initial = {s: middle.get(s.name, 0.0) for s in system.states}
    return Scene(system, contacts, values, initial, horizon, {"path": Trajectory()}, inputs or {})


def _middle(low: float, high: float) -> float:
    return float(np.sqrt(low * high)) if low > 0 else 0.6 * high + 0.4 * low


def structure_of(*args, dimensions=None, time_unit: float = 1.0, exact=(), **options) -> RandomStructure:
    """Return the structure of the scene that `scene_of` makes of the same arguments."""
    scene, ranges = scene_of(*args, **options), args[4]
    names = {s.name for s in (*scene.parameters, *scene.system.states)}
    used = {k: v for k, v in ranges.items() if k in names}
    return RandomStructure(scene, used, dimensions=dimensions, time_unit=time_unit, exact=tuple(exact))


def plain_contact(rng: np.random.Generator, name: str, slip: sp.Expr, ranges: Ranges, load=1, profile=1) -> Contact:
    """Return a contact with one of the usual laws and parameters of its own."""
    n, mu, r, w = (parameter(f"{p}{name}") for p in ("N", "mu", "r", "w"))
    ranges |= {n.name: (0.1, 1.5), mu.name: (0.1, 0.6), r.name: (0.01, 0.5), w.name: (0.1, 1.0)}
    law = [
        laws.coulomb(mu),
        laws.coulomb(mu * (1 + r), mu),
        laws.stribeck(mu * (1 + r), mu, w),
        laws.cubic(mu * (1 + r), mu, w),
        laws.lorentz(mu, w, mu * (1 + r)),
        laws.exponential(mu, w),
    ][rng.integers(6)]
    return Contact(name, slip, n * load, law, profile)


def pair_of_slips(rng: np.random.Generator, u, count: int, ranges: Ranges) -> list[sp.Expr]:
    """Return slips of contacts: bodies on the ground, on belts, and on each other."""
    slips = []
    for i in range(count):
        a = int(rng.integers(len(u)))
        slip = u[a]
        if len(u) > 1 and rng.random() < 0.3:
            slip = u[a] - u[(a + 1) % len(u)]
        if rng.random() < 0.6:
            v = real(f"v{i + 1}")
            ranges[v.name] = (-0.5, 0.5)
            slip -= v
        slips.append(slip)
    return slips
