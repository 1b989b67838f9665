"""The families of random scenes."""

from symfric.errors import SceneError
from symfric.model.symbols import nearest
from symfric_evidence.stress.families import instants, loads, orbits, pulses, redundant, rescaled, surfaces, systems
from symfric_evidence.stress.families.family import Family, RandomStructure, random_family
from symfric_evidence.stress.random_scenes import KINDS, Dice, structure


def _mixed(seed: int) -> RandomStructure:
    scene = structure(seed)
    return RandomStructure(scene, drawn=Dice(scene).draw)


def _moderate(seed: int) -> RandomStructure:
    """Return a mixed structure whose draws are all of moderate numbers, off the switching surfaces."""
    scene = structure(seed)
    dice = Dice(scene)
    return RandomStructure(scene, drawn=lambda seed, number: dice.draw(seed, len(KINDS) * number))


_TABLE = (
    Family("mixed", _mixed, runs=200),
    random_family("pulse-in-time", pulses.in_time),
    random_family("pulse-in-position", pulses.in_position),
    random_family("pulse-in-speed", pulses.in_speed),
    random_family("pulse-in-load", pulses.in_load),
    random_family("weak-load", loads.weak),
    random_family("vanishing-load", loads.vanishing),
    random_family("opening-load", loads.opening),
    random_family("cell-edge", surfaces.cell_edges),
    random_family("profile", surfaces.profiles),
    random_family("belt", surfaces.belts),
    random_family("parallel", surfaces.parallel),
    random_family("redundant", redundant.redundant),
    random_family("state", systems.states),
    random_family("memory", systems.memory),
    random_family("switched", loads.switched),
    random_family("mass", systems.masses),
    random_family("sampled", systems.sampled, runs=25),
    random_family("no-contact", systems.smooth),
    random_family("instants", instants.instants, runs=10, sought="instants"),
    random_family("rescaled", rescaled.rescaled, runs=25),
    Family("lanes", _mixed, runs=48, sought="lanes"),
    Family("derivatives", _moderate, runs=10, weight=0.2, sought="derivatives"),
    random_family("cycle", orbits.cycles, 10, weight=0.2, sought="cycle"),
    random_family("branch", orbits.branches, 1, weight=0.01, sought="branch"),
)
FAMILIES = {f.name: f for f in _TABLE}


def family(name: str) -> Family:
    """Return the family of a name."""
    if name not in FAMILIES:
        raise SceneError(f"no family of scenes is called {name!r}{nearest(name, FAMILIES)}")
    return FAMILIES[name]


__all__ = ["FAMILIES", "Family", "RandomStructure", "family"]
