"""A family of scenes: a generator of structures, and of numbers for each."""

import math
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from symfric.model import laws
from symfric.model.outputs import Trajectory
from symfric.model.scene import Scene
from symfric.model.system import Contact, Signal, System
from symfric_evidence.stress.random_scenes import Draw

Ranges = dict[str, tuple[float, float]]
Units = tuple[float, float, float]  # of mass, length and time


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
    dimensions: dict[str, tuple[int, ...]] | None = None
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
        state, "cycle" for limit cycles, "branch" for branches of these, "instants" for motions with the
        foreign reference of events at known times.
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


def random_family(
    name: str,
    make: Callable[[np.random.Generator], RandomStructure],
    runs: int = 50,
    *,
    weight: float = 1.0,
    sought: str = "",
) -> Family:
    """Return the family whose structures follow from a generator of random numbers."""

    def build(seed: int) -> RandomStructure:
        return make(np.random.default_rng([zlib.crc32(name.encode()), seed]))

    return Family(name, build, runs, weight, sought)


def parameter(name: str) -> sp.Symbol:
    """Return a positive parameter."""
    return sp.Symbol(name, positive=True)


def real(name: str) -> sp.Symbol:
    """Return a real parameter or state."""
    return sp.Symbol(name, real=True)


def dimensioned() -> tuple[Ranges, dict[str, tuple[int, ...]], Callable[..., sp.Symbol]]:
    """Return ranges, dimensions, and ``number(name, low, high, *dimension)``, which enters a new parameter there."""
    ranges: Ranges = {}
    dimensions: dict[str, tuple[int, ...]] = {}

    def number(name: str, low: float, high: float, *dimension: int) -> sp.Symbol:
        ranges[name], dimensions[name] = (low, high), dimension
        return parameter(name) if low >= 0 else real(name)

    return ranges, dimensions, number


def oscillators(n: int) -> tuple[tuple[sp.Symbol, ...], tuple[sp.Symbol, ...], list[sp.Expr], Ranges]:
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


def structure_of(
    q: Sequence[sp.Symbol],
    u: Sequence[sp.Symbol],
    forces: Sequence[sp.Expr],
    contacts: Sequence[Contact],
    ranges: Ranges,
    horizon: float = 4.0,
    *,
    mass: sp.Matrix | None = None,
    z: Sequence[sp.Symbol] = (),
    z_rate: Sequence[sp.Expr] = (),
    inputs: Mapping[sp.Symbol, Signal] | None = None,
    exact: tuple[str, ...] = (),
) -> RandomStructure:
    """Return the structure of a scene with moderate numbers for all parameters that its expressions use."""
    system = System(q=q, u=u, mass=sp.eye(len(q)) if mass is None else mass, force=forces, z=z, z_rate=z_rate)
    used = set().union(*(e.free_symbols for e in system.expressions), *(c.free_symbols for c in contacts))
    names = {s.name for s in used} - {s.name for s in system.states} - {s.name for s in inputs or {}} - {"t"}
    middle = {name: _middle(*ranges[name]) for name in {*names, *(s.name for s in system.states)} & set(ranges)}
    values = {name: middle[name] for name in sorted(names & set(middle))}
    initial = {s: middle.get(s.name, 0.0) for s in system.states}
    scene = Scene(system, contacts, values, initial, horizon, {"path": Trajectory()}, inputs or {})
    known = {s.name for s in (*scene.parameters, *system.states)}
    return RandomStructure(scene, {k: v for k, v in ranges.items() if k in known}, exact=exact)


def _middle(low: float, high: float) -> float:
    return float(np.sqrt(low * high)) if low > 0 else 0.6 * high + 0.4 * low


def plain_contact(
    rng: np.random.Generator, name: str, slip: sp.Expr, ranges: Ranges, load: sp.Expr = 1, profile: sp.Expr = 1
) -> Contact:
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


def some_contacts(
    rng: np.random.Generator, u: Sequence[sp.Symbol], ranges: Ranges, least: int, most: int
) -> list[Contact]:
    """Return a number of contacts with slips and laws of any kind."""
    slips = pair_of_slips(rng, u, int(rng.integers(least, most + 1)), ranges)
    return [plain_contact(rng, f"c{i + 1}", slip, ranges) for i, slip in enumerate(slips)]


def pair_of_slips(rng: np.random.Generator, u: Sequence[sp.Symbol], count: int, ranges: Ranges) -> list[sp.Expr]:
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
