"""Scaling rolling friction effects in shaking table tests: the isolator's motion, the scale factors, similarity.

To be read in the order `structure`, `factors`, `cases`, `similarity`.
"""

from derivations.ledger import joined
from derivations.rolling_isolation import cases, factors, similarity, structure

LEDGER = joined(
    "rolling_isolation",
    "A numerical investigation on scaling rolling friction effects in shaking table model tests",
    structure,
    factors,
    cases,
    similarity,
)
