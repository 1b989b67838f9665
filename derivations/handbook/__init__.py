"""Vibration and Shock Handbook, section 19.5: models of interface damping, and the mass that slides to rest.

To be read in the order `models`, `decay`, `stop`, `instability`.
"""

from derivations.handbook import decay, instability, models, stop
from derivations.ledger import joined

LEDGER = joined(
    "handbook",
    "de Silva (ed.), Vibration and Shock Handbook, Taylor & Francis 2005, section 19.5",
    models,
    decay,
    stop,
    instability,
)
