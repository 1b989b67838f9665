"""Limit cycles of stick-slip motion, stable and unstable, and their Floquet multipliers."""

from symfric.orbits.cycle.orbit import Orbit
from symfric.orbits.cycle.properties import multipliers_of, orbit_of
from symfric.orbits.cycle.search import found_cycle, limit_cycle, orbit_at, read_guess, values_of

__all__ = [
    "Orbit",
    "found_cycle",
    "limit_cycle",
    "multipliers_of",
    "orbit_at",
    "orbit_of",
    "read_guess",
    "values_of",
]
