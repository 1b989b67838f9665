"""The families of random scenes."""

from symfric.bench.stress.families import loads, orbits, pulses, rescaled, surfaces, systems
from symfric.bench.stress.families.family import Family, RandomStructure, random_family
from symfric.bench.stress.random_scenes import Dice, structure
from symfric.errors import SceneError
from symfric.model.symbols import nearest


def _mixed(seed: int) -> RandomStructure:
    scene = structure(seed)
    return RandomStructure(scene, drawn=Dice(scene).draw)


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
    random_family("state", systems.states),
    random_family("mass", systems.masses),
    random_family("sampled", systems.sampled, runs=25),
    random_family("no-contact", systems.smooth),
    random_family("rescaled", rescaled.rescaled, runs=25),
    random_family("cycle", orbits.cycles, 10, weight=0.2, orbits="cycle"),
    random_family("branch", orbits.branches, 1, weight=0.01, orbits="branch"),
)
FAMILIES = {f.name: f for f in _TABLE}


def family(name: str) -> Family:
    """Return the family of a name."""
    if name not in FAMILIES:
        raise SceneError(f"no family of scenes is called {name!r}{nearest(name, FAMILIES)}")
    return FAMILIES[name]


__all__ = ["FAMILIES", "Family", "RandomStructure", "family"]
