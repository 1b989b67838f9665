"""Sliding in the plane: friction against a slip vector, ``-mu(S) N s/S``."""

from derivations.ledger import joined
from derivations.plane import bodies, disc, vibration

LEDGER = joined(
    "plane",
    "Sliding in the plane: friction against the slip vector (P. Contensou 1963; R. I. Leine, C. Glocker 2003; "
    "Z. Farkas and others 2003); formulas as `symfric.theory.plane` and `Law.averaged_across` have them.",
    vibration,
    disc,
    bodies,
)
