"""Effective friction in closed form: Lorentz, Gauss, Stribeck and square root, regularised Coulomb, straight lines.

``effective_friction.py`` proves that the package's integrals are the mean of a law under a fast vibration. Here these
means are found in closed form, with the slope at rest, which decides whether the vibration damps a slow motion. They
are also held against the package's integrals, evaluated by mpmath: 25 digits below, just below, at and above v = q.

To be read in the order `comparison`, `lorentz`, `exponentials`, `roots`.
"""

from derivations.effective_closed import exponentials, lorentz, roots
from derivations.ledger import joined

LEDGER = joined(
    "effective_closed",
    "The mean of friction over a fast vibration in closed form",
    lorentz,
    exponentials,
    roots,
)
